//! What a light is: emitting triangles, and the table that picks one by power.

use super::surface::{Material, Surface, Triangle};
use crate::maths::colour::luminance;
use crate::maths::vec3;

/// An emitting triangle, its place in the table that picks one by power, and its place in the light tree.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Light {
    /// Index into [`SceneData::triangles`](crate::tracer::scene::SceneData::triangles).
    pub triangle: u32,
    /// Probability that a light before this one, or this one, is picked; 1 for the last.
    pub cumulative: f32,
    /// Which child to follow in the light tree at each level, three bits a level, the root's lowest. Not used
    /// without a tree.
    pub path: u32,
}

pub(crate) fn area(triangle: &Triangle) -> f32 {
    let [a, b, c] = triangle.corners;
    let normal = vec3::cross(vec3::sub(b, a), vec3::sub(c, a));
    0.5 * libm::sqrtf(vec3::dot(normal, normal))
}

/// Luminance times area.
pub(super) fn power(triangle: &Triangle, material: &Material) -> f64 {
    f64::from(area(triangle)) * f64::from(luminance(material.emission))
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
