//! Lamps that shine away from everything: whoever made them has the winding the other way round.

use super::pose::Geometry;
use glam::Vec3;
use pmcip_core::tracer::scene::Material;
use std::collections::BTreeMap;

/// Materials that are looked at.
const MATERIALS: usize = 64;

/// Triangles of a material that are looked at.
const TRIANGLES: usize = 16;

/// How far before a lamp's plane something must be, as a part of its distance.
const BEFORE: f32 = 1e-4;

/// The materials that emit, but before none of whose triangles there is a corner of anything else, though there is
/// something else.
pub(super) fn backwards(geometry: &Geometry, materials: &[Material]) -> Vec<u32> {
    let mut lamps: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (triangle, surface) in geometry.surfaces.iter().enumerate() {
        if materials[surface.material as usize].emission.iter().any(|v| *v > 0.0) {
            lamps.entry(surface.material).or_default().push(triangle);
        }
    }
    let wrong = lamps.into_iter().take(MATERIALS).filter(|(material, triangles)| {
        let mut some = triangles.iter().step_by(triangles.len().div_ceil(TRIANGLES));
        others(geometry, *material).next().is_some() && some.all(|lamp| !shines(geometry, *lamp, *material))
    });
    wrong.map(|(material, _)| material).collect()
}

/// Corners of everything that is not of a material.
fn others(geometry: &Geometry, material: u32) -> impl Iterator<Item = Vec3> {
    let pairs = geometry.triangles.iter().zip(&geometry.surfaces);
    let others = pairs.filter(move |(_, surface)| surface.material != material);
    others.flat_map(|(triangle, _)| triangle.corners).map(Vec3::from)
}

/// Whether something of another material is before a triangle.
fn shines(geometry: &Geometry, lamp: usize, material: u32) -> bool {
    let [a, b, c] = geometry.triangles[lamp].corners.map(Vec3::from);
    let front = (b - a).cross(c - a).normalize_or_zero();
    others(geometry, material).any(|corner| (corner - a).dot(front) > BEFORE * corner.distance(a))
}
