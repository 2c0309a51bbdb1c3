//! Direct lighting agrees with the path tracer where the two compute the same, and with formulas.
//!
//! Pictures are 16×16. Energies of seeds 0 … 23 are compared within 4 standard errors of the difference (6e-5
//! two-sided; 13 comparisons in all) plus 1e-5 for rounding.

mod common;

use common::{Owned, inward_box, mean_and_error, render_with};
use pmcip_core::sampler::batch::Integrand;
use pmcip_core::sampler::{Schedule, Settings};
use pmcip_core::tracer::camera::Camera;
use pmcip_core::tracer::scene::{Material, Scattering, Scene, Triangle};
use pmcip_core::tracer::shade::direct::{DirectLighting, Samples};
use pmcip_core::tracer::shade::path::{Packet, PathTracer};

const SIDE: u32 = 16;
const SEEDS: u32 = 24;
const STREAM: usize = 2048;

/// Mean energy over seeds and its standard error.
fn energy(integrand: &mut impl Integrand, spp: u32) -> (f64, f64) {
    let energies: Vec<f64> = (0..SEEDS)
        .map(|seed| {
            let settings = Settings { seed, ..Settings::uniform(SIDE, SIDE) };
            let schedule = Schedule::new(u64::from(SIDE * SIDE), spp, spp, 1);
            let rgb = render_with(integrand, settings, schedule);
            rgb.iter().map(|v| f64::from(*v)).sum::<f64>() / rgb.len() as f64
        })
        .collect();
    mean_and_error(&energies)
}

fn by_paths(scene: Scene<'_>, camera: Camera, depth: u32) -> (f64, f64) {
    let mut memory = vec![Packet::default(); PathTracer::required(STREAM)];
    energy(&mut PathTracer::new(scene, camera, depth, &mut memory), 64)
}

fn directly(scene: Scene<'_>, camera: Camera, depth: u32, light: u32, bsdf: u32) -> (f64, f64) {
    let mut memory = vec![Packet::default(); PathTracer::required(STREAM)];
    let samples = Samples { light, bsdf };
    energy(&mut DirectLighting::new(scene, camera, depth, samples, &mut memory), 16)
}

fn assert_equal(a: (f64, f64), b: (f64, f64), what: &str) {
    let error = a.1.hypot(b.1);
    assert!(error < 0.01 * b.0, "{what}: {error} is too large to tell");
    assert!((a.0 - b.0).abs() <= 4.0 * error + 1e-5 * b.0, "{what}: {a:?} and {b:?}");
}

fn quad(a: [f32; 3], b: [f32; 3], c: [f32; 3], d: [f32; 3]) -> [Triangle; 2] {
    [Triangle { corners: [a, b, c] }, Triangle { corners: [a, c, d] }]
}

/// Lamp of half width `half` at height 1.9, shining downwards.
fn lamp(half: f32) -> [Triangle; 2] {
    let corner = |x: f32, z: f32| [half * x, 1.9, half * z];
    quad(corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0))
}

/// A polished floor of half width 2 that looks upwards.
fn floor() -> [Triangle; 2] {
    let corner = |x: f32, z: f32| [2.0 * x, 0.0, 2.0 * z];
    quad(corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0))
}

fn scene(parts: &[(&[Triangle], u32)], lamp_radiance: f32) -> Owned {
    let parts: Vec<(Triangle, u32)> =
        parts.iter().flat_map(|(triangles, material)| triangles.iter().map(|t| (*t, *material))).collect();
    let floor =
        Material { diffuse: [0.5, 0.4, 0.3], specular: [0.3; 3], roughness: 0.1, ..Material::default() };
    let lamp = Material { diffuse: [0.0; 3], emission: [lamp_radiance; 3], ..Material::default() };
    let mirror = Material { scattering: Scattering::Mirror, specular: [0.9; 3], ..Material::default() };
    let glass = Material { scattering: Scattering::Dielectric, specular: [1.0; 3], ..Material::default() };
    Owned::new(&parts, vec![floor, lamp, mirror, glass])
}

fn camera(from: [f32; 3], at: [f32; 3]) -> Camera {
    Camera::new(from, at, [0.0, 1.0, 0.0], 40.0, SIDE, SIDE).unwrap()
}

#[test]
fn agrees_with_paths_of_depth_two_for_any_numbers_of_samples() {
    let view = camera([0.0, 1.5, 4.0], [0.0, 0.6, 0.0]);
    for half in [0.4, 1.2] {
        let owned = scene(&[(&floor(), 0), (&lamp(half), 1)], 1.0);
        let paths = by_paths(owned.scene(), view, 2);
        for (light, bsdf) in [(1, 1), (8, 8), (8, 1), (1, 5)] {
            let direct = directly(owned.scene(), view, 2, light, bsdf);
            assert_equal(direct, paths, &format!("lamp {half}, {light} light and {bsdf} bsdf samples"));
        }
    }
}

/// The picture fills with a mirror that shows floor and lamp: everything has one segment more.
#[test]
fn follows_mirrors() {
    let corner = |x: f32, y: f32| [x, y, -1.9];
    let mirror = quad(corner(-9.0, -9.0), corner(9.0, -9.0), corner(9.0, 9.0), corner(-9.0, 9.0));
    let owned = scene(&[(&floor(), 0), (&lamp(0.6), 1), (&mirror, 2)], 1.0);
    let view = camera([0.0, 2.0, -1.2], [0.0, 1.6, -1.9]);
    let paths = by_paths(owned.scene(), view, 3);
    assert!(paths.0 > 0.01, "the mirror shows something: {paths:?}");
    assert_equal(directly(owned.scene(), view, 3, 8, 8), paths, "mirror");
    assert_eq!(directly(owned.scene(), view, 1, 8, 8), (0.0, 0.0), "one segment ends on the mirror");
}

/// Seen through a pane of glass with nothing before it: three segments to the floor, four to the lamp.
#[test]
fn follows_glass() {
    let (near, far) = (2.6, 2.5);
    let corner = |x: f32, y: f32, z: f32| [x, y, z];
    let front =
        quad(corner(-9., -9., near), corner(9., -9., near), corner(9., 9., near), corner(-9., 9., near));
    let back = quad(corner(-9., -9., far), corner(-9., 9., far), corner(9., 9., far), corner(9., -9., far));
    let owned = scene(&[(&floor(), 0), (&lamp(0.6), 1), (&front, 3), (&back, 3)], 1.0);
    let view = camera([0.0, 1.5, 4.0], [0.0, 0.6, 0.0]);
    let paths = by_paths(owned.scene(), view, 4);
    assert_equal(directly(owned.scene(), view, 4, 8, 8), paths, "glass");
    let shallow = directly(owned.scene(), view, 3, 8, 8);
    assert!(shallow.0 < 0.9 * paths.0, "a depth of 3 shows the lamp, not the floor: {shallow:?}");
}

/// Inside a box whose walls all emit 1 and reflect ρ, direct light is 1 + ρ: twelve lamps, picked by the tree.
#[test]
fn a_furnace_is_analytic() {
    let wall = Material { diffuse: [0.6; 3], emission: [1.0; 3], ..Material::default() };
    let parts: Vec<_> = inward_box([-1.0; 3], [1.0; 3]).into_iter().map(|t| (t, 0)).collect();
    let owned = Owned::new(&parts, vec![wall]);
    assert!(!owned.light_nodes.is_empty());
    let view = camera([0.1, 0.2, 0.8], [0.0; 3]);
    for (light, bsdf) in [(1, 1), (8, 8), (2, 8)] {
        let direct = directly(owned.scene(), view, 8, light, bsdf);
        assert_equal(direct, (1.6, 0.0), &format!("{light} light and {bsdf} bsdf samples"));
    }
}

#[test]
fn without_light_all_is_black() {
    let owned = scene(&[(&floor(), 0)], 1.0);
    let view = camera([0.0, 1.5, 4.0], [0.0, 0.6, 0.0]);
    assert_eq!(directly(owned.scene(), view, 8, 8, 8), (0.0, 0.0));
}

/// More samples for each pixel sample, less noise; the furnace's tolerance shows that it is not bias.
#[test]
fn eight_samples_are_better_than_one() {
    let owned = scene(&[(&floor(), 0), (&lamp(0.6), 1)], 1.0);
    let view = camera([0.0, 1.0, 2.0], [0.0, 0.2, 0.0]);
    let (one, eight) = (directly(owned.scene(), view, 2, 1, 1).1, directly(owned.scene(), view, 2, 8, 8).1);
    assert!(one > 1.5 * eight, "standard errors {one} and {eight}");
}
