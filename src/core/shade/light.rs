//! Emitting triangles: the table that picks one by power, and points on them.
//!
//! Few lights are picked with probability proportional to area times luminance of the radiance. The density of a point
//! per area is then luminance over total power, the same formula for every light, so that a path that hits an
//! emitter by chance knows it without looking the light up. Many lights are picked by the
//! [light tree](super::light_tree), if the scene has one. A point on a light is picked uniformly.

use super::fetch;
use super::hit;
use super::light_tree::{self, Picked, Receiver, Root};
use crate::scene::{Light, Material, Scene, SceneData, Surface, Triangle};
use crate::vec3::{self, Vec3x8};
use wide::{f32x8, u32x8};

/// Luminance of a linear Rec. 709 colour.
pub(crate) fn luminance(rgb: [f32; 3]) -> f32 {
    vec3::dot(rgb, [0.2126, 0.7152, 0.0722])
}

/// Luminance of eight linear Rec. 709 colours.
#[inline(always)]
pub(crate) fn luminance8(rgb: Vec3x8) -> f32x8 {
    rgb.dot(Vec3x8::splat([0.2126, 0.7152, 0.0722]))
}

fn area(triangle: &Triangle) -> f32 {
    let [a, b, c] = triangle.corners;
    let normal = vec3::cross(vec3::sub(b, a), vec3::sub(c, a));
    0.5 * libm::sqrtf(vec3::dot(normal, normal))
}

/// Luminance times area.
pub(super) fn power(triangle: &Triangle, material: &Material) -> f64 {
    f64::from(area(triangle)) * f64::from(luminance(material.emission))
}

/// Luminance times area, summed over the lights.
pub(crate) fn total_power(data: &SceneData<'_>) -> f64 {
    let of = |light: &Light| {
        let i = light.triangle as usize;
        power(&data.triangles[i], &data.materials[data.surfaces[i].material as usize])
    };
    data.lights.iter().map(of).sum()
}

/// How many triangles emit: the length [`build`] needs. Indices out of range count as dark.
pub fn count(surfaces: &[Surface], materials: &[Material]) -> usize {
    surfaces.iter().filter(|s| emits(s, materials)).count()
}

fn emits(surface: &Surface, materials: &[Material]) -> bool {
    materials.get(surface.material as usize).is_some_and(|m| luminance(m.emission) > 0.0)
}

/// Fills `out` with the table of emitting triangles and returns how many entries it has.
///
/// `out` should hold [`count`] entries; emitters beyond its end are left out. A triangle without area is no
/// light. Lights are picked by numbers in steps of 2⁻²⁴: one with less of the total power may never be picked.
pub fn build(
    triangles: &[Triangle],
    surfaces: &[Surface],
    materials: &[Material],
    out: &mut [Light],
) -> usize {
    let power_of =
        |(t, s): (&Triangle, &Surface)| materials.get(s.material as usize).map_or(0.0, |m| power(t, m));
    let powers = || triangles.iter().zip(surfaces).map(power_of).enumerate().filter(|e| e.1 > 0.0);
    let total: f64 = powers().take(out.len()).map(|e| e.1).sum();
    let mut sum = 0.0;
    let mut used = 0;
    for (light, (triangle, power)) in out.iter_mut().zip(powers()) {
        sum += power;
        *light = Light { triangle: triangle as u32, cumulative: (sum / total) as f32, path: 0 };
        used += 1;
    }
    if let Some(last) = out[..used].last_mut() {
        last.cumulative = 1.0;
    }
    used
}

/// Eight points on emitters.
pub(super) struct LightPoints {
    /// Positions.
    pub position: Vec3x8,
    /// Unit normals on the emitting side.
    pub normal: Vec3x8,
    /// Emitted radiance.
    pub radiance: Vec3x8,
    /// Density per unit area; where lights are picked by power, what it would be if the table were not rounded.
    pub density: f32x8,
    /// Density per unit area, exactly that with which lights are picked.
    pub exact_density: f32x8,
    /// Distance from the light at which rays that leave it start.
    pub clearance: f32x8,
}

/// The lights as they are picked for eight receivers.
pub(super) struct Lights<'a> {
    data: &'a SceneData<'a>,
    inverse_power: f32,
    tree: Option<Root<'a>>,
}

impl<'a> Lights<'a> {
    /// Weighs the lights, of which the scene must have one.
    #[inline(always)]
    pub fn new(scene: &'a Scene<'_>, receiver: impl FnOnce() -> Receiver) -> Self {
        let data = scene.data();
        let tree = (!data.light_nodes.is_empty()).then(|| Root::new(data.light_nodes, receiver()));
        Lights { data, inverse_power: scene.inverse_power(), tree }
    }

    /// The lights by power alone, without a receiver. The scene must have one.
    pub fn by_power(scene: &'a Scene<'_>) -> Self {
        Lights { data: scene.data(), inverse_power: scene.inverse_power(), tree: None }
    }

    /// Picks points on the lights from uniform numbers `u`, `v` in `[0, 1)`.
    #[inline(always)]
    pub fn sample(&self, u: f32x8, v: f32x8) -> LightPoints {
        let data = self.data;
        let picked = self.tree.as_ref().map_or_else(|| by_power(data, u), |tree| tree.pick(u));
        let triangle = picked.light.map(|i| data.lights[i as usize].triangle);
        let [a, b, c] = fetch::corners(data, triangle);
        let root = picked.again.sqrt();
        let position = a + (b - a) * (root * (f32x8::ONE - v)) + (c - a) * (root * v);
        let material = triangle.map(|i| data.surfaces[i as usize].material);
        let radiance = fetch::materials(data, material).emission;
        let across = (b - a).cross(c - a);
        let inverse = f32x8::ONE / across.length();
        let exact_density = picked.probability * f32x8::splat(2.0) * inverse;
        let density = match self.tree {
            Some(_) => exact_density,
            None => luminance8(radiance) * f32x8::splat(self.inverse_power),
        };
        let clearance = hit::largest([a, b, c]) * f32x8::splat(hit::CLEARANCE);
        LightPoints { position, normal: across * inverse, radiance, density, exact_density, clearance }
    }
}

/// The density per unit area that [`Lights::sample`] has for `receiver` on triangles of radiance `emission`, in the
/// lanes whose bit is set in `lanes`.
#[inline(always)]
pub(super) fn density(
    scene: &Scene<'_>,
    receiver: impl FnOnce() -> Receiver,
    triangle: u32x8,
    emission: Vec3x8,
    lanes: u32,
) -> f32x8 {
    match scene.data().light_nodes {
        [] => luminance8(emission) * f32x8::splat(scene.inverse_power()),
        _ => tree_density(scene.data(), &receiver(), triangle.to_array(), lanes),
    }
}

fn tree_density(data: &SceneData<'_>, receiver: &Receiver, triangle: [u32; 8], lanes: u32) -> f32x8 {
    let mut density = [0.0; 8];
    for lane in (0..8).filter(|lane| lanes >> lane & 1 == 1) {
        if let Ok(found) = data.lights.binary_search_by_key(&triangle[lane], |light| light.triangle) {
            let light = &data.lights[found];
            let probability = light_tree::probability(data.light_nodes, light.path, receiver, lane);
            density[lane] = probability / area(&data.triangles[triangle[lane] as usize]);
        }
    }
    density.into()
}

/// Picks lights by the table.
#[inline(always)]
fn by_power(data: &SceneData<'_>, u: f32x8) -> Picked {
    let u = u.to_array();
    let picked = u.map(|u| pick(data.lights, u));
    let below = f32x8::from(picked.map(|i| if i == 0 { 0.0 } else { data.lights[i - 1].cumulative }));
    let above = f32x8::from(picked.map(|i| data.lights[i].cumulative));
    // The number that picked the triangle is stretched over its share and serves again.
    let again = ((f32x8::from(u) - below) / (above - below)).fast_max(f32x8::ZERO).fast_min(f32x8::ONE);
    // Random numbers go by steps: what counts is how many of them fall on the share.
    let steps = (above * f32x8::splat(STEPS)).ceil() - (below * f32x8::splat(STEPS)).ceil();
    Picked { light: picked.map(|i| i as u32), probability: steps * f32x8::splat(1.0 / STEPS), again }
}

/// How many values a coordinate of [`sobol`](crate::sobol) has.
const STEPS: f32 = (1 << 24) as f32;

/// Whether to look for the lights that a ray meets one by one, before what may be in between.
#[inline(always)]
pub(super) fn are_few(data: &SceneData<'_>) -> bool {
    data.lights.len() <= SHORT
}

/// Tables up to this length are searched from the front.
const SHORT: usize = 8;

/// The light whose share `u` falls on.
#[inline(always)]
fn pick(lights: &[Light], u: f32) -> usize {
    let last = lights.len() - 1;
    if lights.len() <= SHORT {
        return lights[..last].iter().map(|l| usize::from(l.cumulative <= u)).sum();
    }
    lights.partition_point(|l| l.cumulative <= u).min(last)
}
