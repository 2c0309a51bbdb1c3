//! Where pixels are stored: tile by tile, without padding.

use core::ops::Range;

/// Side of a tile in pixels.
pub const TILE: u32 = 16;
/// Longest side of a film in pixels.
pub const MAX_SIDE: u32 = 16_384;

/// Where a pixel is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    width: u32,
    height: u32,
}

/// One tile of a film.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Leftmost column.
    pub x0: u32,
    /// Uppermost row.
    pub y0: u32,
    /// Columns, at most [`TILE`].
    pub width: u32,
    /// Rows, at most [`TILE`].
    pub height: u32,
    /// Storage index of the first pixel.
    pub first: usize,
}

impl Tile {
    /// Number of pixels.
    #[inline]
    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Storage indices of row `dy` of the tile.
    #[inline]
    pub fn row(&self, dy: u32) -> Range<usize> {
        let first = self.first + (dy * self.width) as usize;
        first..first + self.width as usize
    }
}

impl Layout {
    /// The layout of a film, or nothing if a side is 0 or longer than [`MAX_SIDE`].
    pub fn new(width: u32, height: u32) -> Option<Layout> {
        let fits = |side| (1..=MAX_SIDE).contains(&side);
        (fits(width) && fits(height)).then_some(Layout { width, height })
    }

    /// Columns.
    #[inline]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    #[inline]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Number of pixels.
    #[inline]
    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Number of tiles.
    #[inline]
    pub fn tiles(&self) -> u32 {
        self.width.div_ceil(TILE) * self.height.div_ceil(TILE)
    }

    /// Tile number `t`, in raster order. `t` must be less than [`tiles`](Self::tiles).
    #[inline]
    pub fn tile(&self, t: u32) -> Tile {
        let columns = self.width.div_ceil(TILE);
        let (x0, y0) = (t % columns * TILE, t / columns * TILE);
        let (width, height) = (TILE.min(self.width - x0), TILE.min(self.height - y0));
        let first = y0 as usize * self.width as usize + x0 as usize * height as usize;
        Tile { x0, y0, width, height, first }
    }

    /// Storage index of the pixel in column `x` and row `y`.
    #[inline]
    pub fn index(&self, x: u32, y: u32) -> usize {
        let (x0, y0) = (x & !(TILE - 1), y & !(TILE - 1));
        let (width, height) = (TILE.min(self.width - x0), TILE.min(self.height - y0));
        let tile = y0 as usize * self.width as usize + x0 as usize * height as usize;
        tile + ((y - y0) * width + (x - x0)) as usize
    }

    /// Where pixel `i` of the storage is: tile number, column and row in the tile. `i` must be less than
    /// [`pixels`](Self::pixels).
    pub fn place(&self, i: usize) -> (u32, u32, u32) {
        let (side, width) = (TILE as usize, self.width as usize);
        let row = i / (side * width);
        let height = side.min(self.height as usize - row * side);
        let inside = i - row * side * width;
        let column = inside / (side * height);
        let across = side.min(width - column * side);
        let inside = inside - column * side * height;
        let tile = row as u32 * self.width.div_ceil(TILE) + column as u32;
        (tile, (inside % across) as u32, (inside / across) as u32)
    }

    /// Storage index of the first pixel of a tile, and one after the last pixel of all for what would come after the last tile.
    pub(crate) fn start(&self, tile: u32) -> usize {
        if tile < self.tiles() { self.tile(tile).first } else { self.pixels() }
    }

    /// Calls `f(storage, raster)` for every tile row: a run of storage indices and where it starts in raster order.
    pub fn for_each_run(&self, f: impl FnMut(Range<usize>, usize)) {
        self.for_each_run_of(0..self.tiles(), f);
    }

    /// [`for_each_run`](Self::for_each_run) of some tiles alone.
    pub(crate) fn for_each_run_of(&self, tiles: Range<u32>, mut f: impl FnMut(Range<usize>, usize)) {
        for tile in tiles.map(|t| self.tile(t)) {
            for dy in 0..tile.height {
                let raster = (tile.y0 + dy) as usize * self.width as usize + tile.x0 as usize;
                f(tile.row(dy), raster);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_has_one_place() {
        for (width, height) in [(1, 1), (16, 16), (17, 1), (1, 33), (40, 50), (100, 3)] {
            let layout = Layout::new(width, height).unwrap();
            let mut next = 0;
            for tile in (0..layout.tiles()).map(|t| layout.tile(t)) {
                assert_eq!(tile.first, next);
                for (dy, dx) in (0..tile.height).flat_map(|y| (0..tile.width).map(move |x| (y, x))) {
                    assert_eq!(layout.index(tile.x0 + dx, tile.y0 + dy), next);
                    let (t, x, y) = layout.place(next);
                    assert_eq!((layout.tile(t), x, y), (tile, dx, dy));
                    next += 1;
                }
            }
            assert_eq!(next, layout.pixels());
            assert_eq!((layout.start(0), layout.start(layout.tiles())), (0, next));
        }
    }

    #[test]
    fn sides_are_limited() {
        assert_eq!(Layout::new(0, 5), None);
        assert_eq!(Layout::new(5, 0), None);
        assert_eq!(Layout::new(MAX_SIDE + 1, 5), None);
        assert!(Layout::new(MAX_SIDE, MAX_SIDE).is_some());
    }
}
