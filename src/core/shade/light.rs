//! Emitting triangles: the table that picks one by power, and points on them.
//!
//! A light is picked with probability proportional to its area times the luminance of its radiance, a point on
//! it uniformly. The density of a point per area is then luminance over total power, the same formula for every
//! light, so that a path that hits an emitter by chance knows it without looking the light up.

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
}

/// Picks points on the lights from uniform numbers `u`, `v` in `[0, 1)`. The scene must have a light.
#[inline]
pub(super) fn sample(scene: &Scene<'_>, u: f32x8, v: f32x8) -> LightPoints {
    let data = scene.data();
    let mut corners = [[0.0f32; 8]; 9];
    let mut emission = [[0.0f32; 8]; 3];
    let mut again = u.to_array();
    for (lane, u) in again.iter_mut().enumerate() {
        let (triangle, rest) = pick(data.lights, *u);
        *u = rest;
        let triangle = triangle as usize;
        for (row, value) in corners.iter_mut().zip(data.triangles[triangle].corners.as_flattened()) {
            row[lane] = *value;
        }
        let material = &data.materials[data.surfaces[triangle].material as usize];
        for (row, value) in emission.iter_mut().zip(&material.emission) {
            row[lane] = *value;
        }
    }
    let corner = |i: usize| rows(&corners, 3 * i);
    let (a, ab, ac) = (corner(0), corner(1) - corner(0), corner(2) - corner(0));
    let root = f32x8::from(again).sqrt();
    let (b1, b2) = (root * (f32x8::ONE - v), root * v);
    let radiance = rows(&emission, 0);
    LightPoints {
        position: a + ab * b1 + ac * b2,
        normal: ab.cross(ac).normalized(),
        radiance,
        density: luminance8(radiance) * f32x8::splat(scene.inverse_power()),
    }
}

#[inline(always)]
fn rows(lanes: &[[f32; 8]], first: usize) -> Vec3x8 {
    Vec3x8::new(lanes[first].into(), lanes[first + 1].into(), lanes[first + 2].into())
}

/// The triangle that `u` falls on, and `u` stretched over its share, so that one number serves twice.
#[inline]
fn pick(lights: &[Light], u: f32) -> (u32, f32) {
    let i = lights.partition_point(|l| l.cumulative <= u).min(lights.len() - 1);
    let before = if i == 0 { 0.0 } else { lights[i - 1].cumulative };
    let share = lights[i].cumulative - before;
    let rest = ((u - before) / share).clamp(0.0, 1.0 - f32::EPSILON);
    (lights[i].triangle, rest)
}
