//! The four estimators: how a pixel's samples of several iterations become its colour.
//!
//! With M_{s,p} the mean of pixel p's samples of iteration s, N_s the samples of iteration s and N their sum:
//! - pooled: Q_p, the mean of all samples. Least error, but biased dark, since counts follow earlier samples.
//! - subframe: S_p = Σ_s (N_s/N)·M_{s,p}, the paper's average of sub-images. Unbiased if every pixel has a sample
//!   in every iteration (floor m ≥ 1). An iteration without one takes the pooled mean of the earlier ones
//!   instead, and is then as biased as that.
//! - difference: D_p = Σ_s (N_s/N)·\[c + Σ_k (L_k − c)/n'_p\], c the mean over 3 × 3 pixels of what was known
//!   before the iteration. Unbiased wherever n'_p > 0, since E\[n_p | past\] = n'_p. Where n'_p = 0 (no floor, no
//!   uniform part, no weight) the iteration contributes c. A rejected sample counts as black.
//! - balanced: C = Q + G∗(D − Q), G three box passes of radius r, about a Gaussian of σ² = r(r + 1), reflected at
//!   the borders so that rows and columns of G sum to one: the image's energy is D's, exactly unbiased, and the
//!   error about Q's. A pixel can become negative; to clip it would be a bias.
//!
//! Everything is accumulated while streaming, in one RGB plane besides the mean. Iterations are weighted by N_s/|P|
//! instead of N_s, so that the sums stay near the size of radiances.

use crate::film::window::{Around, read8, square3, write8};
use crate::film::{Layout, Moments, Planes, Tile};
use wide::f32x8;

mod smooth;
pub use smooth::{Lanes, MAX_RADIUS};
pub(crate) use smooth::{scratch_len, smooth};

/// Which estimator makes the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Estimator {
    /// The mean of all samples: biased.
    Pooled,
    /// The average of the iterations' pictures.
    Subframe,
    /// Unbiased through expected counts, noisy where few samples are expected.
    Difference,
    /// Pooled, with the energy it lost given back to the neighbourhood by `Difference`.
    #[default]
    Balanced,
}

impl Estimator {
    /// Whether a film that accumulated for `self` can be resolved by `other`.
    pub fn serves(self, other: Estimator) -> bool {
        let plane = |e| match e {
            Estimator::Pooled => 0,
            Estimator::Subframe => 1,
            Estimator::Difference | Estimator::Balanced => 2,
        };
        other == Estimator::Pooled || plane(self) == plane(other)
    }

    /// Adds what follows from an iteration's plan alone; `weight` is N_s/|P|.
    pub(crate) fn plan(self, layout: &Layout, planes: &mut Planes<'_>, weight: f32) {
        match self {
            Estimator::Pooled => {}
            Estimator::Subframe => stand_in(planes, weight),
            Estimator::Difference | Estimator::Balanced => {
                (0..layout.tiles()).for_each(|t| anchor_tile(layout, &layout.tile(t), planes, weight));
            }
        }
    }

    /// Adds the samples `new` of pixel `i`, before they are merged into its mean.
    #[inline]
    pub(crate) fn arrive(self, planes: &mut Planes<'_>, i: usize, new: &Moments, weight: f32) {
        let (value, factor) = match self {
            Estimator::Pooled => return,
            Estimator::Subframe if new.count == 0 => (planes.mean_at(i), weight),
            Estimator::Subframe => (new.mean, weight),
            Estimator::Difference | Estimator::Balanced => {
                (new.mean, weight * (new.count as f32 / planes.target[i]))
            }
        };
        for (sum, value) in planes.sum.iter_mut().zip(value) {
            sum[i] += factor * value;
        }
    }

    /// The colour of pixel `i`, for `Balanced` that of `Difference`; `share` is |P|/N.
    #[inline]
    pub(crate) fn value(self, planes: &Planes<'_>, i: usize, share: f32) -> [f32; 3] {
        match self {
            Estimator::Pooled => planes.mean_at(i),
            _ => [0, 1, 2].map(|c| planes.sum[c][i] * share),
        }
    }
}

/// Subframe: pixels without a sample in this iteration take their mean of the earlier ones.
fn stand_in(planes: &mut Planes<'_>, weight: f32) {
    for (sum, mean) in planes.sum.iter_mut().zip(&planes.mean) {
        for ((sum, mean), planned) in sum.iter_mut().zip(mean.iter()).zip(planes.planned.iter()) {
            *sum += if *planned == 0 { weight * mean } else { 0.0 };
        }
    }
}

/// Difference: the part c·(1 − n_p/n'_p) of every pixel of a tile.
fn anchor_tile(layout: &Layout, tile: &Tile, planes: &mut Planes<'_>, weight: f32) {
    let around = Around::new(layout, tile);
    let known = around.load(planes.count, |n| f32::from(u8::from(n > 0)));
    let mean = planes.mean.each_ref().map(|mean| around.load(mean, |mean| mean));
    for y in 0..tile.height as usize {
        let row = tile.row(y as u32);
        for (x, first) in (0..).step_by(8).zip(row.clone().step_by(8)) {
            let run = first..row.end.min(first + 8);
            let mut surplus = [0.0; 8];
            let counts = planes.planned[run.clone()].iter().zip(&planes.target[run.clone()]);
            for (surplus, (n, expected)) in surplus.iter_mut().zip(counts) {
                *surplus = if *expected > 0.0 { *n as f32 / expected } else { 0.0 };
            }
            let known = square3(&known, x, y).fast_max(f32x8::ONE);
            let factor = f32x8::splat(weight) * (f32x8::ONE - f32x8::from(surplus)) / known;
            for (sum, mean) in planes.sum.iter_mut().zip(&mean) {
                let sum = &mut sum[run.clone()];
                write8(sum, read8(sum) + square3(mean, x, y) * factor);
            }
        }
    }
}
