//! Any radiances of a pixel, in any iterations, in two films that are merged: mean and variance as two passes over all of
//! them in double precision find them, within what rounding explains.

use super::bytes::{Bytes, Cycle};
use pmcip::film::Film;
use pmcip_core::sampler::batch::{Batch8, Integrand, MAX_RADIANCE, Rgb8};
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::{Settings, Tally};

/// Weights of red, green and blue in luminance.
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];
/// Half a step of single precision.
const ROUNDING: f64 = 6e-8;
/// Samples that are summed before the sums are merged.
const CHUNK: f64 = 256.0;

/// Radiances, and what was kept of them.
struct Recorder {
    values: Cycle,
    offset: f32,
    taken: Vec<[f32; 3]>,
    rejected: u64,
}

impl Integrand for Recorder {
    fn radiance(&mut self, batch: &Batch8) -> Rgb8 {
        let rgb: [[f32; 3]; 8] = [(); 8].map(|()| self.values.rgb().map(|v| v + self.offset));
        for rgb in &rgb[..batch.lanes as usize] {
            if rgb.iter().all(|v| v.abs() <= MAX_RADIANCE) {
                self.taken.push(*rgb);
            } else {
                self.rejected += 1;
            }
        }
        let [r, g, b] = [0, 1, 2].map(|c| rgb.map(|rgb| rgb[c]).into());
        Rgb8 { r, g, b }
    }
}

/// A head of ten bytes, then the radiances.
pub fn check(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let tame = bytes.bit();
    let offset = if tame { (bytes.level() / 16.0).exp2() } else { 0.0 };
    let iterations = [0; 6].map(|_| bytes.byte());
    let mut recorder = Recorder { values: bytes.cycle(1 << 12, tame), offset, taken: vec![], rejected: 0 };
    let mut films = [0, 1].map(|seed| {
        let settings = Settings { seed, estimator: Estimator::Pooled, ..Settings::new(1, 1) };
        Film::new(settings).expect("there is memory")
    });
    let mut merges = 1.0;
    for (i, samples) in iterations.iter().enumerate().filter(|(_, samples)| **samples > 0) {
        let film = &mut films[i % 2];
        // Longer ones than a chunk, too.
        let samples = u64::from(*samples) * if samples % 8 == 7 { 8 } else { 1 };
        film.begin(samples).expect("it is at rest");
        film.render(&mut recorder).expect("it runs");
        film.end().expect("all is taken");
        merges += 1.0 + samples as f64 / CHUNK;
    }
    let [mut one, mut other] = films;
    let saved = [&mut one, &mut other].map(|film| film.save().expect("there is memory"));
    one.merge(&saved[1]).expect("they differ in the seed");
    other.merge(&saved[0]).expect("they differ in the seed");
    for film in [&mut one, &mut other] {
        let total = Tally { samples: recorder.taken.len() as u64, rejected: recorder.rejected };
        compare(film, &recorder.taken, total, merges);
    }
}

fn compare(film: &mut Film, taken: &[[f32; 3]], total: Tally, merges: f64) {
    let [mean] = film.resolve(Estimator::Pooled).expect("it is at rest")[..] else { panic!("one pixel") };
    let count = film.count().expect("it is at rest")[0];
    assert_eq!(u64::from(count), total.samples, "of {total:?}");
    let n = taken.len() as f64;
    if taken.is_empty() {
        return assert_eq!(mean, [0.0; 3]);
    }
    let mut light_error = 0.0;
    let mut light_range = 0.0;
    for c in 0..3 {
        let values = || taken.iter().map(|rgb| f64::from(rgb[c]));
        let (least, most) =
            (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
        // A chunk's sum is of differences, each merge rounds the mean itself.
        let (range, largest) = (most - least, most.max(-least));
        let error = ROUNDING * (CHUNK * range + 4.0 * (merges + 1.0) * largest) + 1e-37;
        let wanted = values().sum::<f64>() / n;
        let found = f64::from(mean[c]);
        assert!((found - wanted).abs() <= error, "mean {found}, not {wanted}, of {n} to {error}");
        light_error += LUMINANCE[c] * error;
        light_range += LUMINANCE[c] * range;
    }
    let light = || taken.iter().map(|rgb| (0..3).map(|c| LUMINANCE[c] * f64::from(rgb[c])).sum::<f64>());
    let mean = light().sum::<f64>() / n;
    let m2: f64 = light().map(|light| (light - mean) * (light - mean)).sum();
    let between = merges * n * light_error * (light_range + light_error);
    let error = ROUNDING * (CHUNK + 8.0 * merges) * n * light_range * light_range + between + n * 1e-36;
    let scale = (n * (n - 1.0)).max(1.0);
    let found = f64::from(film.variance().expect("it is at rest")[0]);
    let wanted = if taken.len() > 1 { m2 / scale } else { 0.0 };
    assert!(
        (found - wanted).abs() <= error / scale + 1e-36,
        "variance {found}, not {wanted}, of {n} to {}",
        error / scale
    );
}

/// Alike, with a spike, with a large offset, of any bits.
pub fn seeds() -> Vec<Vec<u8>> {
    let head = |tame: u8, offset: i16, iterations: [u8; 6]| {
        let offset = offset.to_le_bytes();
        if tame == 1 {
            [&[tame], &offset[..], &iterations].concat()
        } else {
            [&[tame], &iterations[..]].concat()
        }
    };
    let ramp: Vec<u8> = (0..60i16).flat_map(|i| (i * 97).to_le_bytes()).collect();
    let any: Vec<u8> = [1.0f32, 1e-30, 1e15, -3.0, 0.0, f32::MIN_POSITIVE, 1e-42]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    vec![
        [head(1, 0, [1, 1, 2, 3, 4, 5]), ramp.clone()].concat(),
        [head(1, 20_000, [255, 127, 63, 0, 0, 1]), ramp.clone()].concat(),
        [head(1, -9_000, [0, 15, 0, 0, 0, 0]), ramp].concat(),
        [head(0, 0, [1, 0, 0, 0, 0, 0]), any.clone()].concat(),
        [head(0, 0, [31, 7, 40, 1, 1, 1]), any].concat(),
    ]
}
