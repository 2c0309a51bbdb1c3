//! Bits that must be the same for every instruction set that `wide` may be compiled for.
//!
//! Pinned as found on x86-64-v3; `.ci/run` runs this for the baseline of x86-64, too. Rays are not among them: their walk fuses
//! multiplication and addition where the processor can.

extern crate std;

use crate::maths::functions;
use crate::maths::sobol;
use crate::sampler::batch::{Batch8, Integrand, Rgb8};
use crate::sampler::{Memory, Sampler, Schedule, Settings, Workspace};
use std::vec;
use wide::{f32x8, u32x8};

/// Of all bits, in order (FNV-1a over words).
struct Digest(u64);

impl Digest {
    fn add(&mut self, bits: u32) {
        self.0 = (self.0 ^ u64::from(bits)).wrapping_mul(0x0100_0000_01b3);
    }

    fn add8(&mut self, values: f32x8) {
        values.to_array().iter().for_each(|value| self.add(value.to_bits()));
    }
}

fn digest(fill: impl FnOnce(&mut Digest)) -> u64 {
    let mut digest = Digest(0xcbf2_9ce4_8422_2325);
    fill(&mut digest);
    digest.0
}

#[test]
fn functions() {
    let found = digest(|digest| {
        for i in 0..4096 {
            let lanes = f32x8::from(core::array::from_fn(|lane| (8 * i + lane) as f32));
            let (x, turn) = (lanes * f32x8::splat(0.003), lanes * f32x8::splat(1.0 / 32_768.0));
            [functions::log2(x), functions::log2_rough(x), functions::exp2(x), functions::exp2_rough(x)]
                .into_iter()
                .for_each(|v| digest.add8(v));
            digest.add8(functions::powf(x, f32x8::splat(2.7)));
            digest.add8(crate::maths::tvi::log2_tvi(x - f32x8::splat(50.0)));
            let (sin, cos) = functions::sin_cos_turn(turn);
            [sin, cos].into_iter().for_each(|v| digest.add8(v));
        }
    });
    assert_eq!(found, 0x9518_4879_301d_4bc2, "{found:#018x}");
}

#[test]
fn points() {
    let found = digest(|digest| {
        for i in 0..4096 {
            let (x, y) = sobol::point(
                u32x8::splat(i) + u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]),
                u32x8::splat(i % 7),
                i % 5,
            );
            [x, y].into_iter().for_each(|v| digest.add8(v));
        }
    });
    assert_eq!(found, 0xa4ab_1943_8827_7198, "{found:#018x}");
}

/// Noise whose strength differs over the picture.
struct Noise;

impl Integrand for Noise {
    fn radiance(&mut self, batch: &Batch8) -> Rgb8 {
        let (u, v) = batch.point(1);
        Rgb8 { r: u * batch.x, g: (u * v).sqrt() * batch.y, b: u }
    }
}

/// The whole sampler: kernel, allocation, film and estimator.
#[test]
fn pictures() {
    let found = digest(|digest| {
        let (width, height) = (67, 45);
        let required = Sampler::required(width, height);
        let (mut floats, mut words) = (vec![0.0; required.floats], vec![0; required.words]);
        let memory = Memory { floats: &mut floats, words: &mut words };
        let mut sampler = Sampler::new(Settings::new(width, height), memory).unwrap();
        let (mut batches, mut radiance) = ([Batch8::default(); 9], [Rgb8::default(); 9]);
        let mut work = Workspace::new(&mut batches, &mut radiance).unwrap();
        for samples in Schedule::new(67 * 45, 12, 2, 6) {
            sampler.begin(samples).unwrap();
            sampler.jobs().for_each(|mut job| {
                job.render(&mut Noise, &mut work);
            });
            sampler.end().unwrap();
        }
        let mut scratch = vec![[0.0; 16]; Sampler::resolve_scratch(width, height)];
        let (mut rgb, mut alpha) = (vec![0.0; 3 * 67 * 45], vec![0.0; 67 * 45]);
        sampler.resolve(sampler.settings().estimator, &mut scratch, &mut rgb).unwrap();
        sampler.alpha(&mut alpha).unwrap();
        rgb.iter().chain(&alpha).for_each(|value: &f32| digest.add(value.to_bits()));
    });
    assert_eq!(found, 0x7e7d_6eed_0aec_256c, "{found:#018x}");
}
