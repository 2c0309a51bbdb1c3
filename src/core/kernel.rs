//! The kernel: where samples are needed, as a weight for every pixel.
//!
//! Lai, Chenney, Liu, Niu, Fan, *Animation rendering with Population Monte Carlo image-plane sampler*, The
//! Visual Computer 2010: w_p = (σ̂²_p / tvi(L̂_p))^γ. The paper has γ = 1 and one pixel's own samples; here σ̂² and
//! L̂ come from a window of 3 × 3 pixels and γ is free. σ̂² is the sum of squared deviations over the window by
//! its degrees of freedom, and divided by the pixel's own count where the [`Criterion`] says so; L̂ is the mean
//! over the window's pixels that have samples, in cd/m².
//!
//! Where a window has no degree of freedom nothing is known of its variance, and the weight is
//! [`UNKNOWN`], which [`allocate`](crate::allocate::allocate) takes for the mean of all others.

use crate::film::window::{Around, block_luminance, write8};
use crate::film::{Layout, Planes, Tile};
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

    /// What divides the variance of a sample of up to eight pixels with these counts.
    #[inline(always)]
    fn divisor(&self, count: &[u32]) -> f32x8 {
        let mut lanes = [1.0; 8];
        if self.criterion == Criterion::Mean {
            lanes.iter_mut().zip(count).for_each(|(lane, n)| *lane = (*n).max(1) as f32);
        }
        f32x8::from(lanes)
    }

    /// Writes every pixel's weight into the plane `target`.
    pub(crate) fn adapt(&self, layout: &Layout, planes: &mut Planes<'_>) {
        for tile in (0..layout.tiles()).map(|t| layout.tile(t)) {
            self.adapt_tile(layout, &tile, planes);
        }
    }

    fn adapt_tile(&self, layout: &Layout, tile: &Tile, planes: &mut Planes<'_>) {
        let around = Around::new(layout, tile);
        let m2 = around.load(planes.m2, |m2| m2);
        let freedom = around.load(planes.count, |n| n.saturating_sub(1) as f32);
        let known = around.load(planes.count, |n| f32::from(u8::from(n > 0)));
        let light = block_luminance(&planes.mean.each_ref().map(|mean| around.load(mean, |mean| mean)));
        for y in 0..tile.height as usize {
            let row = tile.row(y as u32);
            let spent = planes.count[row.clone()].chunks(8);
            for ((x, out), spent) in (0..).step_by(8).zip(planes.target[row].chunks_mut(8)).zip(spent) {
                let sum = |block| self.window.sum(block, x, y);
                let freedom = sum(&freedom);
                let variance = sum(&m2) / (freedom * self.divisor(spent));
                let weight = self.weight(variance, sum(&light) / sum(&known));
                write8(out, freedom.simd_gt(f32x8::ZERO).bitselect(weight, f32x8::splat(UNKNOWN)));
            }
        }
    }
}

#[cfg(test)]
mod tests;
