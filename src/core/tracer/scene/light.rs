//! What a light is: emitting triangles, and the table that picks one by power.

use super::surface::{Material, Surface, Triangle};
use crate::maths::colour::luminance;
use crate::maths::vec3;
use bytemuck::{Pod, Zeroable};

/// An emitting triangle, its place in the table that picks one by power, and its place in the light tree.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Light {
    /// What points on it are made of.
    pub lamp: Lamp,
    /// Index into [`SceneData::triangles`](crate::tracer::scene::SceneData::triangles).
    pub triangle: u32,
    /// Probability that a light before this one, or this one, is picked; 1 for the last.
    pub cumulative: f32,
    /// Which child to follow in the light tree at each level, three bits a level, the root's lowest. Not used
    /// without a tree.
    pub path: u32,
}

/// A triangle and what it emits, as points are picked on it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Lamp {
    /// The first corner, in scene units.
    pub corner: [f32; 3],
    /// From there to the second and to the third.
    pub edges: [[f32; 3]; 2],
    /// Unit normal on the emitting side.
    pub normal: [f32; 3],
    /// Emitted radiance, that of the material.
    pub emission: [f32; 3],
    /// One over the area, in scene units.
    pub inverse_area: f32,
}

impl Lamp {
    /// The lamp that a triangle of a material is; not finite where the triangle has no area, which no light is without.
    pub fn new(triangle: &Triangle, material: &Material) -> Self {
        let [a, b, c] = triangle.corners;
        let edges = [vec3::sub(b, a), vec3::sub(c, a)];
        let across = vec3::cross(edges[0], edges[1]);
        let inverse = 1.0 / libm::sqrtf(vec3::dot(across, across));
        let normal = vec3::scale(across, inverse);
        Lamp { corner: a, edges, normal, emission: material.emission, inverse_area: 2.0 * inverse }
    }
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
    let dark = Material { emission: [0.0; 3], ..Material::default() };
    let material = |s: &Surface| materials.get(s.material as usize).unwrap_or(&dark);
    let lamps = || {
        let all = triangles.iter().zip(surfaces).enumerate();
        let with_power = |(i, (t, s))| (i as u32, t, material(s), power(t, material(s)));
        all.map(with_power).filter(|lamp| lamp.3 > 0.0)
    };
    let total: f64 = lamps().take(out.len()).map(|lamp| lamp.3).sum();
    let mut sum = 0.0;
    let mut used = 0;
    for (light, (index, triangle, material, power)) in out.iter_mut().zip(lamps()) {
        sum += power;
        let cumulative = (sum / total) as f32;
        *light = Light { lamp: Lamp::new(triangle, material), triangle: index, cumulative, path: 0 };
        used += 1;
    }
    if let Some(last) = out[..used].last_mut() {
        last.cumulative = 1.0;
    }
    used
}
