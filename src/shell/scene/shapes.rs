//! Shapes the scene file knows by name, as triangles: sphere and square.

use super::object::Corner;
use glam::{DVec3, Vec3};

/// The unit sphere as an icosahedron whose triangles are split in four `subdivisions` times, with the sphere's normals.
pub(super) fn sphere(subdivisions: u32) -> Vec<[Corner; 3]> {
    let mut triangles = icosahedron();
    for _ in 0..subdivisions {
        triangles = triangles.into_iter().flat_map(split).collect();
    }
    let corner = |n: Vec3| Corner { position: n, normal: n, ..Corner::default() };
    triangles.into_iter().map(|t| t.map(corner)).collect()
}

/// How many triangles [`sphere`] makes.
pub(super) fn sphere_len(subdivisions: u32) -> usize {
    20 << (2 * subdivisions)
}

/// The square of corners (±1, ±1, 0), its front along z.
pub(super) fn square() -> [[Corner; 3]; 2] {
    let [a, b, c, d] = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(x, y)| Corner { position: Vec3::new(x, y, 0.0), ..Corner::default() });
    [[a, b, c], [a, c, d]]
}

/// Four triangles from one, on the unit sphere.
fn split([a, b, c]: [Vec3; 3]) -> [[Vec3; 3]; 4] {
    let (ab, bc, ca) = ((a + b).normalize(), (b + c).normalize(), (c + a).normalize());
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}

/// The 20 faces of an icosahedron in the unit sphere, counter-clockwise from outside.
fn icosahedron() -> Vec<[Vec3; 3]> {
    // Two poles and two rings of five, the lower ring turned by half a step.
    let height = 1.0 / 5f32.sqrt();
    let ring = |y: f32, turn: f32, i: usize| {
        let angle = (i as f32 + turn) * std::f32::consts::TAU / 5.0;
        let radius = (1.0 - y * y).sqrt();
        Vec3::new(radius * angle.sin(), y, radius * angle.cos())
    };
    let upper: Vec<Vec3> = (0..6).map(|i| ring(height, 0.0, i % 5)).collect();
    let lower: Vec<Vec3> = (0..6).map(|i| ring(-height, 0.5, i % 5)).collect();
    (0..5)
        .flat_map(|i| {
            let (u, u2, l, l2) = (upper[i], upper[i + 1], lower[i], lower[i + 1]);
            [[Vec3::Y, u, u2], [u, l, u2], [u2, l, l2], [Vec3::NEG_Y, l2, l]]
        })
        .collect()
}

/// How far a point is from the nearest one of a triangle.
pub(super) fn distance(point: DVec3, corners: [DVec3; 3]) -> f64 {
    let edge = |i: usize| (corners[i], corners[(i + 1) % 3] - corners[i]);
    let to_edge = |i: usize| {
        let (start, along) = edge(i);
        let part = (point - start).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
        point.distance(start + part.clamp(0.0, 1.0) * along)
    };
    let normal = edge(0).1.cross(edge(1).1).normalize_or_zero();
    let inside = (0..3).all(|i| edge(i).1.cross(point - edge(i).0).dot(normal) >= 0.0);
    match inside && normal != DVec3::ZERO {
        true => (point - corners[0]).dot(normal).abs(),
        false => (0..3).map(to_edge).fold(f64::INFINITY, f64::min),
    }
}
