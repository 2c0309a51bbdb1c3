//! Transcendental functions, eight lanes at a time: the one door through which the core computes them.
//!
//! Own polynomials made of `+ − × ÷` and bit operations only, without fused multiply-add, so that the same
//! bits come out of every processor and of every `wide` back end (a test pins them). Errors stated are measured by the tests.

use bytemuck::cast;
use core::f32::consts::{LN_2, TAU};
use wide::{f32x8, i32x8};

/// Bits of √½: mantissas are brought into [√½, √2), so that the logarithm's series is short around 1.
const SQRT_HALF_BITS: i32 = 0x3f35_04f3;

/// Polynomial in `x`, coefficients from the lowest power up.
///
/// Even and odd powers apart: two short chains of dependent operations instead of a long one.
#[inline(always)]
pub(crate) fn polynomial<const N: usize>(x: f32x8, coefficients: [f32; N]) -> f32x8 {
    let square = x * x;
    let mut sums = [f32x8::ZERO; 2];
    for (power, c) in coefficients.iter().enumerate().rev() {
        sums[power % 2] = sums[power % 2] * square + f32x8::splat(*c);
    }
    sums[0] + x * sums[1]
}

/// Exponent to base 2 and mantissa in [√½, √2) of a positive number.
#[inline(always)]
fn split(x: f32x8) -> (f32x8, f32x8) {
    let bits: i32x8 = cast(x.fast_max(f32x8::splat(f32::MIN_POSITIVE)));
    let exponent = (bits - i32x8::splat(SQRT_HALF_BITS)) >> 23;
    (f32x8::from_i32x8(exponent), cast(bits - (exponent << 23)))
}

/// Logarithm to base 2 of a positive number; absolute error below 1.2e-7 times the larger of 1 and the result.
///
/// Everything below the smallest normal number, 0 and negative numbers included, counts as that number (−126);
/// infinity gives 128.
#[inline]
pub fn log2(x: f32x8) -> f32x8 {
    let (exponent, mantissa) = split(x);
    let t = (mantissa - f32x8::ONE) / (mantissa + f32x8::ONE);
    // log2 m = 2/ln 2 · artanh t, |t| < 0.172.
    let series = polynomial(t * t, [2.885_39, 0.961_796_7, 0.577_078, 0.412_198_6, 0.320_598_9]);
    exponent + t * series
}

/// [`log2`] without a division; absolute error below 2e-5 times the larger of 1 and the result.
#[inline]
pub fn log2_rough(x: f32x8) -> f32x8 {
    let (exponent, mantissa) = split(x);
    let u = mantissa - f32x8::ONE;
    // Least largest error of log2(1 + u).
    let series = polynomial(u, [1.442_578, -0.720_241_8, 0.486_686_15, -0.394_575_37, 0.252_660_2]);
    exponent + u * series
}

/// 2 to the power `x`; relative error below 2e-7. `x` is clamped to −126 … 127.
#[inline]
pub fn exp2(x: f32x8) -> f32x8 {
    // Taylor series of exp(f·ln 2), |f| ≤ ½.
    exp2_by(
        x,
        [1.0, LN_2, 0.240_226_5, 0.055_504_11, 0.009_618_129, 0.001_333_355_8, 1.540_353e-4, 1.525_273e-5],
    )
}

/// [`exp2`] by fewer terms; relative error below 3e-6.
#[inline]
pub fn exp2_rough(x: f32x8) -> f32x8 {
    // Least largest error of 2^f.
    exp2_by(x, [0.999_999_3, 0.693_121_8, 0.240_247_45, 0.055_917_86, 0.009_570_102])
}

/// 2 to the power `x`, given a polynomial for |x| ≤ ½.
#[inline(always)]
fn exp2_by<const N: usize>(x: f32x8, coefficients: [f32; N]) -> f32x8 {
    let x = x.fast_max(f32x8::splat(-126.0)).fast_min(f32x8::splat(127.0));
    let whole = x.round_ties_even();
    let scale: f32x8 = cast((whole.fast_trunc_int() + i32x8::splat(127)) << 23);
    polynomial(x - whole, coefficients) * scale
}

/// `x` to the power `y` for positive `x`; relative error below 2e-7 · (1 + |y·log2 x|).
#[inline]
pub fn powf(x: f32x8, y: f32x8) -> f32x8 {
    exp2(y * log2(x))
}

/// Sine and cosine of 2π`turn`, `turn` in [−1, 1]; absolute error below 2e-7.
#[inline]
pub fn sin_cos_turn(turn: f32x8) -> (f32x8, f32x8) {
    let quarter = (turn * f32x8::splat(4.0)).round_ties_even();
    let a = (turn - quarter * f32x8::splat(0.25)) * f32x8::splat(TAU);
    let aa = a * a;
    let sin = a * polynomial(aa, [1.0, -1.0 / 6.0, 1.0 / 120.0, -1.0 / 5_040.0, 1.0 / 362_880.0]);
    let cos = polynomial(aa, [1.0, -0.5, 1.0 / 24.0, -1.0 / 720.0, 1.0 / 40_320.0]);
    rotate(quarter.fast_trunc_int(), sin, cos)
}

/// The angle of the point (`x`, `y`) from the x axis, in turns from −½ to ½; absolute error below 6e-8. 0 at the origin.
#[inline]
pub fn turn(x: f32x8, y: f32x8) -> f32x8 {
    let (width, height) = (x.abs(), y.abs());
    let (small, large) = (width.fast_min(height), width.fast_max(height));
    // atan a = ⅛ turn + atan((a − 1)/(a + 1)): what remains is below tan(π/8).
    let near = small.simd_le(large * f32x8::splat(core::f32::consts::SQRT_2 - 1.0));
    let (over, under) = (near.select(small, small - large), near.select(large, small + large));
    let a = over / under.fast_max(f32x8::splat(f32::MIN_POSITIVE));
    // Least squares of atan(a)/(2πa) at Chebyshev's points.
    let series =
        polynomial(a * a, [0.159_154_94, -0.053_050_794, 0.031_790_253, -0.022_045_313, 0.012_708_463]);
    let eighth = near.select(f32x8::ZERO, f32x8::splat(0.125));
    let first = eighth + a * series;
    let quadrant = height.simd_gt(width).select(f32x8::splat(0.25) - first, first);
    x.simd_lt(f32x8::ZERO).select(f32x8::HALF - quadrant, quadrant).copysign(y)
}

/// Sine and cosine after `quarter` turns by 90°.
#[inline(always)]
fn rotate(quarter: i32x8, sin: f32x8, cos: f32x8) -> (f32x8, f32x8) {
    let one = i32x8::splat(1);
    let odd: f32x8 = cast((quarter & one).simd_eq(one));
    let sin_sign: f32x8 = cast((quarter & i32x8::splat(2)) << 30);
    let cos_sign: f32x8 = cast(((quarter + one) & i32x8::splat(2)) << 30);
    (odd.bitselect(cos, sin) ^ sin_sign, odd.bitselect(sin, cos) ^ cos_sign)
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;

    /// Largest deviation of `f` from `exact` over `n` points of [a, b], in units of `scale(exact)`.
    fn worst(a: f64, b: f64, f: fn(f32x8) -> f32x8, exact: fn(f64) -> f64, scale: fn(f64) -> f64) -> f64 {
        let n = 100_000;
        (0..n).fold(0.0, |worst: f64, i| {
            let x = (a + (b - a) * f64::from(i) / f64::from(n)) as f32;
            let y = f(f32x8::splat(x)).to_array();
            assert!(y.iter().all(|v| v.to_bits() == y[0].to_bits()), "lanes differ at {x}");
            let e = exact(f64::from(x));
            worst.max((f64::from(y[0]) - e).abs() / scale(e))
        })
    }

    #[test]
    fn errors_stay_within_what_the_documentation_says() {
        let relative = |e: f64| e.abs();
        let absolute = |_: f64| 1.0;
        assert!(worst(-125.9, 126.9, exp2, libm::exp2, relative) < 2e-7);
        assert!(worst(1e-3, 40.0, log2, libm::log2, |e| e.abs().max(1.0)) < 1.2e-7);
        assert!(worst(-125.9, 126.9, exp2_rough, libm::exp2, relative) < 3e-6);
        assert!(worst(1e-3, 40.0, log2_rough, libm::log2, |e| e.abs().max(1.0)) < 2e-5);
        assert!(worst(1e-37, 1e38, log2, libm::log2, |e| e.abs().max(1.0)) < 1.2e-7);
        assert!(worst(-1.0, 1.0, |x| sin_cos_turn(x).0, |u| libm::sin(u * TAU), absolute) < 2e-7);
        assert!(worst(-1.0, 1.0, |x| sin_cos_turn(x).1, |u| libm::cos(u * TAU), absolute) < 2e-7);
        let angle = |u: f32x8| {
            let (sin, cos) = sin_cos_turn(u);
            turn(cos * f32x8::splat(3.0), sin * f32x8::splat(3.0))
        };
        // The sine and cosine that go in are rounded, too.
        assert!(worst(-0.499_999, 0.499_999, angle, |u| u, absolute) < 1e-7);
        let power = |x| powf(x, f32x8::splat(2.7));
        assert!(worst(0.01, 50.0, power, |x| libm::pow(x, f64::from(2.7f32)), |e| e * 20.0) < 2e-7);
    }

    #[test]
    fn special_values() {
        let at = |x: f32| log2(f32x8::splat(x)).to_array()[0];
        assert_eq!((at(1.0), at(2.0), at(0.5), at(1024.0)), (0.0, 1.0, -1.0, 10.0));
        assert_eq!((at(0.0), at(-3.0), at(f32::INFINITY)), (-126.0, -126.0, 128.0));
        let at = |x: f32| exp2(f32x8::splat(x)).to_array()[0];
        assert_eq!((at(0.0), at(-3.0), at(10.0)), (1.0, 0.125, 1024.0));
        assert_eq!((at(-1e9), at(1e9)), (f32::MIN_POSITIVE, 1.701_411_8e38));
        let at = |turn: f32| {
            let (sin, cos) = sin_cos_turn(f32x8::splat(turn));
            (sin.to_array()[0], cos.to_array()[0])
        };
        assert_eq!((at(0.0), at(0.25), at(0.5), at(0.75), at(1.0)), (EAST, NORTH, WEST, SOUTH, EAST));
        assert_eq!((at(-0.25), at(-0.5), at(-0.75), at(-1.0)), (SOUTH, WEST, NORTH, EAST));
    }

    #[test]
    fn angles_of_axes() {
        let at = |x: f32, y: f32| turn(f32x8::splat(x), f32x8::splat(y)).to_array()[0];
        assert_eq!((at(2.0, 0.0), at(0.0, 2.0), at(-2.0, 0.0), at(0.0, -2.0)), (0.0, 0.25, 0.5, -0.25));
        assert_eq!((at(0.0, 0.0), at(1.0, 1.0), at(-1.0, -1.0)), (0.0, 0.125, -0.375));
    }

    const EAST: (f32, f32) = (0.0, 1.0);
    const NORTH: (f32, f32) = (1.0, 0.0);
    const WEST: (f32, f32) = (0.0, -1.0);
    const SOUTH: (f32, f32) = (-1.0, 0.0);
}
