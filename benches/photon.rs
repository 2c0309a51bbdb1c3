//! Photon maps: shooting, building, asking, gathering. An element is a path, a photon, a query, or a sample.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use pmcip::frame::photons::{Order, Photons};
use pmcip::scene::{self, LoadedScene};
use pmcip_core::maths::sobol;
use pmcip_core::sampler::batch::{Batch8, Integrand, Rgb8};
use pmcip_core::tracer::camera::Camera;
use pmcip_core::tracer::photon::{self, Leaf, Neighbours, Photon, Query, Split, Tree};
use pmcip_core::tracer::scene::Scene;
use pmcip_core::tracer::shade::gather::Gather;
use pmcip_core::tracer::shade::path::{Packet, PathTracer};
use pmcip_core::tracer::shade::shoot::{Map, Shooter, Shots};
use std::path::Path;
use wide::{f32x8, u32x8};

const PATHS: usize = 20_000;
const DEPTH: u32 = 8;
/// Side of the picture that is gathered.
const SIDE: u32 = 128;

fn load() -> LoadedScene {
    scene::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/caustic.toml")).unwrap()
}

fn shoot(c: &mut Criterion) -> Vec<Photon> {
    let mut group = c.benchmark_group("shoot");
    group.throughput(Throughput::Elements(PATHS as u64));
    let loaded = load();
    let mut memory = vec![Packet::default(); Shooter::required(PATHS)];
    let mut shooter = Shooter::new(Scene::new(loaded.data()).unwrap(), DEPTH, &mut memory);
    let mut out = vec![Photon::default(); Shooter::most(Map::Global, PATHS, DEPTH)];
    for map in [Map::Caustic, Map::Global] {
        let shots = Shots { map, paths: PATHS as u32, seed: 0, frame: 0 };
        let mut used = 0;
        group.bench_function(format!("{map:?}/caustic").to_lowercase(), |b| {
            b.iter(|| used = shooter.shoot(&shots, 0, PATHS as u32, &mut out));
        });
        if map == Map::Global {
            out.truncate(used);
        }
    }
    group.finish();
    out
}

fn tree(c: &mut Criterion, mut photons: Vec<Photon>) {
    let mut group = c.benchmark_group("photon");
    let n = photon::leaves(photons.len());
    let (mut splits, mut leaves) = (vec![Split::default(); n - 1], vec![Leaf::default(); n]);
    group.throughput(Throughput::Elements(photons.len() as u64));
    let order = photons.clone();
    group.bench_function("build/caustic", |b| {
        b.iter(|| {
            photons.copy_from_slice(&order);
            photon::build(&mut photons, &mut splits, &mut leaves)
        });
    });
    let tree = Tree::new(&photons, &splits, &leaves).unwrap();
    let queries: Vec<Query> = order
        .iter()
        .step_by(16)
        .map(|p| Query { position: p.position, normal: p.normal, radius: 8.0 * tree.spacing() })
        .collect();
    group.throughput(Throughput::Elements(queries.len() as u64));
    group.bench_function("nearest/caustic", |b| {
        b.iter(|| queries.iter().filter_map(|q| tree.nearest(q)).map(|found| found.0).sum::<usize>());
    });
    let mut found = Neighbours::<64>::default();
    group.bench_function("64-nearest/caustic", |b| {
        b.iter(|| {
            queries.iter().for_each(|query| tree.k_nearest(query, &mut found));
            found.radius2()
        });
    });
    group.finish();
}

/// One sample for each pixel, eight neighbours in a batch.
fn batches() -> Vec<Batch8> {
    let lanes = u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]);
    let batch = |i: u32| {
        let pixel = u32x8::splat(8 * i) + lanes;
        let (u, v) = sobol::point(u32x8::ZERO, pixel, 0);
        let column = f32x8::from([0, 1, 2, 3, 4, 5, 6, 7].map(|l| (8 * i % SIDE + l) as f32));
        let row = f32x8::splat((8 * i / SIDE) as f32);
        Batch8 { lanes: 8, x: column + u, y: row + v, index: u32x8::ZERO, key: pixel }
    };
    (0..SIDE * SIDE / 8).map(batch).collect()
}

fn gather(c: &mut Criterion) {
    let mut group = c.benchmark_group("shade");
    group.throughput(Throughput::Elements(u64::from(SIDE * SIDE)));
    let (loaded, batches) = (load(), batches());
    let (scene, view) = (Scene::new(loaded.data()).unwrap(), loaded.view);
    let camera = Camera::new(view.from, view.at, view.up, view.fov, SIDE, SIDE).unwrap();
    let order = Order { photons: 100_000, max_depth: DEPTH, seed: 0, frame: 0 };
    let photons = Photons::shoot(scene, &order, None).unwrap();
    let mut memory = vec![Packet::default(); PathTracer::required(2048)];
    let mut tracer = Gather::new(scene, camera, DEPTH, photons.maps().unwrap(), &mut memory);
    let mut radiance = vec![Rgb8::default(); batches.len()];
    group.bench_function("gather/caustic", |b| b.iter(|| tracer.stream(&batches, &mut radiance)));
    group.finish();
}

fn photons(c: &mut Criterion) {
    let photons = shoot(c);
    tree(c, photons);
    gather(c);
}

criterion_group!(benches, photons);
criterion_main!(benches);
