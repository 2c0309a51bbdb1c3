//! Emitting triangles: the table that picks one by power, and points on them.
//!
//! A light is picked with probability proportional to its area times the luminance of its radiance, a point on
//! it uniformly. The density of a point per area is then luminance over total power, the same formula for every
//! light, so that a path that hits an emitter by chance knows it without looking the light up.

use super::{fetch, hit};
use crate::scene::{Light, Material, Scene, SceneData, Surface, Triangle};
use crate::vec3::{self, Vec3x8};
use wide::f32x8;

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

fn power(triangle: &Triangle, material: &Material) -> f64 {
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
/// light.
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
        *light = Light { triangle: triangle as u32, cumulative: (sum / total) as f32 };
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
    /// Density per unit area.
    pub density: f32x8,
    /// Distance from the light at which rays that leave it start.
    pub clearance: f32x8,
}

/// Picks points on the lights from uniform numbers `u`, `v` in `[0, 1)`. The scene must have a light.
#[inline]
pub(super) fn sample(scene: &Scene<'_>, u: f32x8, v: f32x8) -> LightPoints {
    let data = scene.data();
    let u = u.to_array();
    let picked = u.map(|u| pick(data.lights, u));
    let below = f32x8::from(picked.map(|i| if i == 0 { 0.0 } else { data.lights[i - 1].cumulative }));
    let above = f32x8::from(picked.map(|i| data.lights[i].cumulative));
    // The number that picked the triangle is stretched over its share and serves again.
    let again = ((f32x8::from(u) - below) / (above - below)).fast_max(f32x8::ZERO).fast_min(f32x8::ONE);
    let triangle = picked.map(|i| data.lights[i].triangle);
    let [a, b, c] = fetch::corners(data, triangle);
    let root = again.sqrt();
    let position = a + (b - a) * (root * (f32x8::ONE - v)) + (c - a) * (root * v);
    let material = triangle.map(|i| data.surfaces[i as usize].material);
    let radiance = fetch::materials(data, material).emission;
    LightPoints {
        position,
        normal: (b - a).cross(c - a).normalized(),
        radiance,
        density: luminance8(radiance) * f32x8::splat(scene.inverse_power()),
        clearance: hit::largest([a, b, c]) * f32x8::splat(hit::CLEARANCE),
    }
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
