//! The core allocates nothing while it builds lights, checks a scene, adapts, traces and resolves a frame,
//! nor while it looks for features and homographies or predicts a kernel.

mod common;
#[path = "no_std/frame.rs"]
mod frame;

use pmcip_core::predict::features::{self, Feature, Picture};
use pmcip_core::predict::homography::{self, Block, Pair};
use pmcip_core::predict::tracks::{self, Tracks};
use pmcip_core::predict::{Belief, Filter, carry};
use pmcip_core::sampler::batch::{Batch8, Integrand};
use pmcip_core::tracer::camera::Camera;
use pmcip_core::tracer::photon::{self, Irradiance, Leaf, Photon, Split, Tree};
use pmcip_core::tracer::scene::Material;
use pmcip_core::tracer::shade::gather::{Gather, Maps};
use pmcip_core::tracer::shade::path::Packet;
use pmcip_core::tracer::shade::shoot::{Map, Shooter, Shots};
use wide::f32x8;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::hint::black_box;

thread_local! {
    /// Allocations of this thread; the test harness has threads of its own.
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

/// The system's allocator, counted.
struct Counting;

// SAFETY: every call is passed on to the system's allocator unchanged; the counter is a plain thread-local cell
// with a constant start and no destructor, so that touching it neither allocates nor fails.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller keeps the contract of `alloc`, which is the same.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: `memory` comes from `alloc` above, hence from the system's allocator.
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Allocations that `work` makes.
fn allocations(work: impl FnOnce()) -> u64 {
    let before = ALLOCATIONS.get();
    work();
    ALLOCATIONS.get() - before
}

#[test]
fn a_frame_allocates_nothing() {
    let mut result = None;
    assert_eq!(allocations(|| result = frame::render()), 0);
    let (tally, brightest) = result.expect("the core accepts scene and memory");
    assert_eq!((tally.samples, tally.rejected), (frame::SAMPLES, 0));
    assert!(brightest > 0.1, "the wall is lit: {brightest}");
}

/// Shooting, building trees, estimating and gathering, on memory that is there before.
#[test]
fn photon_mapping_allocates_nothing() {
    let owned = common::Owned::new(
        &common::inward_box([-1.0; 3], [1.0; 3]).into_iter().map(|t| (t, 0)).collect::<Vec<_>>(),
        vec![Material { emission: [1.0; 3], ..Material::default() }],
    );
    let (scene, shots) = (owned.scene(), Shots { map: Map::Global, paths: 64, seed: 0, frame: 0 });
    let mut packets = vec![Packet::default(); Shooter::required(64)];
    let mut photons = vec![Photon::default(); 64];
    let mut points = vec![Irradiance::default(); 64];
    let [mut splits, mut more_splits] = [[Split::default(); 7]; 2];
    let [mut leaves, mut more_leaves] = [[Leaf::default(); 8]; 2];
    let mut light = Default::default();
    let count = allocations(|| {
        let shot = Shooter::new(scene, 3, &mut packets).shoot(&shots, 0, 64, &mut photons);
        assert_eq!(shot, 64);
        photon::build(&mut photons, &mut splits, &mut leaves).unwrap();
        let global = Tree::new(&photons, &splits, &leaves).unwrap();
        for (point, photon) in points.iter_mut().zip(&photons) {
            (point.position, point.normal) = (photon.position, photon.normal);
        }
        photon::estimate(&global, &mut points);
        photon::build(&mut points, &mut more_splits, &mut more_leaves).unwrap();
        let irradiance = Tree::new(&points, &more_splits, &more_leaves).unwrap();
        let camera = Camera::new([0.0; 3], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], 60.0, 8, 8).unwrap();
        let maps = Maps { irradiance, caustic: global };
        let batch = Batch8 { lanes: 8, x: f32x8::splat(4.0), y: f32x8::splat(4.0), ..Batch8::default() };
        light = Gather::new(scene, camera, 3, maps, &mut packets).radiance(&batch);
    });
    assert_eq!(count, 0);
    assert!(light.r.to_array()[0] > 1.0);
}

#[test]
fn features_and_homographies_allocate_nothing() {
    const SIDE: usize = 64;
    let mut scratch = vec![0.0; features::required(SIDE, SIDE)];
    let mut found = vec![Feature::default(); 100];
    let mut blocks = [Block::default(); homography::required(100)];
    let values: Vec<f32> = (0..SIDE * SIDE).map(|i| ((i * i) % 251) as f32 / 251.0).collect();
    let picture = Picture::new(&values, SIDE, SIDE).expect("large enough");
    let mut filtered = values.clone();
    let mut pairs = [Pair::default(); 100];
    let work = || {
        features::median3(picture, &mut filtered).expect("as many values");
        let settings = features::Settings::default();
        let count = features::detect(picture, &settings, &mut scratch, &mut found).expect("enough scratch");
        let found = &found[..count];
        for (pair, found) in
            pairs.iter_mut().zip(features::matches(found, found, 0.8).map(|m| m.pair(found, found)))
        {
            *pair = found;
        }
        _ = black_box(homography::estimate(&pairs, &homography::Settings::default(), &mut blocks));
    };
    assert_eq!(allocations(work), 0);
}

#[test]
fn a_prediction_allocates_nothing() {
    const SIDE: usize = 64;
    const PIXELS: usize = SIDE * SIDE;
    let before = vec![Belief { variance: 1.0, light: 1.0, freedom: 9.0 }; PIXELS];
    let mut beliefs = before.clone();
    let density: Vec<f32> = (0..PIXELS).map(|i| if i % 64 < 9 { 1.0 } else { 0.1 }).collect();
    let (mut labels, mut sizes) = (vec![0; PIXELS], vec![0; PIXELS]);
    let mut positions = vec![[0.0; 2]; PIXELS];
    let at = |i: usize| [(i * 7 % 61) as f64, (i * 13 % 59) as f64];
    let pairs: [Pair; 40] = std::array::from_fn(|i| Pair { from: at(i), to: at(i) });
    let (mut picked, mut blocks) = (pairs, [Block::default(); homography::required(40)]);
    let work = || {
        tracks::regions(&density, SIDE, 0.8, 9, &mut labels, &mut sizes).expect("enough scratch");
        let settings = homography::Settings::default();
        let tracks = Tracks::find(&pairs, &labels, SIDE, &settings, &mut picked, &mut blocks);
        let tracks = tracks.expect("enough scratch");
        tracks.positions(&labels, SIDE, SIDE, &mut positions).expect("planes of one size");
        carry(&before, SIDE, SIDE, &positions, Belief::NONE, &mut beliefs).expect("planes of one size");
        Filter::new(100.0).update(SIDE, &mut beliefs, &before).expect("planes of one size");
    };
    assert_eq!(allocations(work), 0);
    assert!(beliefs.iter().all(|belief| belief.freedom > 9.0), "everything was carried");
}

#[test]
fn the_counter_counts() {
    assert_eq!(allocations(|| drop(black_box(Box::new(1)))), 1);
    assert!(allocations(|| drop(black_box(vec![0; 100]))) >= 1);
}
