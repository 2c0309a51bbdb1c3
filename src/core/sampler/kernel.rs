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
//! [`UNKNOWN`], which [`allocate`](crate::sampler::allocate::allocate) takes for the mean of all others.

use crate::maths::colour::luminance8;
use crate::maths::eight::{count8, read8, write8};
use crate::maths::functions::{exp2_rough, log2_rough};
use crate::maths::tvi::log2_tvi;
use crate::predict::Belief;
use crate::sampler::film::window::{Blocks, SIDE};
use crate::sampler::film::{Layout, Seen, Tile};
use core::ops::Range;
use wide::f32x8;

pub use crate::sampler::film::window::Window;

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
        let ratio = log2_rough(variance * (cd * cd)) - log2_tvi(log2_rough(luminance * cd));
        variance.simd_gt(f32x8::ZERO) & exp2_rough(f32x8::splat(self.gamma) * ratio)
    }

    /// Writes the kernel that beliefs make of a film without samples: α, which sums to one. Of what nothing is known takes
    /// the mean. Entries beyond the shorter slice stay as they are.
    pub fn alpha(&self, epsilon: f32, beliefs: &[Belief], alpha: &mut [f32]) {
        let pixels = beliefs.len().min(alpha.len());
        let (beliefs, alpha) = (&beliefs[..pixels], &mut alpha[..pixels]);
        let none = Eight::default();
        for (out, beliefs) in alpha.chunks_mut(8).zip(beliefs.chunks(8)) {
            let (variance, light) = self.judge(self.filled_up(none, beliefs));
            write8(out, self.weight_or_unknown(variance, light));
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

    /// Writes the weights of the pixels of some tiles into `target`, which is these pixels' part of the plane, and calls `done`
    /// with those of each tile. `prior` has one belief for every pixel of the film, row by row, or none at all.
    pub(crate) fn adapt(
        &self,
        layout: &Layout,
        tiles: Range<u32>,
        film: &Seen<'_>,
        mut target: &mut [f32],
        prior: &[Belief],
        mut done: impl FnMut(&[f32]),
    ) {
        let (mut blocks, mut labels) = (Blocks::new(), Blocks::new());
        for tile in tiles.map(|t| layout.tile(t)) {
            let (weights, rest) = target.split_at_mut(tile.pixels());
            target = rest;
            see(layout, &tile, film, &mut blocks);
            let labels = see_labels(layout, &tile, film, &mut labels);
            self.adapt_tile(layout, &tile, weights, (&blocks, labels), prior);
            done(weights);
        }
    }

    fn adapt_tile(
        &self,
        layout: &Layout,
        tile: &Tile,
        weights: &mut [f32],
        (blocks, labels): (&Blocks<4>, Option<&Blocks<1>>),
        prior: &[Belief],
    ) {
        // Two loops: a weight is a long chain of dependent operations, and the shorter the loop around it, the more
        // of them the processor works on at once.
        let (mut variances, mut lights) = ([[0.0; SIDE]; SIDE], [[0.0; SIDE]; SIDE]);
        let (width, height) = (tile.width as usize, tile.height as usize);
        for x in (0..width).step_by(8) {
            blocks.for_each_row(labels, self.window, x, height, |y, sums, own| {
                let first = raster(layout, tile, x, y);
                let prior = prior.get(first..first + (width - x).min(8)).unwrap_or(&[]);
                let (variance, light) = self.judge(self.filled_up(Eight::new(sums, own), prior));
                write8(&mut variances[y][x..], variance);
                write8(&mut lights[y][x..], light);
            });
        }
        for ((row, variances), lights) in weights.chunks_mut(width).zip(&variances).zip(&lights) {
            for (weights, x) in row.chunks_mut(8).zip([0, 8]) {
                write8(weights, self.weight_or_unknown(read8(&variances[x..]), read8(&lights[x..])));
            }
        }
    }

    /// Writes what the windows know of every pixel, row by row.
    pub(crate) fn observe(&self, layout: &Layout, film: &Seen<'_>, out: &mut [Belief]) {
        let (mut blocks, mut labels) = (Blocks::new(), Blocks::new());
        for tile in (0..layout.tiles()).map(|t| layout.tile(t)) {
            see(layout, &tile, film, &mut blocks);
            let labels = see_labels(layout, &tile, film, &mut labels);
            for x in (0..tile.width as usize).step_by(8) {
                blocks.for_each_row(labels, self.window, x, tile.height as usize, |y, sums, own| {
                    let first = raster(layout, &tile, x, y);
                    let out = &mut out[first..first + (tile.width as usize - x).min(8)];
                    self.believe(&Eight::new(sums, own), out);
                });
            }
        }
    }

    /// What the windows of eight pixels know.
    fn believe(&self, seen: &Eight, out: &mut [Belief]) {
        let variance = (seen.m2 / seen.freedom).to_array();
        let light = (seen.light / seen.known).to_array();
        let freedom = (seen.freedom / f32x8::splat(self.window.weight())).to_array();
        for (k, out) in out.iter_mut().enumerate() {
            let belief = Belief { variance: variance[k], light: light[k], freedom: freedom[k] };
            *out = belief.usable().unwrap_or(Belief::NONE);
        }
    }

    /// The variance that counts, or [`UNKNOWN`], and the mean luminance.
    #[inline(always)]
    fn judge(&self, seen: Eight) -> (f32x8, f32x8) {
        let Eight { m2, freedom, light, known, spent } = seen;
        let divisor =
            if self.criterion == Criterion::Mean { freedom * spent.fast_max(f32x8::ONE) } else { freedom };
        (freedom.simd_gt(f32x8::ZERO).select(m2 / divisor, f32x8::splat(UNKNOWN)), light / known)
    }

    #[inline(always)]
    fn weight_or_unknown(&self, variance: f32x8, light: f32x8) -> f32x8 {
        let weight = self.weight(variance, light);
        variance.simd_lt(f32x8::ZERO).select(f32x8::splat(UNKNOWN), weight)
    }

    /// Windows of too few degrees of freedom, filled up by what is believed.
    #[inline(always)]
    fn filled_up(&self, seen: Eight, prior: &[Belief]) -> Eight {
        if prior.is_empty() {
            return seen;
        }
        let [variance, brightness, freedom] = decoded(prior);
        let weight = f32x8::splat(self.window.weight());
        let lacking = (f32x8::splat(ENOUGH) * weight - seen.freedom).fast_max(f32x8::ZERO);
        let lacking = lacking.fast_min(freedom * weight);
        let (light, known) = (seen.light + lacking * brightness, seen.known + lacking);
        // What was bright has its noise from there: beside an edge, in the dark of now, it would look enormous.
        let bright = brightness * known;
        let light = lacking.simd_gt(f32x8::ZERO).bitselect(light.fast_max(bright), light);
        Eight {
            m2: seen.m2 + lacking * variance,
            freedom: seen.freedom + lacking,
            light,
            known,
            spent: seen.spent,
        }
    }
}

/// Variances, luminances and degrees of freedom of up to eight beliefs; of those that cannot be used, zeros.
#[inline(always)]
fn decoded(beliefs: &[Belief]) -> [f32x8; 3] {
    let mut lanes = [[0.0; 8]; 3];
    for (k, belief) in beliefs.iter().take(8).enumerate() {
        let Belief { variance, light, freedom } = belief.usable().unwrap_or(Belief::NONE);
        (lanes[0][k], lanes[1][k], lanes[2][k]) = (variance, light, freedom);
    }
    lanes.map(f32x8::from)
}

/// Fills the blocks with what the kernel looks at around `tile`: squared deviations, degrees of freedom, luminance,
/// and whether there is a sample at all.
fn see(layout: &Layout, tile: &Tile, film: &Seen<'_>, blocks: &mut Blocks<4>) {
    blocks.fill(layout, tile, |pixels| {
        let count = count8(&film.count[pixels.clone()]);
        let known = count.fast_min(f32x8::ONE);
        let m2 = read8(&film.m2[pixels.clone()]);
        [m2, count - known, luminance8(film.mean8(pixels)), known]
    });
}

/// Fills the block with the labels around `tile`, if pixels have any.
fn see_labels<'b>(
    layout: &Layout,
    tile: &Tile,
    film: &Seen<'_>,
    labels: &'b mut Blocks<1>,
) -> Option<&'b Blocks<1>> {
    if film.label.is_empty() {
        return None;
    }
    labels.fill(layout, tile, |pixels| [count8(&film.label[pixels])]);
    Some(labels)
}

/// The place of a tile's pixel in the picture's rows.
fn raster(layout: &Layout, tile: &Tile, x: usize, y: usize) -> usize {
    (tile.y0 as usize + y) * layout.width() as usize + tile.x0 as usize + x
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

impl Eight {
    /// From the sums over the windows and the pixels' own quantities, as [`see`] orders them.
    #[inline(always)]
    fn new([m2, freedom, light, known]: [f32x8; 4], own: [f32x8; 4]) -> Self {
        Eight { m2, freedom, light, known, spent: own[1] + own[3] }
    }
}

#[cfg(test)]
mod tests;
