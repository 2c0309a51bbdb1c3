//! Scenes whose radiance is known: closed boxes whose walls all emit 1.
//!
//! Inside, light that was scattered k times contributes ρᵏ, so paths of up to D segments see Σ ρᵏ, k < D, in
//! every pixel. The tests take the mean over many pixels; tolerances are 4 standard errors (6e-5 two-sided, for
//! 45 comparisons in all: 0.3 % that any correct one fails), with the standard error from independent renders.

mod common;

use common::{Owned, inward_box, mean_and_error, render};
use pmcip_core::sampler::batch::{Batch8, Integrand, Rgb8};
use pmcip_core::sampler::{Schedule, Settings};
use pmcip_core::tracer::camera::Camera;
use pmcip_core::tracer::scene::{
    MIN_ROUGHNESS, Material, Scattering, Scene, SceneData, Surface, Texture, Triangle,
};
use pmcip_core::tracer::shade::direct::{DirectLighting, Samples};
use pmcip_core::tracer::shade::path::PathTracer;
use wide::f32x8;

const SIDE: u32 = 16;

/// Mean radiance by colour and its standard error over eight seeds, seen at an angle.
fn furnace(owned: &Owned, max_depth: u32) -> [(f64, f64); 3] {
    seen(owned, max_depth, [0.1, 0.2, 0.8], 60.0)
}

fn seen(owned: &Owned, max_depth: u32, from: [f32; 3], fov: f32) -> [(f64, f64); 3] {
    let camera = Camera::new(from, [0.0; 3], [0.0, 1.0, 0.0], fov, SIDE, SIDE).unwrap();
    let mut means = [const { Vec::new() }; 3];
    for seed in 0..8 {
        let settings = Settings { seed, ..Settings::uniform(SIDE, SIDE) };
        let schedule = Schedule::new(u64::from(SIDE * SIDE), 64, 64, 1);
        let (rgb, _) = render(owned.scene(), camera, max_depth, settings, schedule);
        for (c, means) in means.iter_mut().enumerate() {
            let sum: f64 = rgb.iter().skip(c).step_by(3).map(|v| f64::from(*v)).sum();
            means.push(sum / f64::from(SIDE * SIDE));
        }
    }
    means.map(|m| mean_and_error(&m))
}

fn box_of(wall: Material, inside: &[(Triangle, u32)], other: Material) -> Owned {
    let walls = inward_box([-1.0; 3], [1.0; 3]).into_iter().map(|t| (t, 0));
    let parts: Vec<_> = walls.chain(inside.iter().copied()).collect();
    Owned::new(&parts, vec![wall, other])
}

fn geometric(albedo: f64, depth: u32) -> f64 {
    (0..depth).map(|k| albedo.powi(k as i32)).sum()
}

fn assert_near(measured: (f64, f64), expected: f64, what: &str) {
    let (mean, error) = measured;
    // Rounding: about 10 additions and multiplications of relative error 2^-24 a bounce.
    let tolerance = 4.0 * error + 1e-5 * expected;
    assert!((mean - expected).abs() <= tolerance, "{what}: {mean} ± {error}, expected {expected}");
}

/// Rays slip through no crack and multiple importance sampling weighs every path once.
#[test]
fn diffuse_furnace_is_analytic() {
    let albedo = [0.2, 0.5, 0.8];
    let wall = Material { diffuse: albedo, emission: [1.0; 3], ..Material::default() };
    for depth in [1, 2, 3, 8, 40] {
        let measured = furnace(&box_of(wall, &[], wall), depth);
        for (measured, albedo) in measured.into_iter().zip(albedo) {
            assert_near(measured, geometric(albedo.into(), depth), &format!("albedo {albedo} depth {depth}"));
        }
    }
}

/// The negative control: with an albedo off by half a percent the test above would fail.
#[test]
fn furnace_notices_half_a_percent() {
    let wall = Material { diffuse: [0.5 * 1.005; 3], emission: [1.0; 3], ..Material::default() };
    let (mean, error) = furnace(&box_of(wall, &[], wall), 8)[1];
    let expected = geometric(0.5, 8);
    assert!((mean - expected).abs() > 4.0 * error + 1e-5 * expected, "{mean} ± {error} near {expected}");
}

/// Front outwards.
fn block(half: f32) -> Vec<(Triangle, u32)> {
    let swap = |t: Triangle| Triangle { corners: [t.corners[0], t.corners[2], t.corners[1]] };
    inward_box([-half; 3], [half; 3]).into_iter().map(|t| (swap(t), 1)).collect()
}

/// Mirror and glass neither take nor add light: black walls that emit 1 look the same in them. Paths inside the
/// block can be long: cut at depth D they miss a part that falls with D.
#[test]
fn specular_objects_vanish_in_a_furnace() {
    let wall = Material { diffuse: [0.0; 3], emission: [1.0; 3], ..Material::default() };
    let mirror = Material { scattering: Scattering::Mirror, specular: [1.0; 3], ..Material::default() };
    let glass = Material { scattering: Scattering::Dielectric, ior: 1.5, ..mirror };
    for (other, name) in [(mirror, "mirror"), (glass, "glass")] {
        for measured in furnace(&box_of(wall, &block(0.35), other), 200) {
            let (mean, error) = measured;
            assert!(mean <= 1.0 + 4.0 * error + 1e-5, "{name} adds light: {mean} ± {error}");
            // Total reflection traps a few paths in a cube for good, as it would light.
            assert!(mean >= 0.98, "{name} loses light: {mean} ± {error}");
        }
    }
}

/// Walls of albedo ½ around a perfect mirror: 1/(1 − ½) everywhere, since no two bounces in a row are mirrored and depth
/// 80 cuts off less than 2⁻³⁹. Packets hold rays that hit walls beside rays that hit the mirror: neither may take
/// anything from the other's material.
#[test]
fn mirrors_do_not_change_walls() {
    let wall = Material { diffuse: [0.5; 3], emission: [1.0; 3], ..Material::default() };
    let mirror = Material { scattering: Scattering::Mirror, specular: [1.0; 3], ..Material::default() };
    for roughness in [0.4, 1.0] {
        let wall = Material { roughness, ..wall };
        for measured in furnace(&box_of(wall, &block(0.35), mirror), 80) {
            assert_near(measured, 2.0, &format!("walls of unused roughness {roughness} around a mirror"));
        }
    }
}

fn glossy_block(roughness: f32) -> Owned {
    let wall = Material { diffuse: [0.0; 3], emission: [1.0; 3], ..Material::default() };
    let glossy = Material { diffuse: [0.0; 3], specular: [1.0; 3], roughness, ..Material::default() };
    box_of(wall, &block(0.35), glossy)
}

/// A GGX lobe never reflects more than arrives, and a narrow one loses little to single scattering, however narrow.
#[test]
fn glossy_objects_add_no_light() {
    let narrow = [MIN_ROUGHNESS, 1e-5, 1e-4, 1e-3, 1e-2].map(|roughness| (roughness, 0.998));
    for (roughness, least) in narrow.into_iter().chain([(0.05, 0.99), (0.3, 0.8), (1.0, 0.3)]) {
        for (mean, error) in furnace(&glossy_block(roughness), 30) {
            assert!(mean <= 1.0 + 4.0 * error + 1e-5, "α {roughness} adds light: {mean} ± {error}");
            assert!(mean >= least - 4.0 * error, "α {roughness} loses light: {mean} ± {error}");
        }
    }
}

/// What an integrator makes of the middle of a picture of `data`.
fn middle<'a, I: Integrand>(data: SceneData<'a>, integrator: impl FnOnce(Scene<'a>, Camera) -> I) -> Rgb8 {
    let camera = Camera::new([0.1, 0.2, 0.8], [0.0; 3], [0.0, 1.0, 0.0], 60.0, SIDE, SIDE).unwrap();
    let (x, y) = (f32x8::splat(7.5), f32x8::splat(3.5));
    let batch = Batch8 { lanes: 8, x, y, ..Batch8::default() };
    integrator(Scene::new(data).unwrap(), camera).radiance(&batch)
}

/// Light that is not a number does not end a path silently: the sample is NaN, which the film rejects and counts.
#[test]
fn what_is_not_a_number_is_seen() {
    let wall = Material { emission: [1.0; 3], ..Material::default() };
    let owned = box_of(wall, &[], wall);
    let materials = [Material { texture: 0, ..wall }; 2];
    let (textures, texels) =
        ([Texture { width: 1, height: 1, first: 0, ..Texture::EMPTY }], [[0.5, f32::NAN, 0.5]]);
    let (textures, texels) = (&textures[..], &texels[..]);
    let broken = SceneData { materials: &materials, textures, texels, ..*owned.scene().data() };
    let (mut packets, mut more) = (common::packets(), common::packets());
    let samples = Samples { light: 2, bsdf: 2 };
    let seen = [
        middle(broken, |scene, camera| PathTracer::new(scene, camera, 3, &mut packets)),
        middle(broken, |scene, camera| DirectLighting::new(scene, camera, 2, samples, &mut more)),
    ];
    for rgb in seen {
        assert!(rgb.g.is_nan().all(), "{rgb:?}");
    }
}

/// Nor where no lamp is aimed at and the density itself is not a number, or the surface has no direction.
#[test]
fn what_is_not_a_number_is_seen_without_lamps() {
    let dark = Material { specular: [0.04; 3], roughness: 0.3, ..Material::default() };
    let owned = box_of(dark, &[], dark);
    let sound = *owned.scene().data();
    let materials = [Material { texture: 0, ..dark }; 2];
    let (textures, texels) = ([Texture { width: 1, height: 1, first: 0, ..Texture::EMPTY }], [[f32::NAN; 3]]);
    let (textures, texels) = (&textures[..], &texels[..]);
    let normals = [[f32::INFINITY; 3]; 3];
    let surfaces: Vec<_> = sound.surfaces.iter().map(|s| Surface { normals, ..*s }).collect();
    let mut packets = common::packets();
    let mut seen = |data| middle(data, |scene, camera| PathTracer::new(scene, camera, 3, &mut packets));
    assert_eq!(seen(sound), Rgb8::default());
    let coloured = seen(SceneData { materials: &materials, textures, texels, ..sound });
    assert!(coloured.r.is_nan().all(), "{coloured:?}");
    let turned = seen(SceneData { surfaces: &surfaces, ..sound });
    assert!(turned.r.is_nan().all(), "{turned:?}");
}

/// Straight on, a GGX surface of α = 1 reflects ∫ 2i/(1 + i) over half vectors of density cos θ/π, where
/// i = cos 2θ is the cosine of the reflected direction: with x = cos² θ that is ∫ (2 − 1/x) dx from ½ to 1.
#[test]
fn widest_lobe_reflects_one_minus_ln_two() {
    for measured in seen(&glossy_block(1.0), 30, [0.0, 0.0, 0.8], 0.5) {
        assert_near(measured, 1.0 - std::f64::consts::LN_2, "α 1 straight on");
    }
}
