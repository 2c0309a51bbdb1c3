//! Whether directions are sampled with the density that [`Rough::evaluate`] says, by Pearson's χ².
//!
//! Bins are cells of the hemisphere that hold little of the density and over which it can be integrated; small ones
//! are pooled with their neighbours. Samples below the horizon, by which the density integrates to less than 1, are
//! one more bin.

extern crate std;

use super::quadrature::Cell;
use super::*;
use std::vec::Vec;

/// Chance that any of the tests fails though all densities are right.
const ALPHA: f64 = 0.01;
/// Diffuse, four widths at four angles, four mixtures.
const TESTS: usize = 1 + 16 + 4;
const SAMPLES: usize = 1 << 17;
/// Least expected count of a bin.
const LEAST: f64 = 5.0;
/// Cells that hold more of the density than this are split.
const MOST: f64 = 1.0 / 512.0;

/// Šidák's level of one test.
fn level() -> f64 {
    1.0 - libm::pow(1.0 - ALPHA, 1.0 / TESTS as f64)
}

/// SplitMix64: independent numbers, unlike the renderer's, which are more even than chance.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ x >> 31
    }

    fn eight(&mut self) -> f32x8 {
        f32x8::from([0; 8].map(|_| (self.bits() >> 40) as f32 / (1 << 24) as f32))
    }
}

/// Cosines and azimuths, in turns, of samples above the horizon.
fn samples(surface: &Rough, seed: u64) -> Vec<(f64, f64)> {
    let mut random = Random(seed);
    let mut points = Vec::new();
    for _ in 0..SAMPLES / 8 {
        let (u, v, part) = (random.eight(), random.eight(), random.eight());
        let d = surface.sample(u, v, || part);
        let rows = [d.x, d.y, d.z].map(f32x8::to_array);
        for lane in 0..8 {
            let [x, y, z] = rows.map(|row| f64::from(row[lane]));
            if z > 0.0 {
                let turn = libm::atan2(y, x) / core::f64::consts::TAU;
                points.push((z, if turn < 0.0 { turn + 1.0 } else { turn }));
            }
        }
    }
    points
}

/// Expected and found count.
type Bin = (f64, f64);

/// Splits `cell` and `points` until each cell holds little, and adds the bins.
fn bins(cell: Cell, density: &impl Fn(Vec3x8) -> f32x8, points: &[(f64, f64)], out: &mut Vec<Bin>) {
    let (mass, split) = cell.judge(density, MOST);
    if !split {
        out.push((mass * SAMPLES as f64, points.len() as f64));
        return;
    }
    for quarter in cell.quarters() {
        let inside: Vec<_> = points.iter().copied().filter(|p| quarter.holds(p.0, p.1)).collect();
        bins(quarter, density, &inside, out);
    }
}

/// Joins bins that are too small with those that follow, the last with the one before.
fn pooled(small: &[Bin]) -> Vec<Bin> {
    let mut out: Vec<Bin> = Vec::new();
    let mut open = (0.0, 0.0);
    for bin in small {
        open = (open.0 + bin.0, open.1 + bin.1);
        if open.0 >= LEAST {
            out.push(core::mem::take(&mut open));
        }
    }
    if let Some(last) = out.last_mut() {
        *last = (last.0 + open.0, last.1 + open.1);
    }
    out
}

/// The probability of counts that are farther from what `claimed` says if it is the density of `sampled`.
fn p_value(sampled: &Rough, claimed: &Rough, seed: u64) -> f64 {
    let points = samples(sampled, seed);
    let mut all = Vec::new();
    bins(Cell::ALL, &|incoming| claimed.evaluate(incoming).1, &points, &mut all);
    let total = all.iter().map(|bin| bin.0).sum::<f64>();
    all.push((SAMPLES as f64 - total, (SAMPLES - points.len()) as f64));
    assert_eq!(all.iter().map(|bin| bin.1).sum::<f64>(), SAMPLES as f64, "every sample falls into one bin");
    let bins = pooled(&all);
    let chi = bins.iter().map(|(expected, found)| (found - expected) * (found - expected) / expected).sum();
    upper_tail(bins.len() - 1, chi)
}

/// Probability that χ² of so many degrees of freedom is above `chi`: the regularised incomplete gamma function, by
/// its series or its continued fraction (Press et al., *Numerical Recipes*, section 6.2).
fn upper_tail(degrees: usize, chi: f64) -> f64 {
    let (a, x) = (0.5 * degrees as f64, 0.5 * chi);
    let front = libm::exp(a * libm::log(x) - x - libm::lgamma(a));
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > 1e-16 * sum {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return 1.0 - front * sum;
    }
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (1e300, 1.0 / b);
    let mut fraction = d;
    for i in 1..10_000 {
        let numerator = f64::from(i) * (a - f64::from(i));
        b += 2.0;
        (c, d) = (b + numerator / c, 1.0 / (b + numerator * d));
        fraction *= c * d;
        if (c * d - 1.0).abs() < 1e-15 {
            break;
        }
    }
    front * fraction
}

/// Tables of χ² to six digits.
#[test]
fn the_tail_is_that_of_the_tables() {
    let tables = [(1, 3.841_459, 0.05), (2, 9.210_340, 0.01), (10, 18.307_04, 0.05), (10, 4.865_182, 0.9)];
    for (degrees, chi, p) in tables.into_iter().chain([(100, 135.806_7, 0.01), (100, 99.334_13, 0.5)]) {
        assert!((upper_tail(degrees, chi) - p).abs() < 1e-6, "{degrees}: {}", upper_tail(degrees, chi));
    }
}

/// Fails unless the density is accepted and a wrong one is not.
fn check(right: &Material, wrong: &Material, angle: f64, seed: u64) {
    let outgoing = direction(angle, 0.7);
    let (sampled, wrong) = (rough(right, outgoing), rough(wrong, outgoing));
    let (p, control) = (p_value(&sampled, &sampled, seed), p_value(&sampled, &wrong, seed));
    let name = std::format!("{:?}, α = {}, {angle}°", (right.diffuse[0], right.specular[0]), right.roughness);
    std::println!("{name}: p = {p:.4}, control {control:.1e}");
    assert!(p >= level(), "{name}: p = {p}");
    assert!(control < level(), "{name}: the wrong density passes, p = {control}");
}

#[test]
fn diffuse_directions_have_the_density_of_the_cosine() {
    check(&material(0.7, 0.0, 1.0), &material(0.7, 0.02, 0.5), 45.0, 1);
}

/// The control's width is a tenth off.
#[test]
fn lobes_have_their_density_at_every_width_and_angle() {
    for (i, alpha) in ROUGHNESS.into_iter().enumerate() {
        for (j, angle) in ANGLES.into_iter().enumerate() {
            let seed = 100 + (4 * i + j) as u64;
            check(&material(0.0, 0.04, alpha), &material(0.0, 0.04, 0.9 * alpha), angle, seed);
        }
    }
}

/// The control's width is right, and its diffuse part a quarter larger.
#[test]
fn mixtures_have_the_density_of_both_parts() {
    for (i, (alpha, angle)) in [(0.05, 45.0), (0.2, 80.0), (0.5, 0.0), (1.0, 60.0)].into_iter().enumerate() {
        check(&material(0.4, 0.3, alpha), &material(0.5, 0.3, alpha), angle, 200 + i as u64);
    }
}
