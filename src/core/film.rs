//! The film: running statistics of every pixel, stored tile by tile.
//!
//! Tiles of 16 × 16 pixels follow each other in raster order, and so do the pixels of a tile. Tiles at the right
//! and lower edge are smaller; nothing is padded, so a plane has exactly `width · height` entries and a run of
//! tiles is one contiguous slice. A pixel takes [`BYTES_PER_PIXEL`] bytes.
//!
//! Statistics: Welford, *Note on a method for calculating corrected sums of squares and products*, 1962, within
//! an iteration; Chan, Golub, LeVeque, *Updating formulae and a pairwise algorithm for computing sample
//! variances*, 1979, to merge iterations.

mod layout;
pub(crate) mod window;
pub use layout::{Layout, MAX_SIDE, TILE, Tile};

/// Words and floats the film lends from the caller, a pixel.
pub(crate) const WORDS: usize = 3;
/// See [`WORDS`].
pub(crate) const FLOATS: usize = 8;
/// What a pixel costs in lent memory.
pub const BYTES_PER_PIXEL: usize = 4 * (WORDS + FLOATS);

/// The planes of a film or of a contiguous part of it, in storage order.
#[derive(Debug)]
pub(crate) struct Planes<'a> {
    /// Samples in `mean`.
    pub count: &'a mut [u32],
    /// Samples drawn so far, rejected ones included: where the pixel's sequence goes on.
    pub drawn: &'a mut [u32],
    /// Samples planned for the current iteration.
    pub planned: &'a mut [u32],
    /// Mean radiance, a plane a colour.
    pub mean: [&'a mut [f32]; 3],
    /// Sum of squared deviations of luminance from its mean.
    pub m2: &'a mut [f32],
    /// What the estimator has beyond `mean`, weighted, a plane a colour.
    pub excess: [&'a mut [f32]; 3],
    /// Samples expected of the current iteration; while the kernel adapts, its weight.
    pub target: &'a mut [f32],
}

impl<'a> Planes<'a> {
    /// Divides `floats` and `words`, [`FLOATS`] and [`WORDS`] a pixel, into planes.
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
            excess: [float()?, float()?, float()?],
            target: float()?,
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
            excess: [f(), f(), f()],
            target: f(),
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
            excess: self.excess.each_mut().map(|p| &mut **p),
            target: self.target,
        }
    }

    /// The first `at` pixels, and the rest.
    pub fn split_at(self, at: usize) -> (Self, Self) {
        let (count, count_) = self.count.split_at_mut(at);
        let (drawn, drawn_) = self.drawn.split_at_mut(at);
        let (planned, planned_) = self.planned.split_at_mut(at);
        let (m2, m2_) = self.m2.split_at_mut(at);
        let (target, target_) = self.target.split_at_mut(at);
        let (mean, mean_) = split_colours(self.mean, at);
        let (excess, excess_) = split_colours(self.excess, at);
        (
            Planes { count, drawn, planned, mean, m2, excess, target },
            Planes {
                count: count_,
                drawn: drawn_,
                planned: planned_,
                mean: mean_,
                m2: m2_,
                excess: excess_,
                target: target_,
            },
        )
    }

    /// Mean radiance of pixel `i`.
    #[inline]
    pub fn mean_at(&self, i: usize) -> [f32; 3] {
        [self.mean[0][i], self.mean[1][i], self.mean[2][i]]
    }

    /// What samples change, of pixel `i`: every plane is indexed once.
    #[inline(always)]
    pub fn pixel(&mut self, i: usize) -> Pixel<'_> {
        Pixel {
            count: &mut self.count[i],
            drawn: &mut self.drawn[i],
            mean: self.mean.each_mut().map(|plane| &mut plane[i]),
            m2: &mut self.m2[i],
            excess: self.excess.each_mut().map(|plane| &mut plane[i]),
            target: self.target[i],
        }
    }
}

/// A pixel of [`Planes`].
pub(crate) struct Pixel<'a> {
    count: &'a mut u32,
    drawn: &'a mut u32,
    mean: [&'a mut f32; 3],
    m2: &'a mut f32,
    /// See [`Planes::excess`].
    pub excess: [&'a mut f32; 3],
    /// See [`Planes::target`].
    pub target: f32,
}

impl Pixel<'_> {
    /// What is known of the pixel.
    #[inline(always)]
    pub fn moments(&self) -> Moments {
        Moments { count: *self.count, mean: self.mean.each_ref().map(|mean| **mean), m2: *self.m2 }
    }

    /// Merges the samples `new`, the usable ones of `taken`.
    #[inline(always)]
    pub fn merge(self, new: &Moments, taken: u32) {
        let all = self.moments().merged(new);
        *self.drawn = self.drawn.wrapping_add(taken);
        *self.count = all.count;
        *self.m2 = all.m2;
        self.mean.into_iter().zip(all.mean).for_each(|(mean, new)| *mean = new);
    }
}

/// Three planes, each divided at `at`.
fn split_colours(planes: [&mut [f32]; 3], at: usize) -> ([&mut [f32]; 3], [&mut [f32]; 3]) {
    let [r, g, b] = planes;
    let ((r, r_), (g, g_), (b, b_)) = (r.split_at_mut(at), g.split_at_mut(at), b.split_at_mut(at));
    ([r, g, b], [r_, g_, b_])
}

/// Luminance of linear RGB by the weights of Rec. 709, in the unit of the radiance.
#[inline(always)]
pub fn luminance(rgb: [f32; 3]) -> f32 {
    0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]
}

/// Count, mean and sum of squared deviations of some samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// Number of samples.
    pub count: u32,
    /// Mean radiance.
    pub mean: [f32; 3],
    /// Sum of squared deviations of luminance from its mean.
    pub m2: f32,
}

impl Moments {
    /// Adds one sample (Welford).
    #[inline]
    pub fn add(&mut self, rgb: [f32; 3]) {
        self.count += 1;
        let share = 1.0 / self.count as f32;
        let delta = [rgb[0] - self.mean[0], rgb[1] - self.mean[1], rgb[2] - self.mean[2]];
        for (mean, d) in self.mean.iter_mut().zip(delta) {
            *mean += d * share;
        }
        let d = luminance(delta);
        self.m2 += d * d * (1.0 - share);
    }

    /// The part `other` has in the samples of both.
    #[inline(always)]
    pub fn share(&self, other: &Moments) -> f32 {
        other.count as f32 / self.count.saturating_add(other.count).max(1) as f32
    }

    /// The moments of both sets of samples together (Chan).
    #[inline(always)]
    pub fn merged(&self, other: &Moments) -> Moments {
        let share = self.share(other);
        let delta = [0, 1, 2].map(|c| other.mean[c] - self.mean[c]);
        let d = luminance(delta);
        Moments {
            count: self.count.saturating_add(other.count),
            mean: [0, 1, 2].map(|c| self.mean[c] + delta[c] * share),
            m2: self.m2 + other.m2 + d * d * (self.count as f32 * share),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sobol::hash;
    use core::ops::Range;

    #[test]
    fn merging_equals_concatenating() {
        let sample = |i: u32| [0, 1, 2].map(|c| (hash(3 * i + c) >> 8) as f32 / 1e6);
        let of = |range: Range<u32>| {
            let mut moments = Moments::default();
            range.for_each(|i| moments.add(sample(i)));
            moments
        };
        for cut in [0, 1, 7, 40, 100] {
            let (whole, merged) = (of(0..100), of(0..cut).merged(&of(cut..100)));
            assert_eq!(whole.count, merged.count);
            assert!((whole.m2 / merged.m2 - 1.0).abs() < 1e-5);
            assert!((0..3).all(|c| (whole.mean[c] / merged.mean[c] - 1.0).abs() < 1e-6));
        }
    }
}
