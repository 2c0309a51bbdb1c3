//! Any weights and any budget: either refused, or exact totals, counts next to finite expectations.

use super::bytes::Bytes;
use pmcip_core::sampler::allocate::{Mixture, allocate};

/// A head of numbers, then weights.
pub fn check(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let kind = bytes.byte();
    let tame = kind & 1 == 1;
    let samples = if kind & 2 == 0 { bytes.long() % 4096 } else { bytes.long() };
    let (floor, epsilon, offset) = (bytes.float(tame), bytes.float(tame), bytes.word());
    let mut target = Vec::new();
    while !bytes.is_empty() {
        target.push(bytes.float(tame));
    }
    let mut planned = vec![0; target.len()];
    let mix = Mixture { samples, floor, epsilon };
    if allocate(&mut target, &mut planned, mix, offset).is_err() {
        return;
    }
    assert_eq!(planned.iter().map(|n| u64::from(*n)).sum::<u64>(), samples);
    for (expected, count) in target.iter().zip(&planned) {
        assert!(expected.is_finite() && *expected >= 0.0);
        let (expected, count) = (f64::from(*expected), f64::from(*count));
        assert!((count - expected).abs() < 1.0 + expected * 1e-6, "{count} where {expected} are expected");
    }
}

/// Even weights, a spike, weights of any bits, more samples than fit.
pub fn seeds() -> Vec<Vec<u8>> {
    let head =
        |kind: u8, samples: u64| [&[kind][..], &samples.to_le_bytes(), &[0, 0, 9, 0, 7, 0, 0, 0]].concat();
    let wild = |kind: u8, samples: u64| {
        let parts = [0.5f32.to_le_bytes(), 0.01f32.to_le_bytes()].concat();
        [&[kind][..], &samples.to_le_bytes(), &parts, &[7, 0, 0, 0]].concat()
    };
    let any = [f32::NAN, f32::INFINITY, 1e-40, 3e38, -1.0, 1.0, 0.0, 1e-9].map(f32::to_le_bytes).concat();
    vec![
        [head(1, 500), [0, 1].repeat(40)].concat(),
        [head(1, 77), [0, 0].repeat(60), vec![0, 127], [0, 0].repeat(9)].concat(),
        [wild(0, 1000), any.repeat(5)].concat(),
        [wild(2, u64::from(u32::MAX)), any].concat(),
    ]
}
