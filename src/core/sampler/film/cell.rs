//! Cells of 8 × 8 pixels, four to a tile: what is smooth over dozens of pixels is computed once a cell.

use super::layout::{Layout, TILE};
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
    /// Index of the first pixel in a picture of the film's size, stored row by row.
    raster: usize,
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

    /// Where row `dy` of the cell is in a picture of the film's size, `width` pixels wide, stored row by row.
    #[inline(always)]
    pub fn raster(&self, dy: usize, width: usize) -> Range<usize> {
        let first = self.raster + dy * width;
        first..first + self.width
    }
}

/// A rectangle of tiles: columns and rows of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Region {
    pub columns: Range<u32>,
    pub rows: Range<u32>,
}

impl Region {
    /// All tiles.
    pub fn all(layout: &Layout) -> Region {
        Region { columns: 0..layout.width().div_ceil(TILE), rows: 0..layout.height().div_ceil(TILE) }
    }

    /// Rows of its grid of cells that belong to some of its rows of tiles.
    pub fn cell_rows(&self, layout: &Layout, rows: &Range<u32>) -> Range<usize> {
        let cells = |tiles: u32| (tiles - self.rows.start) as usize * (TILE as usize / CELL);
        cells(rows.start)..cells(rows.end).min(self.grid(layout).1)
    }

    /// Columns and rows of its grid of cells.
    pub fn grid(&self, layout: &Layout) -> (usize, usize) {
        let cells = |tiles: &Range<u32>, side: u32| {
            ((TILE * tiles.end).min(side) - TILE * tiles.start).div_ceil(CELL as u32) as usize
        };
        (cells(&self.columns, layout.width()), cells(&self.rows, layout.height()))
    }
}

impl Layout {
    /// Calls `f` for the cells in some `rows` of tiles of a region, in the order of their tiles; their columns and rows count
    /// from the region's corner.
    #[inline(always)]
    pub(crate) fn for_each_cell(&self, region: &Region, rows: Range<u32>, mut f: impl FnMut(Cell)) {
        let across = self.width().div_ceil(TILE);
        let tiles = rows.flat_map(|y| region.columns.clone().map(move |x| y * across + x));
        let (left, top) = (TILE * region.columns.start, TILE * region.rows.start);
        for tile in tiles.map(|t| self.tile(t)) {
            let (width, height) = (tile.width as usize, tile.height as usize);
            for y in (0..height).step_by(CELL) {
                for x in (0..width).step_by(CELL) {
                    f(Cell {
                        x: ((tile.x0 - left) as usize + x) / CELL,
                        y: ((tile.y0 - top) as usize + y) / CELL,
                        raster: (tile.y0 as usize + y) * self.width() as usize + tile.x0 as usize + x,
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
            let all = Region::all(&layout);
            let (columns, rows) = all.grid(&layout);
            let mut covered = 0;
            let middle = all.rows.end / 2;
            let halves = [0..middle, middle..all.rows.end];
            halves.into_iter().for_each(|half| {
                layout.for_each_cell(&all, half.clone(), |cell| {
                    assert!(cell.x < columns && cell.y < rows);
                    assert!(all.cell_rows(&layout, &half).contains(&cell.y));
                    for dy in 0..cell.height {
                        let (row, raster) = (cell.row(dy), cell.raster(dy, width as usize));
                        assert_eq!(row.len(), raster.len());
                        for (stored, raster) in row.zip(raster) {
                            let (x, y) = (raster as u32 % width, raster as u32 / width);
                            assert_eq!(stored, layout.index(x, y));
                            covered += 1;
                        }
                    }
                })
            });
            assert_eq!(covered, layout.pixels());
        }
    }
}
