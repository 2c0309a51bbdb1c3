//! Any weights and any budget: either refused, or exact totals, counts next to finite expectations.

#![no_main]

use arbitrary::Arbitrary;
use libfuzzer_sys::fuzz_target;
use pmcip_core::sampler::allocate::{Mixture, allocate};

#[derive(Arbitrary, Debug)]
struct Input {
    weights: Vec<u32>,
    samples: u64,
    small: bool,
    floor: f32,
    epsilon: f32,
    offset: u32,
}

fuzz_target!(|input: Input| {
    let mut target: Vec<f32> = input.weights.iter().map(|bits| f32::from_bits(*bits)).collect();
    let mut planned = vec![0; target.len()];
    let samples = if input.small { input.samples % 4096 } else { input.samples };
    let mix = Mixture { samples, floor: input.floor, epsilon: input.epsilon };
    if allocate(&mut target, &mut planned, mix, input.offset).is_err() {
        return;
    }
    assert_eq!(planned.iter().map(|n| u64::from(*n)).sum::<u64>(), samples);
    for (expected, count) in target.iter().zip(&planned) {
        assert!(expected.is_finite() && *expected >= 0.0);
        let (expected, count) = (f64::from(*expected), f64::from(*count));
        assert!((count - expected).abs() < 1.0 + expected * 1e-6, "{count} where {expected} are expected");
    }
});
