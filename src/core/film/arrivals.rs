//! New samples on their way into the film: one pixel's are summed, then eight pixels at a time are merged.

use super::eight::{count8, read8, write8};
use super::{Planes, luminance8};
use crate::batch::Rgb8;
use crate::estimate::{Arrival, Estimator, Weight};
use core::ops::Range;
use wide::{f32x4, f32x8};

/// Pixels that are merged together: more than eight, so that what was written lane by lane has arrived in memory
/// when it is read as vectors.
pub(crate) const GROUP: usize = 32;

/// Colour and luminance of eight samples, sample by sample.
#[inline(always)]
pub(crate) fn samples(rgb: &Rgb8) -> [f32x4; 8] {
    let light = luminance8([rgb.r, rgb.g, rgb.b]).to_array();
    let (r, g, b) = (rgb.r.to_array(), rgb.g.to_array(), rgb.b.to_array());
    core::array::from_fn(|i| f32x4::from([r[i], g[i], b[i], light[i]]))
}

/// Sums over samples of a pixel, relative to the first of them, so that neither needs a division a sample nor
/// cancels: however far the first one is off, it is one of the deviations that are summed.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums {
    count: u32,
    first: f32x4,
    sum: f32x4,
    squares: f32x4,
}

impl Sums {
    /// Adds a sample.
    #[inline(always)]
    pub fn add(&mut self, sample: f32x4) {
        if self.count == 0 {
            self.first = sample;
        }
        let delta = sample - self.first;
        self.sum += delta;
        self.squares += delta * delta;
        self.count += 1;
    }
}

/// Moments of the new samples of a group of neighbouring pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arrivals {
    taken: [u32; GROUP],
    count: [u32; GROUP],
    mean: [[f32; GROUP]; 3],
    m2: [f32; GROUP],
}

impl Arrivals {
    /// No samples.
    pub const NONE: Arrivals =
        Arrivals { taken: [0; GROUP], count: [0; GROUP], mean: [[0.0; GROUP]; 3], m2: [0.0; GROUP] };

    /// Sets what has arrived at pixel `i` of the group: `sums` are those of the usable ones of `taken` samples.
    #[inline(always)]
    pub fn set(&mut self, i: usize, sums: &Sums, taken: u32) {
        let mean = sums.sum * f32x4::splat(1.0 / sums.count.max(1) as f32);
        let [_, _, _, m2] = (sums.squares - sums.sum * mean).to_array();
        let [r, g, b, _] = (sums.first + mean).to_array();
        (self.taken[i], self.count[i], self.m2[i]) = (taken, sums.count, m2.max(0.0));
        (self.mean[0][i], self.mean[1][i], self.mean[2][i]) = (r, g, b);
    }

    /// Merges the moments into the film (Chan), of which the group begins at pixel `first`.
    pub fn merge(&self, planes: &mut Planes<'_>, first: usize, estimator: Estimator, weight: Weight) {
        let end = planes.count.len().min(first + GROUP);
        for start in (first..end).step_by(8) {
            self.merge8(planes, start - first, start..end.min(start + 8), estimator, weight);
        }
    }

    #[inline(always)]
    fn merge8(
        &self,
        planes: &mut Planes<'_>,
        i: usize,
        pixels: Range<usize>,
        estimator: Estimator,
        weight: Weight,
    ) {
        let (old, new) = (count8(&planes.count[pixels.clone()]), count8(&self.count[i..]));
        let mean = planes.mean8(pixels.clone());
        let delta = [0, 1, 2].map(|c| read8(&self.mean[c][i..]) - mean[c]);
        let share = new / (old + new).fast_max(f32x8::ONE);
        let target = read8(&planes.target[pixels.clone()]);
        let rejected = count8(&self.taken[i..]) - new;
        let gain = estimator.gain(&Arrival { mean, delta, count: new, rejected, share, target }, weight);
        for c in 0..3 {
            write8(&mut planes.mean[c][pixels.clone()], mean[c] + delta[c] * share);
            if let Some(gain) = gain {
                let excess = &mut planes.excess[c][pixels.clone()];
                write8(excess, read8(excess) + gain[c]);
            }
        }
        let light = luminance8(delta);
        let m2 = &mut planes.m2[pixels.clone()];
        write8(m2, read8(m2) + read8(&self.m2[i..]) + light * light * (old * share));
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
    use crate::film::{FLOATS, WORDS, luminance};
    use crate::sobol::hash;
    use std::vec;
    use std::vec::Vec;

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
        let weight = Weight { before: 0.0, iteration: 1.0 };
        for range in [0..1, 1..8, 8..8, 8..40] {
            let mut arrivals = Arrivals::NONE;
            for p in 0..pixels {
                let mut sums = Sums::default();
                range.clone().for_each(|i| {
                    let rgb = sample(p, i);
                    sums.add(f32x4::from([rgb[0], rgb[1], rgb[2], luminance(rgb)]));
                });
                arrivals.set(p, &sums, range.len() as u32);
            }
            arrivals.merge(&mut planes, 0, Estimator::Pooled, weight);
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
}
