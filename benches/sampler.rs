//! The sampler's own cost, without an integrand: a pixel to begin and to resolve, a sample to hand out and accept.
//!
//! Quote ratios to `plain-pass`: on a shared machine nanoseconds vary by half. `benches/measure/overhead.rs` alternates
//! all steps with it, at sizes from 256×256 to 4096×4096.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use pmcip_core::maths::vec3::Vec3x8;
use pmcip_core::maths::{functions, sobol, tvi};
use pmcip_core::sampler::allocate::{Mixture, allocate};
use pmcip_core::sampler::batch::{Batch8, Integrand, Rgb8};
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::kernel::{Criterion as Evened, Kernel, Window};
use pmcip_core::sampler::{Memory, Sampler, Settings, Workspace};
use std::hint::black_box;
use std::time::{Duration, Instant};
use wide::{f32x8, u32x8};

const WIDTH: u32 = 1920;
const HEIGHT: u32 = 1080;
const PIXELS: u64 = WIDTH as u64 * HEIGHT as u64;

/// Noise everywhere, so that no shortcut is taken.
struct Noise;

impl Integrand for Noise {
    fn radiance(&mut self, batch: &Batch8) -> Rgb8 {
        let value = batch.x - batch.x.floor();
        Rgb8 { r: value, g: value, b: value }
    }
}

/// Runs one iteration and returns how long its beginning took and how long its jobs.
fn iterate(sampler: &mut Sampler<'_>) -> (Duration, Duration) {
    let (mut batches, mut radiance) = ([Batch8::default(); 128], [Rgb8::default(); 128]);
    let mut work = Workspace::new(&mut batches, &mut radiance).expect("not empty");
    let start = Instant::now();
    sampler.begin(PIXELS).expect("no iteration is running");
    let begun = Instant::now();
    for mut job in sampler.jobs() {
        job.render(&mut Noise, &mut work);
    }
    let rendered = Instant::now();
    sampler.end().expect("all jobs were rendered");
    (begun - start, rendered - begun)
}

fn frame(c: &mut Criterion) {
    let mut group = c.benchmark_group("sampler");
    group.throughput(Throughput::Elements(PIXELS)).sample_size(10);
    let required = Sampler::required(WIDTH, HEIGHT);
    let (mut floats, mut words) = (vec![0.0; required.floats], vec![0; required.words]);
    for (name, estimator) in [("pooled", Estimator::Pooled), ("balanced", Estimator::Balanced)] {
        let settings = Settings { estimator, ..Settings::new(WIDTH, HEIGHT) };
        let memory = Memory { floats: &mut floats, words: &mut words };
        let mut sampler = Sampler::new(settings, memory).expect("valid settings");
        iterate(&mut sampler);
        group.bench_function(format!("begin-{name}/1920x1080"), |b| {
            b.iter_custom(|n| (0..n).map(|_| iterate(&mut sampler).0).sum());
        });
        group.bench_function(format!("samples-{name}/1920x1080"), |b| {
            b.iter_custom(|n| (0..n).map(|_| iterate(&mut sampler).1).sum());
        });
        let mut scratch = vec![[0.0; 16]; Sampler::resolve_scratch(WIDTH, HEIGHT)];
        let mut rgb = vec![0.0; 3 * PIXELS as usize];
        group.bench_function(format!("resolve-{name}/1920x1080"), |b| {
            b.iter(|| sampler.resolve(estimator, &mut scratch, &mut rgb));
        });
    }
}

/// What [`Sampler::begin`] and [`Sampler::resolve`] read and write, and nothing computed: the bound of memory.
fn plain(c: &mut Criterion) {
    let mut group = c.benchmark_group("sampler");
    group.throughput(Throughput::Elements(PIXELS)).sample_size(10);
    let plane = || vec![1.0f32; PIXELS as usize];
    let (read, mut written) = ([(); 8].map(|()| plane()), [(); 2].map(|()| plane()));
    let mut rgb = vec![[0.0; 3]; PIXELS as usize];
    group.bench_function("plain-pass/1920x1080", |b| {
        b.iter(|| {
            begin_bytes(&read, &mut written);
            resolve_bytes(&read, black_box(&mut rgb));
        });
    });
}

/// Count, mean and squared deviations in; target and planned count out.
fn begin_bytes([count, r, g, b, m2, ..]: &[Vec<f32>; 8], [target, planned]: &mut [Vec<f32>; 2]) {
    for i in 0..count.len() {
        target[i] = count[i] + m2[i];
        planned[i] = r[i] + g[i] + b[i];
    }
}

/// Mean and excess in, the picture out.
fn resolve_bytes([_, r, g, b, _, x, y, z]: &[Vec<f32>; 8], rgb: &mut [[f32; 3]]) {
    for (i, rgb) in rgb.iter_mut().enumerate() {
        *rgb = [r[i] + x[i], g[i] + y[i], b[i] + z[i]];
    }
}

fn counts(c: &mut Criterion) {
    let mut group = c.benchmark_group("allocate");
    group.throughput(Throughput::Elements(PIXELS)).sample_size(10);
    let (mut target, mut planned) = (vec![1.0; PIXELS as usize], vec![0; PIXELS as usize]);
    let mix = Mixture { samples: 2 * PIXELS, floor: 0.25, epsilon: 0.01 };
    group.bench_function("adaptive/1920x1080", |b| {
        b.iter(|| allocate(&mut target, &mut planned, black_box(mix), 1));
    });
    let mix = Mixture { epsilon: 1.0, ..mix };
    group.bench_function("uniform/1920x1080", |b| {
        b.iter(|| allocate(&mut target, &mut planned, black_box(mix), 1));
    });
}

fn packets(c: &mut Criterion) {
    c.benchmark_group("sobol").throughput(Throughput::Elements(8)).bench_function("point/8", |b| {
        let key = u32x8::from([1, 2, 3, 4, 5, 6, 7, 8]);
        b.iter(|| sobol::point(black_box(key), black_box(key), 1));
    });
    c.benchmark_group("tvi").throughput(Throughput::Elements(8)).bench_function("threshold/8", |b| {
        let luminance = f32x8::from([1e-6, 1e-3, 0.1, 1.0, 3.0, 10.0, 50.0, 1e4]);
        b.iter(|| tvi::tvi(black_box(luminance)));
    });
}

fn weights(c: &mut Criterion) {
    let kernel = Kernel { criterion: Evened::Mean, gamma: 0.8, window: Window::Square3, cd_per_unit: 100.0 };
    c.benchmark_group("kernel").throughput(Throughput::Elements(8)).bench_function("weight/8", |b| {
        b.iter(|| kernel.weight(black_box(f32x8::splat(0.3)), black_box(f32x8::splat(0.7))));
    });
}

fn functions(c: &mut Criterion) {
    let x = f32x8::new([0.01, 0.1, 0.2, 0.3, 0.4, 0.5, 0.7, 0.9]);
    let mut group = c.benchmark_group("math");
    group.throughput(Throughput::Elements(8));
    group.bench_function("log2/8", |b| b.iter(|| functions::log2(black_box(x))));
    group.bench_function("exp2/8", |b| b.iter(|| functions::exp2(black_box(x))));
    group.bench_function("sin-cos-turn/8", |b| b.iter(|| functions::sin_cos_turn(black_box(x))));
    group.finish();
    let v = Vec3x8::new(x, x, x);
    c.benchmark_group("vec3").throughput(Throughput::Elements(8)).bench_function("normalized/8", |b| {
        b.iter(|| black_box(v).normalized());
    });
}

criterion_group!(benches, frame, plain, counts, packets, weights, functions);
criterion_main!(benches);
