//! Sums over 3 × 3 pixels of the film, a tile at a time.
//!
//! Quantities of a tile and of the pixels around it are computed into small raster [`Block`]s; beyond the film they
//! are zero, so windows at the border sum over the pixels that exist.

use super::layout::{Layout, TILE, Tile};
use crate::maths::eight::{read8, write8};
use core::ops::Range;
use wide::f32x8;

/// Side of a tile.
pub(crate) const SIDE: usize = TILE as usize;
/// Rows of a block: a tile and one more at each end.
const ROWS: usize = SIDE + 2;
/// Columns of a block: column 0 is left of the tile, the last ones fill the third vector up.
const COLUMNS: usize = SIDE + 8;

/// A tile of one quantity with the pixels around it.
pub(crate) type Block = [[f32; COLUMNS]; ROWS];

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
}

/// Blocks of `N` quantities, filled tile after tile.
pub(crate) struct Blocks<const N: usize>([Block; N]);

impl<const N: usize> Blocks<N> {
    /// Blocks of zeros.
    pub fn new() -> Self {
        Blocks([[[0.0; COLUMNS]; ROWS]; N])
    }

    /// Fills the blocks with the surroundings of `tile`; `quantities` says what up to eight neighbouring pixels have.
    ///
    /// Column after column, each in a short loop: so many rows are fetched at once, and waits for memory overlap.
    #[inline(always)]
    pub fn fill(&mut self, layout: &Layout, tile: &Tile, quantities: impl Fn(Range<usize>) -> [f32x8; N]) {
        let width = tile.width as usize;
        // Row 0 of the blocks is above the tile.
        let first = usize::from(tile.y0 == 0);
        let end = ROWS.min((layout.height() + 1 - tile.y0) as usize);
        let rows = first..end;
        let index = |x: u32, i: usize| layout.index(x, tile.y0 + i as u32 - 1);
        if rows.len() < ROWS || width < SIDE {
            self.0 = [[[0.0; COLUMNS]; ROWS]; N];
        }
        let right = tile.x0 + tile.width;
        if right < layout.width() {
            // Eight at a time here too, though one of them is wanted.
            let row = |i| index(right, i)..layout.pixels().min(index(right, i) + 8);
            rows.clone().for_each(|i| self.set(i, 1 + width, quantities(row(i)).map(|q| q.to_array()[0])));
        } else {
            rows.clone().for_each(|i| self.set(i, 1 + width, [0.0; N]));
        }
        for x in (0..width).step_by(8) {
            for i in rows.clone() {
                let start = index(tile.x0, i) + x;
                let values = quantities(start..start + 8.min(width - x));
                // By index: an iterator over vectors by value would take them through memory.
                (0..N).for_each(|q| write8(&mut self.0[q][i][1 + x..], values[q]));
            }
        }
        if tile.x0 > 0 {
            // Left of a tile is a whole one.
            let row = |i| index(tile.x0 - 8, i)..index(tile.x0 - 8, i) + 8;
            rows.clone().for_each(|i| self.set(i, 0, quantities(row(i)).map(|q| q.to_array()[7])));
        } else {
            rows.clone().for_each(|i| self.set(i, 0, [0.0; N]));
        }
    }

    #[inline(always)]
    fn set(&mut self, i: usize, column: usize, values: [f32; N]) {
        (0..N).for_each(|q| self.0[q][i][column] = values[q]);
    }

    /// Calls `f(y, sums, own)` for every row `y` of the tile: sums over the windows of eight pixels from column `x`
    /// on, and the quantities of the pixels themselves. With `labels` a window has the pixels of its centre's label alone.
    #[inline(always)]
    pub fn for_each_row(
        &self,
        labels: Option<&Blocks<1>>,
        window: Window,
        x: usize,
        rows: usize,
        mut f: impl FnMut(usize, [f32x8; N], [f32x8; N]),
    ) {
        if let (Some(Blocks([labels])), Window::Square3) = (labels, window) {
            return (0..rows).for_each(|y| f(y, self.among(labels, x, y), self.own(x, y)));
        }
        let own = |y: usize| self.own(x, y);
        let mut above = self.across(x, 0);
        let mut here = self.across(x, 1);
        let mut pair: [f32x8; N] = core::array::from_fn(|q| above[q] + here[q]);
        for y in 0..rows {
            if window == Window::Pixel {
                f(y, own(y), own(y));
                continue;
            }
            (above, here) = (here, self.across(x, y + 2));
            let next: [f32x8; N] = core::array::from_fn(|q| above[q] + here[q]);
            f(y, core::array::from_fn(|q| pair[q] + next[q]), own(y));
            pair = next;
        }
    }

    /// The quantities of eight pixels themselves.
    #[inline(always)]
    fn own(&self, x: usize, y: usize) -> [f32x8; N] {
        self.0.each_ref().map(|block| read8(&block[y + 1][x + 1..]))
    }

    /// Sums over the windows of eight pixels, of those that have their labels.
    #[inline(always)]
    fn among(&self, labels: &Block, x: usize, y: usize) -> [f32x8; N] {
        let label = read8(&labels[y + 1][x + 1..]);
        let same: [[f32x8; 3]; 3] =
            core::array::from_fn(|i| core::array::from_fn(|k| read8(&labels[y + i][x + k..]).simd_eq(label)));
        self.0.each_ref().map(|block| {
            let [above, here, below] = core::array::from_fn(|i| {
                let [left, middle, right] =
                    core::array::from_fn(|k| same[i][k] & read8(&block[y + i][x + k..]));
                (left + middle) + (middle + right)
            });
            (above + here) + (here + below)
        })
    }

    /// Eight sums over three columns, weighted 1, 2, 1, in row `i` of the blocks.
    #[inline(always)]
    fn across(&self, x: usize, i: usize) -> [f32x8; N] {
        self.0.each_ref().map(|block| {
            let row = &block[i];
            let middle = read8(&row[x + 1..]);
            (read8(&row[x..]) + middle) + (middle + read8(&row[x + 2..]))
        })
    }
}
