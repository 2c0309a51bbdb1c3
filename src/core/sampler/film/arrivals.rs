//! New samples on their way into the film: one pixel's are summed, then eight pixels at a time are merged.

use super::planes::Planes;
use crate::maths::colour::{luminance8, squared_luminance};
use crate::maths::eight::{count8, read8, write8};
use crate::sampler::batch::Rgb8;
use core::ops::Range;
use wide::f32x8;

/// Pixels that are merged together: more than eight, so that what was written lane by lane has arrived in memory
/// when it is read as vectors.
pub(crate) const GROUP: usize = 32;

/// The colour of a sample: red, green, blue, nothing, green, blue, red, nothing, so that the sums of its squares and of products
/// of two are those of one vector.
pub(crate) type Sample = f32x8;

/// Eight samples, sample by sample.
#[inline(always)]
pub(crate) fn samples(rgb: &Rgb8) -> [Sample; 8] {
    f32x8::transpose([rgb.r, rgb.g, rgb.b, f32x8::ZERO, rgb.g, rgb.b, rgb.r, f32x8::ZERO])
}

/// Squares of red, green, blue, and red times green, green times blue, blue times red.
#[inline(always)]
fn products(one: Sample, other: Sample) -> f32x8 {
    let [r, g, b, none, ..] = one.to_array();
    f32x8::from([r, g, b, none, r, g, b, none]) * other
}

/// Samples that are summed before the sums are merged: the error of a sum in single precision grows with its length.
const CHUNK: u32 = 256;

/// Moments of samples of a pixel.
///
/// A chunk of them is summed relative to its first, so that neither needs a division a sample nor cancels: however far
/// the first one is off, it is one of the deviations that are summed. Luminances are those of deviations, never deviations of
/// luminances, which are rounded to what single precision has at the offset that all samples share: near each other colours are
/// subtracted exactly (Sterbenz). Sums of the six products of two of the three colours have the squared luminances in them. Full
/// chunks are merged into `before`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums {
    before: Moments,
    count: u32,
    first: Sample,
    /// Of deviations from the first; not yet of meaning while that is the only one.
    sum: Sample,
    /// Of their [`products`].
    products: f32x8,
}

/// Number, mean colour and sum of squared deviations of luminance.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moments {
    count: u32,
    mean: Sample,
    m2: f32,
}

impl Moments {
    /// Mean of `taken` samples, where those that were not added count as black.
    #[inline(always)]
    pub fn mean_of(&self, taken: u32) -> Sample {
        if self.count == taken {
            return self.mean;
        }
        self.mean * f32x8::splat(self.count as f32 / taken as f32)
    }

    /// Those of two sets of samples together (Chan).
    fn merged(self, other: Moments) -> Moments {
        let count = self.count + other.count;
        let share = other.count as f32 / count.max(1) as f32;
        let delta = other.mean - self.mean;
        let between = squared_luminance(products(delta, delta)) * share * self.count as f32;
        let mean = self.mean + delta * f32x8::splat(share);
        Moments { count, mean, m2: self.m2 + other.m2 + between }
    }
}

impl Sums {
    /// Begins anew, without a sample.
    #[inline(always)]
    pub fn clear(&mut self) {
        (self.count, self.before.count) = (0, 0);
    }

    /// Adds samples, at least one.
    #[inline(always)]
    pub fn extend(&mut self, samples: &[Sample]) {
        if self.count + samples.len() as u32 <= CHUNK {
            self.add(samples);
        } else {
            self.extend_by_bits(samples, !0);
        }
    }

    /// Adds those of some samples that have a bit in `usable`, and returns how many have none.
    #[cold]
    pub fn extend_by_bits(&mut self, samples: &[Sample], usable: u32) -> u32 {
        let mut rejected = 0;
        for (i, sample) in samples.iter().enumerate() {
            if self.count == CHUNK {
                (self.before, self.count) = (self.moments(), 0);
            }
            match usable >> i & 1 {
                1 => self.add(core::slice::from_ref(sample)),
                _ => rejected += 1,
            }
        }
        rejected
    }

    /// Adds samples, at least one, that do not go beyond the chunk.
    #[inline(always)]
    fn add(&mut self, samples: &[Sample]) {
        let (before, mut others) = (self.count, samples);
        self.count += samples.len() as u32;
        if before == 0 {
            (self.first, others) = (samples[0], &samples[1..]);
        }
        if others.is_empty() {
            return;
        }
        let (mut sum, mut squares) = (f32x8::ZERO, f32x8::ZERO);
        if before > 1 {
            (sum, squares) = (self.sum, self.products);
        }
        for sample in others {
            let delta = *sample - self.first;
            sum += delta;
            squares += products(delta, delta);
        }
        (self.sum, self.products) = (sum, squares);
    }

    /// Moments of all samples.
    #[inline(always)]
    pub fn moments(&self) -> Moments {
        let chunk = self.moments_of_chunk();
        if self.before.count == 0 { chunk } else { self.before.merged(chunk) }
    }

    /// Moments of the samples since the last full chunk.
    #[inline(always)]
    fn moments_of_chunk(&self) -> Moments {
        if self.count <= 1 {
            let mean = if self.count == 0 { f32x8::ZERO } else { self.first };
            return Moments { count: self.count, mean, m2: 0.0 };
        }
        let mean = self.sum * f32x8::splat(1.0 / self.count as f32);
        let m2 = squared_luminance(self.products - products(self.sum, mean)).max(0.0);
        Moments { count: self.count, mean: self.first + mean, m2 }
    }
}

/// Moments of the new samples of a group of neighbouring pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arrivals {
    taken: [u32; GROUP],
    count: [u32; GROUP],
    mean: [[f32; GROUP]; 3],
    m2: [f32; GROUP],
    /// What the estimator's own mean moves towards, and how far.
    fair: [[f32; GROUP]; 3],
    share: [f32; GROUP],
}

impl Arrivals {
    /// No samples.
    pub const NONE: Arrivals = Arrivals {
        taken: [0; GROUP],
        count: [0; GROUP],
        mean: [[0.0; GROUP]; 3],
        m2: [0.0; GROUP],
        fair: [[0.0; GROUP]; 3],
        share: [0.0; GROUP],
    };

    /// Sets what has arrived at pixel `i` of the group: `moments` are those of the usable ones of `taken` samples.
    #[inline(always)]
    pub fn set(&mut self, i: usize, moments: &Moments, taken: u32) {
        let [r, g, b, ..] = moments.mean.to_array();
        (self.taken[i], self.count[i], self.m2[i]) = (taken, moments.count, moments.m2);
        (self.mean[0][i], self.mean[1][i], self.mean[2][i]) = (r, g, b);
    }

    /// Sets that the estimator's own mean of pixel `i` of the group moves by `share` towards `mean`.
    #[inline(always)]
    pub fn set_fair(&mut self, i: usize, mean: Sample, share: f32) {
        let [r, g, b, ..] = mean.to_array();
        (self.fair[0][i], self.fair[1][i], self.fair[2][i], self.share[i]) = (r, g, b, share);
    }

    /// Merges the moments into the film (Chan), of which the group begins at pixel `first`, the estimator's own mean, too, if
    /// it has one (`fair`). Nothing is planned for its pixels any more.
    pub fn merge(&self, planes: &mut Planes<'_>, first: usize, fair: bool) {
        let end = planes.count.len().min(first + GROUP);
        for start in (first..end).step_by(8) {
            let pixels = start..end.min(start + 8);
            if fair {
                self.merge_fair8(planes, start - first, pixels.clone());
            }
            self.merge8(planes, start - first, pixels);
        }
    }

    #[inline(always)]
    fn merge_fair8(&self, planes: &mut Planes<'_>, i: usize, pixels: Range<usize>) {
        let share = read8(&self.share[i..]);
        for (plane, new) in planes.fair.iter_mut().zip(&self.fair) {
            let plane = &mut plane[pixels.clone()];
            let old = read8(plane);
            write8(plane, old + (read8(&new[i..]) - old) * share);
        }
    }

    #[inline(always)]
    fn merge8(&self, planes: &mut Planes<'_>, i: usize, pixels: Range<usize>) {
        let (old, new) = (count8(&planes.count[pixels.clone()]), count8(&self.count[i..]));
        let mean = planes.mean8(pixels.clone());
        let delta = [0, 1, 2].map(|c| read8(&self.mean[c][i..]) - mean[c]);
        let share = new / (old + new).fast_max(f32x8::ONE);
        for c in 0..3 {
            write8(&mut planes.mean[c][pixels.clone()], mean[c] + delta[c] * share);
        }
        let light = luminance8(delta);
        let m2 = &mut planes.m2[pixels.clone()];
        write8(m2, read8(m2) + read8(&self.m2[i..]) + light * light * (old * share));
        planes.planned[pixels.clone()].fill(0);
        for (k, pixel) in pixels.enumerate() {
            planes.count[pixel] = planes.count[pixel].saturating_add(self.count[i + k]);
            planes.drawn[pixel] = planes.drawn[pixel].wrapping_add(self.taken[i + k]);
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use crate::maths::colour::luminance;
    use crate::maths::sobol::hash;
    use crate::sampler::film::{FLOATS, WORDS};
    use std::vec;
    use std::vec::Vec;

    fn eight([r, g, b]: [f32; 3]) -> Sample {
        f32x8::from([r, g, b, 0.0, g, b, r, 0.0])
    }

    /// Sample `i` of pixel `p`; the first of every third pixel is a firefly.
    fn sample(p: usize, i: usize) -> [f32; 3] {
        let boost = if i == 0 && p.is_multiple_of(3) { 1e4 } else { 1.0 };
        [0, 1, 2].map(|c| boost * (hash((p * 1000 + 3 * i + c) as u32) >> 8) as f32 / 1e6)
    }

    #[test]
    fn merging_groups_equals_the_moments_of_all_samples() {
        let pixels = GROUP - 5;
        let (mut floats, mut words) = (vec![0.0; FLOATS * pixels], vec![0; WORDS * pixels]);
        let mut planes = Planes::new(&mut floats, &mut words, pixels).unwrap();
        for range in [0..1, 1..8, 8..8, 8..40] {
            let mut arrivals = Arrivals::NONE;
            for p in 0..pixels {
                let mut sums = Sums::default();
                range.clone().for_each(|i| {
                    sums.extend(&[eight(sample(p, i))]);
                });
                arrivals.set(p, &sums.moments(), range.len() as u32);
            }
            arrivals.merge(&mut planes, 0, false);
        }
        for p in 0..pixels {
            let light: Vec<f64> = (0..40).map(|i| f64::from(luminance(sample(p, i)))).collect();
            let mean = light.iter().sum::<f64>() / 40.0;
            let m2: f64 = light.iter().map(|l| (l - mean).powi(2)).sum();
            assert_eq!((planes.count[p], planes.drawn[p]), (40, 40));
            assert!((f64::from(planes.m2[p]) / m2 - 1.0).abs() < 1e-5);
            assert!((f64::from(luminance(planes.mean_at(p))) / mean - 1.0).abs() < 2e-6);
        }
    }

    /// A first sample far off, then ordinary ones: the mean and the variance of all of them by sums in double precision.
    /// A sum of 10⁷ numbers in single precision would be off by more than the mean.
    #[test]
    fn a_first_sample_far_off_does_not_spoil_long_sums() {
        for length in [4_096u32, 65_536, 10_000_000] {
            let value = |i: u32| if i == 0 { 1e4 } else { (hash(i) >> 8) as f32 / 16_777_216.0 };
            let (mut sums, mut mean, mut square) = (Sums::default(), 0.0, 0.0);
            for i in 0..length {
                sums.extend(&[eight([value(i); 3])]);
                let value = f64::from(value(i));
                (mean, square) = (mean + value, square + value * value);
            }
            mean /= f64::from(length);
            let variance = square / f64::from(length) - mean * mean;
            let found = sums.moments();
            let found_mean = f64::from(found.mean.to_array()[1]);
            let found_variance = f64::from(found.m2) / f64::from(length);
            assert_eq!(found.count, length);
            assert!((found_mean / mean - 1.0).abs() < 1e-4, "{length}: mean {found_mean}, not {mean}");
            assert!(
                (found_variance / variance - 1.0).abs() < 1e-2,
                "{length}: {found_variance}, not {variance}"
            );
        }
    }
}
