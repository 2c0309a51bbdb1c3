//! The kernel: where samples are needed, as a weight for every pixel.
//!
//! Lai, Chenney, Liu, Niu, Fan, *Animation rendering with Population Monte Carlo image-plane sampler*, The
//! Visual Computer 2010: w_p = (σ̂²_p / tvi(L̂_p))^γ. The paper has γ = 1 and one pixel's own samples; here σ̂² and
//! L̂ come from a binomial window of 3 × 3 pixels and γ is free. σ̂² is the sum of squared deviations over the window by
//! its degrees of freedom, and divided by the pixel's own count where the [`Criterion`] says so; L̂ is the mean
//! over the window's pixels that have samples, in cd/m².
//!
//! Where a window has no degree of freedom nothing is known of its variance, and the weight is
//! [`UNKNOWN`], which [`allocate`](crate::allocate::allocate) takes for the mean of all others.

use crate::film::window::{Around, Inner, combine, inner, read8, write8};
use crate::film::{Layout, Planes, Tile, luminance};
use crate::math::{exp2, log2};
use crate::tvi::log2_tvi;
use wide::f32x8;

pub use crate::film::window::Window;

/// The weight of a pixel of whose variance nothing is known.
pub const UNKNOWN: f32 = -1.0;

/// Which variance a weight is made of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Criterion {
    /// σ̂², the variance of a sample, as the paper does: an iteration repeats the division it thinks best,
    /// whatever earlier ones have spent.
    Sample,
    /// σ̂²/n, the variance of the mean of the pixel's n samples so far: what has been seen to already counts less,
    /// and a pixel that was hit by a rare bright sample is sampled until it is diluted.
    #[default]
    Mean,
}

/// How weights follow from the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kernel {
    /// What is evened out.
    pub criterion: Criterion,
    /// γ: 1 evens the visible error out, ½ minimises its sum where variances are known.
    pub gamma: f32,
    /// Pixels over which variance and luminance are taken.
    pub window: Window,
    /// Luminance in cd/m² of radiance 1.
    pub cd_per_unit: f32,
}

impl Kernel {
    /// Weights of eight pixels from the variance of a sample and the mean luminance, in scene units.
    ///
    /// No variance, no weight. Every result is finite.
    #[inline]
    pub fn weight(&self, variance: f32x8, luminance: f32x8) -> f32x8 {
        let cd = f32x8::splat(self.cd_per_unit);
        let ratio = log2(variance * cd * cd) - log2_tvi(luminance * cd);
        variance.simd_gt(f32x8::ZERO) & exp2(f32x8::splat(self.gamma) * ratio)
    }

    /// Writes every pixel's weight into the plane `target`.
    pub(crate) fn adapt(&self, layout: &Layout, planes: &mut Planes<'_>) {
        for tile in (0..layout.tiles()).map(|t| layout.tile(t)) {
            self.adapt_tile(layout, &tile, planes);
        }
    }

    fn adapt_tile(&self, layout: &Layout, tile: &Tile, planes: &mut Planes<'_>) {
        let around = Around::new(layout, tile);
        let light = planes.mean.each_ref().map(|mean| around.load(mean, |mean| mean));
        let light = combine(light.each_ref(), luminance);
        let count = around.load(planes.count, |n| n.min(i32::MAX as u32) as i32 as f32);
        let known = combine([&count], |[n]| n.min(1.0));
        let m2 = self.window.sums(&around.load(planes.m2, |m2| m2));
        let (samples, known) = (self.window.sums(&count), self.window.sums(&known));
        let (light, spent) = (self.window.sums(&light), inner(&count));
        for y in 0..tile.height as usize {
            let out = planes.target[tile.row(y as u32)].chunks_mut(8);
            for (out, x) in out.zip([0, 8]) {
                let eight = |inner: &Inner| read8(&inner[y], x);
                let (known, spent) = (eight(&known), eight(&spent).fast_max(f32x8::ONE));
                let freedom = eight(&samples) - known;
                let divisor = if self.criterion == Criterion::Mean { freedom * spent } else { freedom };
                let weight = self.weight(eight(&m2) / divisor, eight(&light) / known);
                write8(out, freedom.simd_gt(f32x8::ZERO).bitselect(weight, f32x8::splat(UNKNOWN)));
            }
        }
    }
}

#[cfg(test)]
mod tests;
