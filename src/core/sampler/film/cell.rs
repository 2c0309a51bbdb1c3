//! Cells of 8 × 8 pixels, four to a tile: what is smooth over dozens of pixels is computed once a cell.

use super::layout::Layout;
use core::ops::Range;

/// Side of a cell in pixels.
pub(crate) const CELL: usize = 8;

/// One cell of a film. At the right and lower edge a cell can be smaller.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    /// Column and row in the grid of cells.
    pub x: usize,
    /// See [`x`](Self::x).
    pub y: usize,
    /// Columns of pixels.
    pub width: usize,
    /// Rows of pixels.
    pub height: usize,
    /// Storage index of the first pixel, and from one row to the next.
    first: usize,
    stride: usize,
}

impl Cell {
    /// Storage indices of row `dy` of the cell.
    #[inline(always)]
    pub fn row(&self, dy: usize) -> Range<usize> {
        let first = self.first + dy * self.stride;
        first..first + self.width
    }

    /// Where row `dy` of the cell is in a picture `width` pixels wide, stored row by row.
    #[inline(always)]
    pub fn raster(&self, dy: usize, width: usize) -> Range<usize> {
        let first = (self.y * CELL + dy) * width + self.x * CELL;
        first..first + self.width
    }
}

impl Layout {
    /// Columns and rows of the grid of cells.
    pub(crate) fn grid(&self) -> (usize, usize) {
        ((self.width() as usize).div_ceil(CELL), (self.height() as usize).div_ceil(CELL))
    }

    /// Calls `f` for all cells, in the order of their tiles.
    #[inline(always)]
    pub(crate) fn for_each_cell(&self, mut f: impl FnMut(Cell)) {
        for tile in (0..self.tiles()).map(|t| self.tile(t)) {
            let (width, height) = (tile.width as usize, tile.height as usize);
            for y in (0..height).step_by(CELL) {
                for x in (0..width).step_by(CELL) {
                    f(Cell {
                        x: (tile.x0 as usize + x) / CELL,
                        y: (tile.y0 as usize + y) / CELL,
                        width: CELL.min(width - x),
                        height: CELL.min(height - y),
                        first: tile.first + y * width + x,
                        stride: width,
                    });
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_cover_every_pixel_once() {
        for (width, height) in [(1, 1), (16, 16), (17, 9), (8, 33), (40, 50), (100, 3)] {
            let layout = Layout::new(width, height).unwrap();
            let (columns, rows) = layout.grid();
            let mut covered = 0;
            layout.for_each_cell(|cell| {
                assert!(cell.x < columns && cell.y < rows);
                for dy in 0..cell.height {
                    let (row, raster) = (cell.row(dy), cell.raster(dy, width as usize));
                    assert_eq!(row.len(), raster.len());
                    for (stored, raster) in row.zip(raster) {
                        let (x, y) = (raster as u32 % width, raster as u32 / width);
                        assert_eq!(stored, layout.index(x, y));
                        covered += 1;
                    }
                }
            });
            assert_eq!(covered, layout.pixels());
        }
    }
}
