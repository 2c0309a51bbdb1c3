//! Threshold versus intensity: the smallest luminance difference the eye sees at a given adaptation luminance.
//!
//! Ferwerda, Pattanaik, Shirley, Greenberg, *A model of visual adaptation for realistic image synthesis*,
//! SIGGRAPH 1996: one curve for cones, one for rods, both piecewise in log10 of the luminance; the lower one
//! counts. Units: cd/m² in, cd/m² out. Adaptation is floored at [`DARKEST`], so that black has a threshold too.
//! As published, the pieces do not meet exactly: the curve steps by 0.012 (log10) at −1.44 and by 0.003 at 1.9.

use crate::maths::functions::{exp2, log2, polynomial};
use wide::f32x8;

/// Adaptation luminance, in cd/m², below which the threshold no longer falls.
pub const DARKEST: f32 = 1e-5;

/// Logarithm to base 2 of [`DARKEST`].
const LOG2_DARKEST: f32 = -16.609_64;
const LOG2_10: f32 = core::f32::consts::LOG2_10;

/// Threshold at the adaptation luminance `luminance`, both in cd/m². Negative luminance counts as black.
#[inline]
pub fn tvi(luminance: f32x8) -> f32x8 {
    exp2(log2_tvi(log2(luminance)))
}

/// Logarithm to base 2 of [`tvi`], from that of the luminance.
///
/// Rods are the more sensitive below about 0.96 cd/m², where their curve is on its last, straight piece. So
/// the rods' bend is needed left of −1.44 only, the cones' right of where it falls below that straight piece.
/// Both are polynomials of least largest error (3.3e-6): powers proper would cost as much as all the rest of a
/// weight. The rods' runs in the root of its base, since the power is not smooth where it begins; what is
/// darker has base 0 and there the constant piece.
#[inline]
pub(crate) fn log2_tvi(log2_luminance: f32x8) -> f32x8 {
    let s = f32x8::splat;
    let x = log2_luminance.fast_max(s(LOG2_DARKEST));
    let root = (s(0.405 / LOG2_10) * x + s(1.6)).fast_max(f32x8::ZERO).sqrt();
    let rod = polynomial(
        root,
        [
            -9.500_711,
            -0.000_514_114_7,
            0.013_978_359,
            -0.168_462_05,
            2.059_886_2,
            1.894_457_1,
            -0.591_923_2,
            0.114_503_04,
        ],
    );
    let bend = polynomial(x, [-1.353_648, 0.323_221_6, 0.031_703_42, 0.000_841_898, -0.000_005_048_49]);
    let cone = x.simd_lt(s(1.9 * LOG2_10)).select(bend, x - s(1.255 * LOG2_10));
    let straight = x - s(0.395 * LOG2_10);
    x.simd_lt(s(-1.44 * LOG2_10)).select(rod, straight.fast_min(cone))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The two curves as printed, in double precision.
    fn scalar(luminance: f64) -> f64 {
        let x = libm::log10(luminance.max(f64::from(DARKEST)));
        let cone = match x {
            x if x <= -2.6 => -0.72,
            x if x >= 1.9 => x - 1.255,
            x => libm::pow(0.249 * x + 0.65, 2.7) - 0.72,
        };
        let rod = match x {
            x if x <= -3.94 => -2.86,
            x if x >= -1.44 => x - 0.395,
            x => libm::pow(0.405 * x + 1.6, 2.18) - 2.86,
        };
        libm::pow(10.0, f64::min(cone, rod))
    }

    #[test]
    fn equals_the_scalar_twin() {
        for i in 0..20_000 {
            let x = -6.0 + 14.0 * (f64::from(i) + 0.31) / 20_000.0;
            let luminance = libm::pow(10.0, x) as f32;
            let got = f64::from(tvi(f32x8::splat(luminance)).to_array()[0]);
            let want = scalar(f64::from(luminance));
            // At −3.94 the rods' curve steps by 1.6e-5, which ours does a little to the left.
            assert!((got / want - 1.0).abs() < 2e-5, "at {luminance}: {got}, not {want}");
        }
    }

    #[test]
    fn pinned_values() {
        let pinned = [
            (-5.0, 0.001_380_384),
            (0.0, 0.001_380_384),
            (0.01, 0.005_472_343),
            (1.0, 0.391_301_5),
            (100.0, 5.559_043),
        ];
        for (luminance, want) in pinned {
            let got = tvi(f32x8::splat(luminance)).to_array()[0];
            assert!((got / want - 1.0).abs() < 1e-5, "at {luminance}: {got}, not {want}");
        }
    }

    #[test]
    fn grows_with_luminance_apart_from_the_published_steps() {
        let mut last = 0.0;
        for i in 0..4_000 {
            let luminance = libm::pow(10.0, -6.0 + 0.003 * f64::from(i)) as f32;
            let now = tvi(f32x8::splat(luminance)).to_array()[0];
            assert!(now >= last * 0.97, "falls at {luminance}");
            last = now;
        }
    }
}
