//! Sums over 3 × 3 pixels of the film, a tile at a time, eight pixels at a time.
//!
//! A tile and the pixels around it are copied into a small raster [`Block`]; beyond the film it holds zeros, so
//! windows at the border sum over the pixels that exist.

use super::{Layout, TILE, Tile, luminance};
use core::ops::Range;
use wide::f32x8;

/// Rows of a block: a tile and one more at each end.
const ROWS: usize = TILE as usize + 2;
/// Columns of a block: column 0 is left of the tile; the last ones are only read with lanes that are not used.
const COLUMNS: usize = TILE as usize + 8;

/// A tile of one quantity with the pixels around it.
pub(crate) type Block = [[f32; COLUMNS]; ROWS];

/// Which pixels a window sums over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Window {
    /// The pixel alone, as the paper does.
    Pixel,
    /// The pixel and its eight neighbours.
    #[default]
    Square3,
}

impl Window {
    /// Sums around the eight pixels of `block` that start in row `y` and column `x` of the tile.
    #[inline(always)]
    pub(crate) fn sum(self, block: &Block, x: usize, y: usize) -> f32x8 {
        match self {
            Window::Pixel => eight(&block[y + 1], x + 1),
            Window::Square3 => square3(block, x, y),
        }
    }
}

/// Sums over 3 × 3 pixels around the eight pixels that start in row `y` and column `x` of the tile.
#[inline(always)]
fn square3(block: &Block, x: usize, y: usize) -> f32x8 {
    let row = |y: usize| eight(&block[y], x) + eight(&block[y], x + 1) + eight(&block[y], x + 2);
    row(y) + row(y + 1) + row(y + 2)
}

#[inline(always)]
fn eight(row: &[f32; COLUMNS], x: usize) -> f32x8 {
    let mut lanes = [0.0; 8];
    lanes.copy_from_slice(&row[x..x + 8]);
    f32x8::from(lanes)
}

/// Where the pixels of a block are stored.
pub(crate) struct Around {
    rows: [Option<Row>; ROWS],
}

/// Storage of one row of a block.
#[derive(Clone)]
struct Row {
    left: Option<usize>,
    middle: Range<usize>,
    right: Option<usize>,
}

impl Around {
    /// Finds the surroundings of `tile`.
    pub fn new(layout: &Layout, tile: &Tile) -> Around {
        let right = tile.x0 + tile.width;
        let row = |y: u32| {
            let first = layout.index(tile.x0, y);
            Row {
                left: (tile.x0 > 0).then(|| layout.index(tile.x0 - 1, y)),
                middle: first..first + tile.width as usize,
                right: (right < layout.width()).then(|| layout.index(right, y)),
            }
        };
        let rows = core::array::from_fn(|i| {
            let y = (tile.y0 + i as u32).checked_sub(1)?;
            (y < layout.height() && i as u32 <= tile.height + 1).then(|| row(y))
        });
        Around { rows }
    }

    /// The block of the quantity that `value` makes of a plane.
    #[inline(always)]
    pub fn load<T: Copy>(&self, plane: &[T], value: impl Fn(T) -> f32) -> Block {
        let mut block = [[0.0; COLUMNS]; ROWS];
        for (row, out) in self.rows.iter().zip(&mut block) {
            let Some(row) = row else { continue };
            if let Some(left) = row.left {
                out[0] = value(plane[left]);
            }
            if let Some(right) = row.right {
                out[row.middle.len() + 1] = value(plane[right]);
            }
            let middle = &plane[row.middle.clone()];
            match middle.first_chunk::<{ TILE as usize }>() {
                // A whole row of a tile: its length is known, so this becomes two vector instructions.
                Some(whole) => (0..TILE as usize).for_each(|k| out[k + 1] = value(whole[k])),
                None => out[1..].iter_mut().zip(middle).for_each(|(out, new)| *out = value(*new)),
            }
        }
        block
    }
}

/// The luminance of blocks of red, green and blue.
#[inline(always)]
pub(crate) fn block_luminance([r, g, b]: &[Block; 3]) -> Block {
    let mut light = [[0.0; COLUMNS]; ROWS];
    for y in 0..ROWS {
        for x in 0..COLUMNS {
            light[y][x] = luminance([r[y][x], g[y][x], b[y][x]]);
        }
    }
    light
}

/// Writes as many lanes as there is room for, up to eight.
#[inline(always)]
pub(crate) fn write8(to: &mut [f32], value: f32x8) {
    let lanes = value.to_array();
    match to.first_chunk_mut::<8>() {
        Some(whole) => *whole = lanes,
        None => to.iter_mut().zip(lanes).for_each(|(to, lane)| *to = lane),
    }
}
