//! Which pixels a filter may look at together: see [`island`](crate::sampler::film::island).

use super::rows::{Grid, MARGIN, Rows};
use crate::maths::eight::read8;
use crate::sampler::film::{Layout, Planes};
use wide::f32x8;

/// Which pixels are looked at together.
pub(super) trait Among: Copy {
    /// A mask of those of the eight pixels from (`x`, `y`) on, margins counted.
    fn mask(self, x: usize, y: usize) -> f32x8;
}

/// All pixels.
#[derive(Clone, Copy)]
pub(super) struct Everyone;

impl Among for Everyone {
    #[inline(always)]
    fn mask(self, _: usize, _: usize) -> f32x8 {
        f32x8::ZERO.simd_eq(f32x8::ZERO)
    }
}

/// The pixels of one label.
#[derive(Clone, Copy)]
pub(super) struct Island<'a> {
    pub labels: Rows<'a>,
    pub label: f32,
}

impl Among for Island<'_> {
    #[inline(always)]
    fn mask(self, x: usize, y: usize) -> f32x8 {
        read8(&self.labels.row(0, y)[x..]).simd_eq(f32x8::splat(self.label))
    }
}

/// Fills a plane with the labels of a film, margins too.
pub(super) fn fill(grid: Grid, layout: &Layout, planes: &Planes<'_>, labels: &mut [f32]) {
    let stride = grid.stride();
    for (y, row) in labels.chunks_exact_mut(stride).skip(MARGIN).take(grid.height).enumerate() {
        for (x, to) in row[MARGIN..MARGIN + grid.width].iter_mut().enumerate() {
            *to = planes.label[layout.index(x as u32, y as u32)] as f32;
        }
    }
    grid.reflect(1, labels);
}

/// Whether two pixels belong together.
#[inline(always)]
pub(super) fn together(labels: Option<Rows<'_>>, (x, y): (usize, usize), (u, v): (usize, usize)) -> bool {
    labels.is_none_or(|labels| labels.row(0, y)[x] == labels.row(0, v)[u])
}
