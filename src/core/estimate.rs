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

use crate::film::{Layout, Moments, Planes, Tile, window::Around, window::square3, window::used_lanes};
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

    /// The colour of pixel `i`, for `Balanced` that of `Difference`; `weight` is N/|P|.
    #[inline]
    pub(crate) fn value(self, planes: &Planes<'_>, i: usize, weight: f32) -> [f32; 3] {
        if self == Estimator::Pooled || weight == 0.0 {
            return planes.mean_at(i);
        }
        [0, 1, 2].map(|c| planes.sum[c][i] / weight)
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
    let known = around.load(|run, out| {
        out.iter_mut().zip(&planes.count[run]).for_each(|(out, n)| *out = f32::from(u8::from(*n > 0)));
    });
    let mean: [_; 3] = [0, 1, 2].map(|c| around.load(|run, out| out.copy_from_slice(&planes.mean[c][run])));
    for y in 0..tile.height as usize {
        let row = tile.row(y as u32);
        for x in (0..tile.width as usize).step_by(8) {
            let lanes = used_lanes(tile.width, x);
            let run = row.start + x..row.start + x + lanes;
            let planned = eight(planes.planned[run.clone()].iter().map(|n| *n as f32));
            let target = eight(planes.target[run.clone()].iter().copied());
            let surplus = target.simd_gt(f32x8::ZERO) & (planned / target);
            let known = square3(&known, x, y).fast_max(f32x8::ONE);
            let factor = f32x8::splat(weight) * (f32x8::ONE - surplus) / known;
            for (sum, mean) in planes.sum.iter_mut().zip(&mean) {
                let add = (square3(mean, x, y) * factor).to_array();
                sum[run.clone()].iter_mut().zip(add).for_each(|(sum, add)| *sum += add);
            }
        }
    }
}

/// Up to eight values, the others 0.
#[inline(always)]
fn eight(values: impl Iterator<Item = f32>) -> f32x8 {
    let mut lanes = [0.0; 8];
    lanes.iter_mut().zip(values).for_each(|(lane, value)| *lane = value);
    f32x8::from(lanes)
}
