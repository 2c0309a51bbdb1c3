//! What is known of the pixels, a plane a number.

use crate::maths::eight::read8;
use core::ops::Range;
use wide::f32x8;

/// Words and floats the film lends from the caller, a pixel.
pub(crate) const WORDS: usize = 3;
/// See [`WORDS`].
pub(crate) const FLOATS: usize = 8;
/// What a pixel costs in lent memory; four bytes more if it has a label.
pub const BYTES_PER_PIXEL: usize = 4 * (WORDS + FLOATS);

/// The planes of a film or of a contiguous part of it, in storage order.
#[derive(Debug)]
pub(crate) struct Planes<'a> {
    /// Samples in `mean`.
    pub count: &'a mut [u32],
    /// Samples drawn so far, rejected ones included: where the pixel's sequence goes on. The most there can be where the
    /// label is 0, so that none is ever due there.
    pub drawn: &'a mut [u32],
    /// Samples planned for the current iteration that are not in the film yet.
    pub planned: &'a mut [u32],
    /// Mean radiance, a plane a colour.
    pub mean: [&'a mut [f32]; 3],
    /// Sum of squared deviations of luminance from its mean.
    pub m2: &'a mut [f32],
    /// The estimator's own mean, a plane a colour: of the fair samples, or of the iterations' pictures.
    pub fair: [&'a mut [f32]; 3],
    /// Samples expected of the current iteration; while the kernel adapts, its weight.
    pub target: &'a mut [f32],
    /// Which pixels belong together, 0 where there is none; empty if all do, and in parts of a film.
    pub label: &'a [u32],
}

/// What whoever works on a part of a film sees of all of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen<'a> {
    /// See [`Planes`].
    pub count: &'a [u32],
    /// See [`Planes`].
    pub drawn: &'a [u32],
    /// See [`Planes`].
    pub mean: [&'a [f32]; 3],
    /// See [`Planes`].
    pub m2: &'a [f32],
    /// See [`Planes`].
    pub label: &'a [u32],
}

impl Seen<'_> {
    /// Mean radiance of up to eight neighbouring pixels.
    #[inline(always)]
    pub fn mean8(&self, pixels: Range<usize>) -> [f32x8; 3] {
        self.mean.map(|plane| read8(&plane[pixels.clone()]))
    }
}

impl<'a> Planes<'a> {
    /// Divides `floats` and `words`, [`FLOATS`] and [`WORDS`] a pixel, into planes. One word more a pixel is its label.
    pub fn new(floats: &'a mut [f32], words: &'a mut [u32], pixels: usize) -> Option<Self> {
        let mut floats = floats.chunks_exact_mut(pixels);
        let mut words = words.chunks_exact_mut(pixels);
        let mut float = || floats.next();
        Some(Planes {
            count: words.next()?,
            drawn: words.next()?,
            planned: words.next()?,
            mean: [float()?, float()?, float()?],
            m2: float()?,
            fair: [float()?, float()?, float()?],
            target: float()?,
            label: words.next().map_or(&[], |label| label),
        })
    }

    /// No pixels.
    pub fn empty() -> Self {
        let f = || &mut [][..];
        Planes {
            count: &mut [],
            drawn: &mut [],
            planned: &mut [],
            mean: [f(), f(), f()],
            m2: f(),
            fair: [f(), f(), f()],
            target: &mut [],
            label: &[],
        }
    }

    /// The planes again, for a shorter time.
    pub fn reborrow(&mut self) -> Planes<'_> {
        Planes {
            count: self.count,
            drawn: self.drawn,
            planned: self.planned,
            mean: self.mean.each_mut().map(|p| &mut **p),
            m2: self.m2,
            fair: self.fair.each_mut().map(|p| &mut **p),
            target: self.target,
            label: self.label,
        }
    }

    /// What everybody may read.
    pub fn seen(&self) -> Seen<'_> {
        let Planes { count, drawn, mean, m2, label, .. } = self;
        Seen { count, drawn, mean: mean.each_ref().map(|plane| &**plane), m2, label }
    }

    /// What everybody may read while `target` and `planned` are written, and these two.
    pub fn apart(&mut self) -> (Seen<'_>, &mut [f32], &mut [u32]) {
        let Planes { count, drawn, mean, m2, label, target, planned, .. } = self;
        let seen = Seen { count, drawn, mean: mean.each_ref().map(|plane| &**plane), m2, label };
        (seen, target, planned)
    }

    /// The first `at` pixels, and the rest.
    pub fn split_at(self, at: usize) -> (Self, Self) {
        let (count, count_) = self.count.split_at_mut(at);
        let (drawn, drawn_) = self.drawn.split_at_mut(at);
        let (planned, planned_) = self.planned.split_at_mut(at);
        let (m2, m2_) = self.m2.split_at_mut(at);
        let (target, target_) = self.target.split_at_mut(at);
        let (mean, mean_) = split_colours(self.mean, at);
        let (fair, fair_) = split_colours(self.fair, at);
        (
            Planes { count, drawn, planned, mean, m2, fair, target, label: &[] },
            Planes {
                count: count_,
                drawn: drawn_,
                planned: planned_,
                mean: mean_,
                m2: m2_,
                fair: fair_,
                target: target_,
                label: &[],
            },
        )
    }

    /// Mean radiance of pixel `i`.
    #[cfg(test)]
    pub fn mean_at(&self, i: usize) -> [f32; 3] {
        [self.mean[0][i], self.mean[1][i], self.mean[2][i]]
    }

    /// Variance of the mean luminance of pixel `i` as far as its own samples know it: 0 for fewer than two.
    pub fn variance_of_mean(&self, i: usize) -> f32 {
        match self.count[i] {
            0 | 1 => 0.0,
            n => self.m2[i] / ((n - 1) as f32 * n as f32),
        }
    }

    /// Mean radiance of up to eight neighbouring pixels.
    #[inline(always)]
    pub fn mean8(&self, pixels: Range<usize>) -> [f32x8; 3] {
        self.mean.each_ref().map(|plane| read8(&plane[pixels.clone()]))
    }

    /// The estimator's own mean of up to eight neighbouring pixels.
    #[inline(always)]
    pub fn fair8(&self, pixels: Range<usize>) -> [f32x8; 3] {
        self.fair.each_ref().map(|plane| read8(&plane[pixels.clone()]))
    }
}

/// Three planes, each divided at `at`.
fn split_colours(planes: [&mut [f32]; 3], at: usize) -> ([&mut [f32]; 3], [&mut [f32]; 3]) {
    let [r, g, b] = planes;
    let ((r, r_), (g, g_), (b, b_)) = (r.split_at_mut(at), g.split_at_mut(at), b.split_at_mut(at));
    ([r, g, b], [r_, g_, b_])
}
