//! The four estimators: how a pixel's samples of several iterations become its colour.
//!
//! With M_{s,p} the mean of pixel p's samples of iteration s, N_s the samples of iteration s and N their sum:
//! - pooled: Q_p, the mean of all samples. Least error, but biased dark, since counts follow earlier samples.
//! - subframe: S_p = Σ_s (N_s/N)·M_{s,p}, the paper's average of sub-images. Unbiased if every pixel has a sample
//!   in every iteration (floor m ≥ 1). An iteration without one takes the pooled mean of the earlier ones
//!   instead, and is then as biased as that.
//! - difference: D_p = Σ_s (N_s/N)·\[c + Σ_k (L_k − c)/n'_p\], c the pixel's pooled mean before the iteration.
//!   Unbiased wherever n'_p > 0, since E\[n_p | past\] = n'_p. Where n'_p = 0 (no floor, no uniform part, no
//!   weight) the iteration contributes c. A rejected sample counts as black.
//! - balanced: C = Q + a·G((D − Q)/Gᵀa), G about a Gaussian of σ² = r(r + 1), reflected at the borders; a = √L(Q)
//!   says how much a pixel takes of what its neighbourhood has lost. Whatever a and G are, ΣC = ΣD: the image's
//!   energy is exactly unbiased, and the error is about Q's. G = UBV: V sums over cells of 8 × 8 pixels and is
//!   divided by what its cell's takers take, B is three box passes over the grid of cells, U interpolates
//!   linearly between their centres. (On single pixels it took five times as long.) With
//!   a = 1 (measured: Err ratio 3.1 instead of 3.6 on `caustic`, as √L; tvi(L) and L lose in low-pass Err) noise
//!   would be spread onto black background, where it shows. A pixel can become negative; to clip it would be a
//!   bias.
//!
//! Everything is accumulated while streaming, in one RGB plane besides the mean: W·(E − Q), where E is the
//! estimator and W = Σ_s w_s, w_s = N_s/|P| (samples a pixel, so that sums stay near the size of radiances). An
//! iteration that leaves a pixel alone adds w·Q to W·E and to W·Q, hence nothing to the plane, and costs nothing.

use wide::f32x8;

mod picture;
mod smooth;
pub(crate) use picture::{balanced, plain, scratch_len};
pub use smooth::{Lanes, MAX_RADIUS};

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

    /// By how much the excess of eight pixels grows when new samples are merged; none if nothing is accumulated.
    ///
    /// With c the pixel's mean and M that of the new samples, W·E grows by w·c + a·(M − c) − b·c, and W·Q by
    /// w·c + (W + w)·(M − c)·(the part of the new ones in all samples).
    #[inline(always)]
    pub(crate) fn gain(self, new: &Arrival, weight: Weight) -> Option<[f32x8; 3]> {
        let iteration = f32x8::splat(weight.iteration);
        let (a, b) = match self {
            Estimator::Pooled => return None,
            Estimator::Subframe => (iteration, f32x8::ZERO),
            Estimator::Difference | Estimator::Balanced => {
                let each = iteration / new.target;
                (each * new.count, new.rejected.simd_gt(f32x8::ZERO) & (each * new.rejected))
            }
        };
        // Where nothing is expected nothing is new, and what was divided by 0 above is masked.
        let factor = a - f32x8::splat(weight.before + weight.iteration) * new.share;
        let factor = new.count.simd_gt(f32x8::ZERO) & factor;
        Some([0, 1, 2].map(|c| factor * new.delta[c] - b * new.mean[c]))
    }
}

/// New samples of eight pixels.
pub(crate) struct Arrival {
    /// Mean before.
    pub mean: [f32x8; 3],
    /// How far the mean of the new samples is from it.
    pub delta: [f32x8; 3],
    /// Usable new samples.
    pub count: f32x8,
    /// Others.
    pub rejected: f32x8,
    /// The part of the new samples in all.
    pub share: f32x8,
    /// Expected new samples.
    pub target: f32x8,
}

/// Samples a pixel: of all iterations before the running one, W, and of the running one, w.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weight {
    pub before: f32,
    pub iteration: f32,
}
