//! Rays a second: camera, hierarchy walk and path tracing. An element is one ray, or one sample for `shade`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use pmcip::scene::{self, LoadedScene};
use pmcip_core::maths::sobol;
use pmcip_core::maths::vec3::Vec3x8;
use pmcip_core::sampler::batch::{Batch8, Integrand, Rgb8};
use pmcip_core::tracer::camera::Camera;
use pmcip_core::tracer::scene::Scene;
use pmcip_core::tracer::shade::path::{Packet, PathTracer};
use pmcip_core::tracer::trace::{MISS, Rays8, Tracer};
use std::path::Path;
use wide::{f32x8, u32x8};

/// Side of the picture whose rays are traced.
const SIDE: u32 = 128;
const PACKETS: usize = (SIDE * SIDE / 8) as usize;
const SCENES: [&str; 2] = ["cornell", "caustic"];

fn load(name: &str) -> LoadedScene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{name}.toml"));
    scene::load(&path).unwrap()
}

fn camera(loaded: &LoadedScene) -> Camera {
    let view = loaded.view;
    Camera::new(view.from, view.at, view.up, view.fov, SIDE, SIDE).unwrap()
}

/// One sample for each pixel, eight neighbours in a batch.
fn batches() -> Vec<Batch8> {
    let lanes = u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]);
    let batch = |i: u32| {
        let pixel = u32x8::splat(8 * i) + lanes;
        let (u, v) = sobol::point(u32x8::ZERO, pixel, 0);
        let (x, y) = (8 * i % SIDE, 8 * i / SIDE);
        let column = f32x8::from([0, 1, 2, 3, 4, 5, 6, 7].map(|l| (x + l) as f32));
        Batch8 { lanes: 8, x: column + u, y: f32x8::splat(y as f32) + v, index: u32x8::ZERO, key: pixel }
    };
    (0..PACKETS as u32).map(batch).collect()
}

fn primary(camera: &Camera) -> Vec<Rays8> {
    let rays = |b: &Batch8| Rays8 {
        origin: Vec3x8::splat(camera.origin()),
        direction: camera.directions(b.x, b.y),
        t_max: f32x8::splat(f32::INFINITY),
        ..Rays8::default()
    };
    batches().iter().map(rays).collect()
}

/// Rays from where the primary ones hit, in uniformly distributed directions, in the order of the pixels.
fn bounced(tracer: &mut Tracer<'_>, primary: &[Rays8]) -> Vec<Rays8> {
    let bounce = |(i, rays): (usize, &Rays8)| {
        let hits = tracer.closest(rays);
        let key = u32x8::splat(8 * i as u32) + u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]);
        let (u, v) = sobol::point(u32x8::ZERO, key, 1);
        let z = u * f32x8::splat(2.0) - f32x8::ONE;
        let r = (f32x8::ONE - z * z).sqrt();
        let (sin, cos) = pmcip_core::maths::functions::sin_cos_turn(v);
        let hit = hits.triangle.simd_ne(u32x8::splat(MISS));
        let endless: f32x8 = f32x8::splat(f32::INFINITY);
        Rays8 {
            origin: rays.origin + rays.direction * (hits.t * f32x8::splat(0.999)),
            direction: Vec3x8::new(r * cos, r * sin, z),
            t_max: hit.select(endless, f32x8::splat(-1.0)),
            ..Rays8::default()
        }
    };
    primary.iter().enumerate().map(bounce).collect()
}

fn trace(c: &mut Criterion) {
    let mut group = c.benchmark_group("trace");
    group.throughput(Throughput::Elements(8 * PACKETS as u64));
    for name in SCENES {
        let loaded = load(name);
        let mut tracer = Tracer::new(Scene::new(loaded.data()).unwrap());
        let primary = primary(&camera(&loaded));
        let bounced = bounced(&mut tracer, &primary);
        for (kind, rays) in [("primary", &primary), ("bounce", &bounced)] {
            group.bench_function(format!("closest-{kind}/{name}"), |b| {
                b.iter(|| rays.iter().map(|r| tracer.closest(r).t.to_array()[0]).sum::<f32>());
            });
            group.bench_function(format!("occluded-{kind}/{name}"), |b| {
                b.iter(|| rays.iter().map(|r| tracer.occluded(r)).sum::<u32>());
            });
        }
    }
    group.finish();
}

fn shade(c: &mut Criterion) {
    let mut group = c.benchmark_group("shade");
    group.throughput(Throughput::Elements(8 * PACKETS as u64));
    let batches = batches();
    let mut radiance = vec![Rgb8::default(); PACKETS];
    for name in SCENES {
        let loaded = load(name);
        let scene = Scene::new(loaded.data()).unwrap();
        for depth in [2, 8] {
            let mut memory = vec![Packet::default(); PathTracer::required(2048)];
            let mut tracer = PathTracer::new(scene, camera(&loaded), depth, &mut memory);
            group.bench_function(format!("path-depth-{depth}/{name}"), |b| {
                b.iter(|| tracer.stream(&batches, &mut radiance));
            });
        }
    }
    group.finish();
}

fn build(c: &mut Criterion) {
    let mut group = c.benchmark_group("scene");
    let loaded = load("caustic");
    group.throughput(Throughput::Elements(loaded.triangles.len() as u64));
    group.bench_function("check/caustic", |b| b.iter(|| Scene::new(loaded.data()).is_ok()));
    group.finish();

    let mut group = c.benchmark_group("camera");
    group.throughput(Throughput::Elements(8 * PACKETS as u64));
    let (camera, batches) = (camera(&loaded), batches());
    let last = |b: &Batch8| camera.directions(b.x, b.y).z.to_array()[7];
    group.bench_function("directions/128x128", |b| b.iter(|| batches.iter().map(last).sum::<f32>()));
    group.finish();
}

criterion_group!(benches, trace, shade, build);
criterion_main!(benches);
