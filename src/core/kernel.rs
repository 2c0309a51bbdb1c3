//! The kernel: where samples are needed, as a weight for every pixel.
//!
//! Lai, Chenney, Liu, Niu, Fan, *Animation rendering with Population Monte Carlo image-plane sampler*, The
//! Visual Computer 2010: w_p = (σ̂²_p / tvi(L̂_p))^γ. The paper has γ = 1 and one pixel's own samples; here σ̂² and
//! L̂ come from a binomial window of 3 × 3 pixels and γ is free. σ̂² is the sum of squared deviations over the window by
//! its degrees of freedom, and divided by the pixel's own count where the [`Criterion`] says so; L̂ is the mean
//! over the window's pixels that have samples, in cd/m².
//!
//! Where a window has fewer than [`ENOUGH`] degrees of freedom, what earlier frames [believed](crate::predict::Belief)
//! fills them up, if anything was predicted; it has no say where the frame itself knows that much, so that a rare
//! bright sample draws others as fast as without a prediction.
//!
//! Where there is no degree of freedom at all nothing is known of its variance, and the weight is
//! [`UNKNOWN`], which [`allocate`](crate::allocate::allocate) takes for the mean of all others.

use crate::film::window::{Around, Inner, combine, inner, read8, write8};
use crate::film::{Layout, Planes, Tile, luminance};
use crate::math::{exp2, log2};
use crate::predict::Belief;
use crate::tvi::log2_tvi;
use wide::f32x8;

pub use crate::film::window::Window;

/// The weight of a pixel of whose variance nothing is known.
pub const UNKNOWN: f32 = -1.0;

/// Degrees of freedom of a window beyond which a prediction has no say.
pub const ENOUGH: f32 = 4.0;

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

    /// Writes the kernel that beliefs make of a film without samples: α, which sums to one. Of what nothing is known takes
    /// the mean. Entries beyond the shorter slice stay as they are.
    pub fn alpha(&self, epsilon: f32, beliefs: &[Belief], alpha: &mut [f32]) {
        let pixels = beliefs.len().min(alpha.len());
        let (beliefs, alpha) = (&beliefs[..pixels], &mut alpha[..pixels]);
        let none = Eight::default();
        for (out, beliefs) in alpha.chunks_mut(8).zip(beliefs.chunks(8)) {
            write8(out, self.weight_of(none, beliefs));
        }
        let known = || alpha.iter().filter(|weight| **weight >= 0.0);
        let (sum, count) = (known().map(|w| f64::from(*w)).sum::<f64>(), known().count());
        let mean = if sum > 0.0 && sum.is_finite() { sum / count as f64 } else { 0.0 };
        let (uniform, epsilon) = (1.0 / pixels as f64, f64::from(epsilon));
        for out in alpha {
            let weight = if *out >= 0.0 { f64::from(*out) } else { mean };
            let part = if mean > 0.0 { weight / (mean * pixels as f64) } else { uniform };
            *out = (epsilon * uniform + (1.0 - epsilon) * part) as f32;
        }
    }

    /// Writes every pixel's weight into the plane `target`. `prior` has one belief a pixel, row by row, or none at all.
    pub(crate) fn adapt(&self, layout: &Layout, planes: &mut Planes<'_>, prior: &[Belief]) {
        for tile in (0..layout.tiles()).map(|t| layout.tile(t)) {
            let seen = self.see(layout, &tile, planes);
            for y in 0..tile.height {
                let first = (tile.y0 + y) as usize * layout.width() as usize + tile.x0 as usize;
                let prior = prior.get(first..first + tile.width as usize).unwrap_or(&[]);
                let out = planes.target[tile.row(y)].chunks_mut(8);
                for (out, x) in out.zip([0, 8]) {
                    let prior = prior.get(x..).unwrap_or(&[]);
                    write8(out, self.weight_of(seen.eight(y as usize, x), prior));
                }
            }
        }
    }

    /// Writes what the windows know of every pixel, row by row.
    pub(crate) fn observe(&self, layout: &Layout, planes: &Planes<'_>, out: &mut [Belief]) {
        for tile in (0..layout.tiles()).map(|t| layout.tile(t)) {
            let seen = self.see(layout, &tile, planes);
            for (y, x) in (0..tile.height as usize).flat_map(|y| [(y, 0), (y, 8)]) {
                let first = (tile.y0 as usize + y) * layout.width() as usize + tile.x0 as usize + x;
                let lanes = (tile.width as usize).saturating_sub(x).min(8);
                let Eight { m2, freedom, light, known, .. } = seen.eight(y, x);
                let variance = (m2 / freedom).to_array();
                let light = (light / known).to_array();
                let freedom = (freedom / f32x8::splat(self.window.weight())).to_array();
                for (k, out) in out[first..first + lanes].iter_mut().enumerate() {
                    let belief = Belief { variance: variance[k], light: light[k], freedom: freedom[k] };
                    *out = belief.usable().unwrap_or(Belief::NONE);
                }
            }
        }
    }

    /// Sums over the windows of a tile.
    fn see(&self, layout: &Layout, tile: &Tile, planes: &Planes<'_>) -> Seen {
        let around = Around::new(layout, tile);
        let light = planes.mean.each_ref().map(|mean| around.load(mean, |mean| mean));
        let light = combine(light.each_ref(), luminance);
        let count = around.load(planes.count, |n| n.min(i32::MAX as u32) as i32 as f32);
        let known = combine([&count], |[n]| n.min(1.0));
        let m2 = self.window.sums(&around.load(planes.m2, |m2| m2));
        let (samples, known) = (self.window.sums(&count), self.window.sums(&known));
        let (light, spent) = (self.window.sums(&light), inner(&count));
        Seen { m2, samples, known, light, spent }
    }

    /// Weights of eight pixels.
    fn weight_of(&self, seen: Eight, prior: &[Belief]) -> f32x8 {
        let Eight { m2, freedom, light, known, spent } = self.filled_up(seen, prior);
        let spent = if self.criterion == Criterion::Mean { spent.fast_max(f32x8::ONE) } else { f32x8::ONE };
        let weight = self.weight(m2 / (freedom * spent), light / known);
        freedom.simd_gt(f32x8::ZERO).bitselect(weight, f32x8::splat(UNKNOWN))
    }

    /// Windows of too few degrees of freedom, filled up by what is believed.
    fn filled_up(&self, seen: Eight, prior: &[Belief]) -> Eight {
        let lanes = |of: &dyn Fn(&Belief) -> f32| {
            let value = |k| prior.get(k).and_then(Belief::usable).map_or(0.0, |belief| of(&belief));
            f32x8::from(core::array::from_fn::<f32, 8, _>(value))
        };
        if prior.is_empty() {
            return seen;
        }
        let weight = f32x8::splat(self.window.weight());
        let lacking = (f32x8::splat(ENOUGH) * weight - seen.freedom).fast_max(f32x8::ZERO);
        let lacking = lacking.fast_min(lanes(&|belief| belief.freedom) * weight);
        let (light, known) = (seen.light + lacking * lanes(&|belief| belief.light), seen.known + lacking);
        // What was bright has its noise from there: beside an edge, in the dark of now, it would look enormous.
        let bright = lanes(&|belief| belief.light) * known;
        let light = lacking.simd_gt(f32x8::ZERO).bitselect(light.fast_max(bright), light);
        Eight {
            m2: seen.m2 + lacking * lanes(&|belief| belief.variance),
            freedom: seen.freedom + lacking,
            light,
            known,
            spent: seen.spent,
        }
    }
}

/// Sums over the windows of a tile, and the pixels' own counts.
struct Seen {
    m2: Inner,
    samples: Inner,
    known: Inner,
    light: Inner,
    spent: Inner,
}

impl Seen {
    /// Eight pixels of row `y` from column `x` on.
    #[inline(always)]
    fn eight(&self, y: usize, x: usize) -> Eight {
        let eight = |inner: &Inner| read8(&inner[y], x);
        let known = eight(&self.known);
        Eight {
            m2: eight(&self.m2),
            freedom: eight(&self.samples) - known,
            light: eight(&self.light),
            known,
            spent: eight(&self.spent),
        }
    }
}

/// The windows of eight pixels, by the weights of the window.
#[derive(Clone, Copy, Default)]
struct Eight {
    /// Sum of squared deviations.
    m2: f32x8,
    /// Degrees of freedom.
    freedom: f32x8,
    /// Sum of luminances of the pixels that have samples, and their number.
    light: f32x8,
    known: f32x8,
    /// The pixel's own samples.
    spent: f32x8,
}

#[cfg(test)]
mod tests;
