//! Exact totals at any size, expectation over the offset, odd weights.

extern crate std;

use super::*;
use crate::maths::sobol::hash;
use proptest::prelude::*;
use std::vec;
use std::vec::Vec;

fn mixture(samples: u64, floor: f32, epsilon: f32) -> Mixture {
    Mixture { samples, floor, epsilon }
}

fn run(weights: &[f32], mix: Mixture, offset: u32) -> (Vec<f32>, Vec<u32>) {
    let (mut target, mut planned) = (weights.to_vec(), vec![0; weights.len()]);
    allocate(&mut target, &mut planned, mix, offset).unwrap();
    (target, planned)
}

/// Heavy-tailed weights over about twenty decades.
fn heavy(n: usize) -> Vec<f32> {
    (0..n as u32).map(|i| libm::exp2f((hash(i) >> 24) as f32 / 4.0 - 32.0)).collect()
}

#[test]
fn totals_are_exact_at_any_size() {
    for pixels in [1, 2, 3, 7, 255, 256, 257, 4096 * 3, 640 * 360] {
        for spp in [1u64, 2, 6, 64] {
            for floor in [0.0, 0.25, 1.0, 100.0] {
                let samples = spp * pixels as u64 + 1;
                let (target, planned) =
                    run(&heavy(pixels), mixture(samples, floor, 0.01), hash(pixels as u32));
                assert_eq!(planned.iter().map(|n| u64::from(*n)).sum::<u64>(), samples);
                for (t, n) in target.iter().zip(&planned) {
                    assert!((*n as f32 - t).abs() < 1.0 + t * 1e-6, "{n} samples where {t} are expected");
                }
            }
        }
    }
}

#[test]
fn counts_average_to_the_expectation() {
    let weights = heavy(37);
    let mix = mixture(100, 0.25, 0.01);
    let offsets = 1 << 12;
    let mut total = [0u64; 37];
    for i in 0..offsets {
        let (_, planned) = run(&weights, mix, i << (FRACTION_BITS - 12));
        total.iter_mut().zip(planned).for_each(|(t, n)| *t += u64::from(n));
    }
    // Equidistant offsets: the mean is exact up to one step of the offset.
    for (t, e) in total.iter().zip(run(&weights, mix, 0).0) {
        assert!((*t as f64 / f64::from(offsets) - f64::from(e)).abs() < 1.1 / f64::from(offsets));
    }
}

#[test]
fn expectations_follow_the_formula() {
    let weights = heavy(1000);
    let (samples, m, e) = (6000.0, 0.25, 0.01);
    let sum: f64 = weights.iter().map(|w| f64::from(*w)).sum();
    let (target, _) = run(&weights, mixture(6000, m as f32, e as f32), 1);
    for (w, t) in weights.iter().zip(target) {
        let alpha = e / 1000.0 + (1.0 - e) * f64::from(*w) / sum;
        let want = m + (samples - m * 1000.0) * alpha;
        assert!((f64::from(t) - want).abs() < 1e-6 * (1.0 + want), "{t}, not {want}");
    }
}

#[test]
fn useless_weights_make_it_uniform() {
    for weight in [0.0, f32::NAN, f32::INFINITY, -1.0] {
        let (target, planned) = run(&[weight; 12], mixture(36, 0.5, 0.01), 12345);
        assert!(target.iter().all(|t| (t - 3.0).abs() < 1e-6), "{target:?}");
        assert!(planned.iter().all(|n| (2..=4).contains(n)));
    }
}

#[test]
fn an_unknown_weight_counts_as_the_mean() {
    for unknown in [f32::NAN, f32::INFINITY, -1.0] {
        let (target, _) = run(&[1.0, unknown, 3.0, 2.0], mixture(80, 0.0, 0.0), 0);
        assert!((target[1] - 20.0).abs() < 1e-5, "{target:?}");
    }
}

#[test]
fn no_samples_is_an_allocation_too() {
    assert_eq!(run(&heavy(9), mixture(0, 0.25, 0.01), 99).1, [0; 9]);
}

#[test]
fn wrong_arguments_are_refused() {
    let go = |a: usize, b: usize, mix| allocate(&mut [1.0; 4][..a], &mut [0; 4][..b], mix, 0);
    let mix = mixture(8, 0.0, 0.0);
    assert_eq!(go(0, 0, mix), Err(Error::Pixels));
    assert_eq!(go(3, 4, mix), Err(Error::Pixels));
    assert_eq!(go(4, 4, Mixture { samples: 1 << 32, ..mix }), Err(Error::Samples));
    assert_eq!(go(4, 4, Mixture { floor: f32::NAN, ..mix }), Err(Error::Floor));
    assert_eq!(go(4, 4, Mixture { floor: -0.1, ..mix }), Err(Error::Floor));
    assert_eq!(go(4, 4, Mixture { epsilon: 1.5, ..mix }), Err(Error::Epsilon));
    assert_eq!(go(4, 4, mix), Ok(()));
}

proptest! {
    #[test]
    fn any_bits_give_a_valid_allocation(
        weights in prop::collection::vec(any::<u32>().prop_map(f32::from_bits), 1..400),
        samples in 0..=MAX_SAMPLES, floor in 0.0f32..1e9, epsilon in 0.0f32..=1.0, offset: u32,
    ) {
        let (target, planned) = run(&weights, mixture(samples, floor, epsilon), offset);
        prop_assert_eq!(planned.iter().map(|n| u64::from(*n)).sum::<u64>(), samples);
        for (t, n) in target.iter().zip(&planned) {
            prop_assert!(t.is_finite() && *t >= 0.0);
            prop_assert!((f64::from(*n) - f64::from(*t)).abs() < 1.0 + f64::from(*t) * 1e-6);
        }
    }
}
