//! The lobe against a twin in double precision, written as Walter et al. 2007 and Heitz 2014 print it: by tangents and
//! Λ instead of the roots the core works with.

extern crate std;

use super::*;
use crate::tracer::scene::MIN_ROUGHNESS;
use core::f64::consts::{PI, TAU};
use std::vec::Vec;

mod scattering;

type V = [f64; 3];

const SPECULAR: [f32; 3] = [1.0, 0.5, 0.04];

/// From the narrowest lobe to the widest, a decade apart.
const WIDTHS: [f32; 7] = [MIN_ROUGHNESS, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0];

/// Cosines of the directions the lobe is seen from.
const COSINES: [f64; 5] = [1.0, 0.9, 0.5, 0.1, 0.02];

/// The lobe in double precision, seen from `outgoing`.
struct Twin {
    alpha: f64,
    outgoing: V,
}

impl Twin {
    fn lambda(&self, cosine: f64) -> f64 {
        let tan2 = (1.0 - cosine * cosine).max(0.0) / (cosine * cosine);
        0.5 * (libm::sqrt(1.0 + self.alpha * self.alpha * tan2) - 1.0)
    }

    fn distribution(&self, half: V) -> f64 {
        let (alpha2, cos2) = (self.alpha * self.alpha, half[2] * half[2]);
        let tan2 = (half[0] * half[0] + half[1] * half[1]) / cos2;
        let spread = 1.0 + tan2 / alpha2;
        1.0 / (PI * alpha2 * cos2 * cos2 * spread * spread)
    }

    /// What a sampled direction carries: Fresnel times shadowing of the direction, given that of the view.
    fn weight(&self, incoming: V) -> V {
        let (o, i) = (self.lambda(self.outgoing[2]), self.lambda(incoming[2]));
        let half = unit(sum(self.outgoing, incoming));
        let m = libm::pow((1.0 - dot(self.outgoing, half)).max(0.0), 5.0);
        SPECULAR.map(|s| (f64::from(s) + (1.0 - f64::from(s)) * m) * (1.0 + o) / (1.0 + o + i))
    }

    fn density(&self, incoming: V) -> f64 {
        let half = unit(sum(self.outgoing, incoming));
        self.distribution(half) / ((1.0 + self.lambda(self.outgoing[2])) * 4.0 * self.outgoing[2])
    }

    fn sample(&self, u: f64, v: f64) -> V {
        let stretch = |d: V| unit([d[0] * self.alpha, d[1] * self.alpha, d[2]]);
        let view = stretch(self.outgoing);
        let z = (1.0 - v) * (1.0 + view[2]) - view[2];
        let radius = libm::sqrt((1.0 - z * z).max(0.0));
        mirrored(
            self.outgoing,
            stretch(sum([radius * libm::cos(u * TAU), radius * libm::sin(u * TAU), z], view)),
        )
    }
}

fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn sum(a: V, b: V) -> V {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn unit(a: V) -> V {
    let length = libm::sqrt(dot(a, a));
    a.map(|c| c / length)
}

fn mirrored(outgoing: V, half: V) -> V {
    let twice = 2.0 * dot(outgoing, half);
    [0, 1, 2].map(|axis| twice * half[axis] - outgoing[axis])
}

fn single(v: V) -> [f32; 3] {
    v.map(|c| c as f32)
}

fn double(v: [f32; 3]) -> V {
    v.map(f64::from)
}

fn first(v: Vec3x8) -> [f32; 3] {
    [v.x, v.y, v.z].map(|row| row.to_array()[0])
}

/// A direction of this cosine, off every axis.
fn seen_at(cosine: f64) -> [f32; 3] {
    let sine = libm::sqrt(1.0 - cosine * cosine);
    single([sine * libm::cos(0.7), sine * libm::sin(0.7), cosine])
}

/// The lobe alone and its twin.
fn both(alpha: f32, outgoing: [f32; 3]) -> (Rough, Twin) {
    let rough = Rough {
        diffuse: Vec3x8::default(),
        specular: Vec3x8::splat(SPECULAR),
        alpha2: f32x8::splat(alpha * alpha),
        alpha: f32x8::splat(alpha),
        outgoing: Vec3x8::splat(outgoing),
        lobe: f32x8::ONE,
        has_lobe: true,
    };
    (rough, Twin { alpha: f64::from(alpha), outgoing: double(outgoing) })
}

/// Directions above the horizon whose half vectors have slopes from 0 to a thousand widths.
fn incoming(twin: &Twin) -> Vec<[f32; 3]> {
    let slopes = [0.0, 0.01, 0.1, 0.5, 1.0, 2.0, 10.0, 100.0, 1000.0].map(|s| s * twin.alpha);
    let halves = slopes.into_iter().flat_map(|slope| {
        (0..7).map(move |turn| {
            let angle = f64::from(turn) * 0.9;
            unit([slope * libm::cos(angle), slope * libm::sin(angle), 1.0])
        })
    });
    halves.map(|half| single(mirrored(twin.outgoing, half))).filter(|i| i[2] > 1e-3).collect()
}

/// Largest relative deviation over all widths, views and directions of what `of` says from what the twin does.
fn worst(of: impl Fn(&Rough, &Twin, [f32; 3]) -> f64) -> f64 {
    let mut worst = 0.0f64;
    for (alpha, cosine) in WIDTHS.into_iter().flat_map(|alpha| COSINES.map(|cosine| (alpha, cosine))) {
        let (rough, twin) = both(alpha, seen_at(cosine));
        for direction in incoming(&twin) {
            let deviation = of(&rough, &twin, direction);
            assert!(deviation.is_finite(), "α {alpha} seen at cosine {cosine} in {direction:?}");
            worst = worst.max(deviation);
        }
    }
    worst
}

fn deviation(measured: f32, exact: f64) -> f64 {
    (f64::from(measured) / exact - 1.0).abs()
}

/// Between directions as single precision gives them, value and density are right to its last digits: where two
/// directions nearly mirror each other, their tangential parts cancel without rounding.
#[test]
fn value_and_density_are_those_of_double_precision() {
    let density = worst(|rough, twin, direction| {
        let (_, density) = rough.evaluate(Vec3x8::splat(direction));
        deviation(density.to_array()[0], twin.density(double(direction)))
    });
    assert!(density < 2e-6, "density off by {density}");
    let value = worst(|rough, twin, direction| {
        let value = first(rough.evaluate(Vec3x8::splat(direction)).0);
        let weight = twin.weight(double(direction)).map(|w| w * twin.density(double(direction)));
        (0..3).map(|channel| deviation(value[channel], weight[channel])).fold(0.0, f64::max)
    });
    assert!(value < 2e-6, "value off by {value}");
}

/// The negative control: 1 − (1 − α²) cos² in single precision, which the comparison above would notice.
#[test]
fn a_denominator_that_cancels_is_noticed() {
    let (rough, twin) = both(1e-3, seen_at(0.5));
    let worst = incoming(&twin).into_iter().fold(0.0f64, |worst, direction| {
        let half = (rough.outgoing + Vec3x8::splat(direction)).normalized();
        let base = half.z * half.z * (rough.alpha2 - f32x8::ONE) + f32x8::ONE;
        let distribution = (rough.alpha2 * f32x8::splat(FRAC_1_PI) / (base * base)).to_array()[0];
        worst.max(deviation(distribution, twin.distribution(unit(sum(twin.outgoing, double(direction))))))
    });
    assert!(worst > 1e-2, "{worst}");
}

/// Numbers `u`, `v` at the centres of a grid's cells, one in single precision what it is in double.
fn grid() -> impl Iterator<Item = [f32; 2]> {
    const SIDE: u16 = 64;
    let at = |i: u16| (f32::from(i) + 0.5) / f32::from(SIDE);
    (0..SIDE * SIDE).map(move |i| [at(i % SIDE), at(i / SIDE)])
}

/// What sampled directions carry, and how much of the light that is in all, is right however narrow the lobe is.
#[test]
fn sampled_directions_carry_what_they_should() {
    for (alpha, cosine) in WIDTHS.into_iter().flat_map(|alpha| COSINES.map(|cosine| (alpha, cosine))) {
        let (rough, twin) = both(alpha, seen_at(cosine));
        let (mut carried, mut exact, mut count) = (0.0, 0.0, 0.0);
        for [u, v] in grid() {
            let expected = twin.sample(u.into(), v.into());
            let direction = rough.sample(f32x8::splat(u), f32x8::splat(v), || f32x8::ZERO);
            let (value, density) = rough.evaluate(direction);
            let (value, density, direction) = (first(value), density.to_array()[0], first(direction));
            count += 1.0;
            exact += if expected[2] > 0.0 { twin.weight(expected)[1] } else { 0.0 };
            if direction[2] <= 0.0 {
                assert_eq!((value, density), ([0.0; 3], 0.0));
                continue;
            }
            let weight = twin.weight(double(direction));
            for channel in 0..3 {
                let off = deviation(value[channel] / density, weight[channel]);
                assert!(off < 2e-6, "α {alpha} seen at cosine {cosine}: off by {off}");
            }
            carried += f64::from(value[1] / density);
        }
        let off = (carried - exact).abs() / count;
        assert!(off < 2e-6, "α {alpha} seen at cosine {cosine}: {off} of the light");
    }
}

/// A sampled half vector is where it should be, up to the rounding of the direction it makes: that is what limits the
/// width.
#[test]
fn sampled_half_vectors_are_off_by_rounding() {
    for (alpha, cosine) in WIDTHS.into_iter().flat_map(|alpha| COSINES.map(|cosine| (alpha, cosine))) {
        let (rough, twin) = both(alpha, seen_at(cosine));
        for [u, v] in grid() {
            let expected = twin.sample(u.into(), v.into());
            let direction = first(rough.sample(f32x8::splat(u), f32x8::splat(v), || f32x8::ZERO));
            if expected[2] <= 1e-3 {
                continue;
            }
            let half = |direction: V| unit(sum(twin.outgoing, direction));
            let (is, should) = (half(double(direction)), half(expected));
            let off = libm::hypot(is[0] - should[0], is[1] - should[1]);
            // Beside the direction's rounding that of the sines and of the half vector itself, in units of its length.
            let allowed = 3e-8 / cosine + 1e-4 * libm::hypot(should[0], should[1]);
            assert!(off < allowed, "α {alpha} seen at cosine {cosine}: off by {off}, allowed {allowed}");
        }
    }
}
