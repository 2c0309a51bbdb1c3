//! Islands: pixels that belong together, by their labels.
//!
//! A film can be an atlas: islands of pixels that have nothing to do with their neighbours, and pixels that are not there
//! at all. Nothing that looks around a pixel may see another island. Small windows compare labels; what is smooth over many
//! pixels works on one island after the other, each in the region of tiles it occurs in. There is no list of islands: the
//! next one is that of the least label that is larger, two passes over the labels each.

use super::cell::Region;
use super::layout::{Layout, TILE};
use crate::maths::eight::count8;
use core::ops::Range;
use wide::f32x8;

/// Which pixels are looked at together.
pub(crate) trait Among: Copy {
    /// Whether these are all.
    const ALL: bool;
    /// A mask of those of up to eight neighbouring pixels.
    fn mask(self, pixels: Range<usize>) -> f32x8;
}

/// All pixels.
#[derive(Clone, Copy)]
pub(crate) struct Everyone;

impl Among for Everyone {
    const ALL: bool = true;

    #[inline(always)]
    fn mask(self, _: Range<usize>) -> f32x8 {
        f32x8::ZERO.simd_eq(f32x8::ZERO)
    }
}

/// The pixels of one label.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Island<'a> {
    labels: &'a [u32],
    label: u32,
}

impl Among for Island<'_> {
    const ALL: bool = false;

    #[inline(always)]
    fn mask(self, pixels: Range<usize>) -> f32x8 {
        count8(&self.labels[pixels]).simd_eq(f32x8::splat(self.label as f32))
    }
}

impl<'a> Island<'a> {
    /// The first island and where it is, if there is one; `labels` are below 2^24, 0 is no island.
    pub fn first(layout: &Layout, labels: &'a [u32]) -> Option<(Island<'a>, Region)> {
        Island { labels, label: 0 }.next(layout)
    }

    /// The island after this one and where it is.
    pub fn next(self, layout: &Layout) -> Option<(Island<'a>, Region)> {
        let label = self.labels.iter().copied().filter(|label| *label > self.label).min()?;
        Some((Island { label, ..self }, region(layout, self.labels, label)))
    }
}

/// The tiles in which a label occurs.
fn region(layout: &Layout, labels: &[u32], label: u32) -> Region {
    let across = layout.width().div_ceil(TILE);
    let nothing = Range { start: u32::MAX, end: 0 };
    let mut region = Region { columns: nothing.clone(), rows: nothing };
    for t in 0..layout.tiles() {
        let tile = layout.tile(t);
        if labels[tile.first..tile.first + tile.pixels()].contains(&label) {
            let grow = |range: &mut Range<u32>, i: u32| *range = range.start.min(i)..range.end.max(i + 1);
            grow(&mut region.columns, t % across);
            grow(&mut region.rows, t / across);
        }
    }
    region
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use std::vec;
    use std::vec::Vec;

    #[test]
    fn islands_are_found_with_their_tiles() {
        let layout = Layout::new(50, 40).unwrap();
        let mut labels = vec![0; 2000];
        for (x, y, label) in [(3, 3, 7), (20, 33, 7), (49, 39, 65_535), (17, 0, 2)] {
            labels[layout.index(x, y)] = label;
        }
        let first = Island::first(&layout, &labels);
        let all = core::iter::successors(first, |(island, _)| island.next(&layout));
        let found: Vec<_> = all.map(|(island, region)| (island.label, region)).collect();
        let region = |columns, rows| Region { columns, rows };
        let want = [(2, region(1..2, 0..1)), (7, region(0..2, 0..3)), (65_535, region(3..4, 2..3))];
        assert_eq!(found, want);
    }
}
