//! The estimators: how a pixel's samples of several iterations become its colour.
//!
//! With M_{s,p} the mean of pixel p's samples of iteration s, N_s the samples of iteration s and N their sum:
//! - pooled: Q_p, the mean of all samples. Least error, but biased dark, since counts follow earlier samples.
//! - subframe: S_p = Σ_s (N_s/N)·M_{s,p}, the paper's average of sub-images. Every pixel gets a sample in every iteration
//!   that has as many. Unbiased if each iteration's points are scrambled anew
//!   ([`Sequence::Fresh`](crate::sampler::Sequence)); points that continue a sequence avoid where the last ones were,
//!   and so hang together with what decided their number.
//! - difference: D_p, the mean of the pixel's fair samples: its first ones, as many in every pixel, fixed before the
//!   frame. Unbiased in every pixel, since nothing that was seen decides which these are, with any points; noisy, since
//!   they are few.
//! - balanced: C = F + a·G((D − F)/Gᵀa) with F = Q, G about a Gaussian of σ² = r(r + 1), reflected at the borders; a = √L(F)
//!   says how much a pixel takes of what its neighbourhood has lost. Whatever a and G are, ΣC = ΣD: the image's
//!   energy is exactly unbiased, and the error is about Q's. G = UBV: V sums over cells of 8 × 8 pixels and is
//!   divided by what its cell's takers take, B is three box passes over the grid of cells, U interpolates
//!   linearly between their centres. (On single pixels it took five times as long.) With
//!   a = 1 (measured: Err ratio 3.1 instead of 3.6 on `caustic`, as √L; tvi(L) and L lose in low-pass Err) noise
//!   would be spread onto black background, where it shows. A pixel can become negative; to clip it would be a
//!   bias.
//!
//! Where pixels have labels, G is that of each island by itself: sums, takers and boxes are taken over its own pixels, in the
//! rectangle of cells that holds it, with the same reflection at the rectangle's borders. Cells without any of its pixels
//! dilute what is given back and what is taken alike, so the quotient does not see them, and ΣC = ΣD for every island.
//!
//! F can be any picture ([`Sampler::resolve_guided`](crate::sampler::Sampler::resolve_guided)): the energy is D's, the error
//! about F's. Then a = √(L(F) + 10⁻⁶·|F − Q|), so that what a black F loses finds takers as well. A negative L(F) counts as 0;
//! what of Q is negative, because samples are, counts like light.
//!
//! D and S are accumulated while streaming, in one RGB plane besides Q. A rejected sample counts as black in them.

mod picture;
pub mod resolve;
mod smooth;
mod source;
pub(crate) use picture::scratch_len;
pub use resolve::Resolving;
pub(crate) use smooth::radii;
pub use smooth::{Lanes, MAX_RADIUS};
pub(crate) use source::{Apart, Energy, Lent, Own};

/// Which estimator makes the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Estimator {
    /// The mean of all samples: biased.
    Pooled,
    /// The average of the iterations' pictures.
    Subframe,
    /// The mean of the fair samples: unbiased, and noisy, since they are few.
    Difference,
    /// Pooled, with the energy it lost given back to the neighbourhood by `Difference`.
    #[default]
    Balanced,
    /// A lent picture, with the energy it lost given back likewise: by
    /// [`resolve_guided`](crate::sampler::Sampler::resolve_guided) alone.
    Guided,
}

impl Estimator {
    /// Whether a film that accumulated for `self` can be resolved by `other`.
    pub fn serves(self, other: Estimator) -> bool {
        let plane = |e| match e {
            Estimator::Pooled => 0,
            Estimator::Subframe => 1,
            Estimator::Difference | Estimator::Balanced | Estimator::Guided => 2,
        };
        other == Estimator::Pooled || plane(self) == plane(other)
    }
}
