//! Sums over 3 × 3 pixels of the film, a tile at a time.
//!
//! A tile and the pixels around it are copied into a small raster [`Block`]; beyond the film it holds zeros, so
//! windows at the border sum over the pixels that exist.

use super::{Layout, TILE, Tile};
use core::ops::Range;
use wide::f32x8;

/// Side of a tile.
const SIDE: usize = TILE as usize;
/// Rows of a block: a tile and one more at each end.
const ROWS: usize = SIDE + 2;
/// Columns of a block: column 0 is left of the tile, the last ones fill the third vector up.
const COLUMNS: usize = SIDE + 8;

/// A tile of one quantity with the pixels around it.
pub(crate) type Block = [[f32; COLUMNS]; ROWS];
/// A quantity of every pixel of a tile.
pub(crate) type Inner = [[f32; SIDE]; SIDE];

/// Which pixels a window sums over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Window {
    /// The pixel alone, as the paper does.
    Pixel,
    /// The pixel and its eight neighbours, by binomial weights: 4 for itself, 2 and 1.
    #[default]
    Square3,
}

impl Window {
    /// How many times it counts a degree of freedom, if all its pixels have equally many: Σw²/Σw.
    pub(crate) fn weight(self) -> f32 {
        match self {
            Window::Pixel => 1.0,
            Window::Square3 => 2.25,
        }
    }

    /// Sums around every pixel of the tile.
    #[inline]
    pub(crate) fn sums(self, block: &Block) -> Inner {
        match self {
            Window::Pixel => inner(block),
            Window::Square3 => square3(block),
        }
    }
}

/// The tile without the pixels around it.
pub(crate) fn inner(block: &Block) -> Inner {
    core::array::from_fn(|y| core::array::from_fn(|x| block[y + 1][x + 1]))
}

/// Sums over 3 × 3 pixels, weighted 1, 2, 1 each way: three rows into one, then three columns.
fn square3(block: &Block) -> Inner {
    let mut sums = [[0.0; SIDE]; SIDE];
    for (y, sums) in sums.iter_mut().enumerate() {
        let rows: &[[f32; COLUMNS]; 3] = block[y..].first_chunk().expect("two rows more than the tile");
        let mut column = [0.0; COLUMNS];
        (0..COLUMNS).for_each(|x| column[x] = rows[0][x] + 2.0 * rows[1][x] + rows[2][x]);
        (0..SIDE).for_each(|x| sums[x] = column[x] + 2.0 * column[x + 1] + column[x + 2]);
    }
    sums
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
            match middle.first_chunk::<SIDE>() {
                // A whole row of a tile: its length is known, so this becomes two vector instructions.
                Some(whole) => (0..SIDE).for_each(|k| out[k + 1] = value(whole[k])),
                None => out[1..].iter_mut().zip(middle).for_each(|(out, new)| *out = value(*new)),
            }
        }
        block
    }
}

/// The block of what `f` makes of the values of others.
#[inline(always)]
pub(crate) fn combine<const N: usize>(blocks: [&Block; N], f: impl Fn([f32; N]) -> f32) -> Block {
    let mut result = [[0.0; COLUMNS]; ROWS];
    for (y, row) in result.iter_mut().enumerate() {
        (0..COLUMNS).for_each(|x| row[x] = f(blocks.map(|block| block[y][x])));
    }
    result
}

/// Eight values of a row from column `x` on.
#[inline(always)]
pub(crate) fn read8(row: &[f32; SIDE], x: usize) -> f32x8 {
    let mut lanes = [0.0; 8];
    lanes.copy_from_slice(&row[x..x + 8]);
    f32x8::from(lanes)
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
