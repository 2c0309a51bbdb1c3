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

use crate::allocate::Known;
use crate::film::eight::{count8, read8, write8};
use crate::film::window::{Blocks, SIDE};
use crate::film::{Layout, Planes, Tile, luminance8};
use crate::math::{exp2_rough, log2_rough};
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
        let ratio = log2_rough(variance * (cd * cd)) - log2_tvi(log2_rough(luminance * cd));
        variance.simd_gt(f32x8::ZERO) & exp2_rough(f32x8::splat(self.gamma) * ratio)
    }

    /// Writes every pixel's weight into the plane `target` and returns their sum.
    pub(crate) fn adapt(&self, layout: &Layout, planes: &mut Planes<'_>) -> Known {
        let (mut known, mut blocks) = (Known::default(), Blocks::new());
        for tile in (0..layout.tiles()).map(|t| layout.tile(t)) {
            self.adapt_tile(layout, &tile, planes, &mut blocks);
            known.add(&planes.target[tile.first..tile.first + tile.pixels()]);
        }
        known
    }

    fn adapt_tile(&self, layout: &Layout, tile: &Tile, planes: &mut Planes<'_>, blocks: &mut Blocks<4>) {
        let (one, zero) = (f32x8::ONE, f32x8::ZERO);
        blocks.fill(layout, tile, |pixels| {
            let count = count8(&planes.count[pixels.clone()]);
            let known = count.fast_min(one);
            let m2 = read8(&planes.m2[pixels.clone()]);
            [m2, count - known, luminance8(planes.mean8(pixels)), known]
        });
        // Two loops: a weight is a long chain of dependent operations, and the shorter the loop around it, the more
        // of them the processor works on at once.
        let (mut variances, mut lights) = ([[0.0; SIDE]; SIDE], [[0.0; SIDE]; SIDE]);
        let (width, height) = (tile.width as usize, tile.height as usize);
        for x in (0..width).step_by(8) {
            blocks.for_each_row(self.window, x, height, |y, [m2, freedom, light, known], own| {
                let spent = (own[1] + own[3]).fast_max(one);
                let divisor = if self.criterion == Criterion::Mean { freedom * spent } else { freedom };
                let variance = freedom.simd_gt(zero).select(m2 / divisor, f32x8::splat(UNKNOWN));
                write8(&mut variances[y][x..], variance);
                write8(&mut lights[y][x..], light / known);
            });
        }
        for (y, (variances, lights)) in variances.iter().zip(&lights).enumerate().take(height) {
            let target = planes.target[tile.row(y as u32)].chunks_mut(8);
            for (target, x) in target.zip([0, 8]) {
                let variance = read8(&variances[x..]);
                let weight = self.weight(variance, read8(&lights[x..]));
                write8(target, variance.simd_lt(zero).select(f32x8::splat(UNKNOWN), weight));
            }
        }
    }
}

#[cfg(test)]
mod tests;
