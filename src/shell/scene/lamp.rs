//! The lamp of last resort in a room, as a photographer would place it: behind the camera, above it and to its left.

use super::model::View;
use super::place::Placement;
use super::pose::Geometry;
use glam::Vec3;

/// Half the lamp's side, in distances from what it lights.
const HALF: f32 = 0.25;

/// Where a wall is in the way, the lamp stands before it, at this part of the way from the eye.
const BEFORE_WALL: f32 = 0.5;

/// The rectangle that lights what `view` shows of a scene, and its radiance: a white surface that faces it in the middle of
/// the picture gets radiance 1.
///
/// What is in the middle is the point looked at, or what hides it. In a room the lamp is inside as the eye is.
pub(super) fn key_light(view: &View, geometry: &Geometry) -> (Placement, f32) {
    let (from, aim) = (Vec3::from(view.from), Vec3::from(view.at));
    let at = match first_hit(geometry, from, aim - from) {
        Some(t) if t > 0.0 && t < 1.0 => from + t * (aim - from),
        _ => aim,
    };
    let (back, up) = (from - at, Vec3::from(view.up).normalize());
    let left = up.cross(-back);
    let offset = 0.35 * back + 0.6 * back.length() * up + 0.45 * left;
    // The corners are about half as far from the middle as that is from the eye: look that much further.
    let free = first_hit(geometry, from, 1.5 * offset).map_or(1.0, |t| (BEFORE_WALL * 1.5 * t).min(1.0));
    let center = from + free * offset;
    let (shine, distance) = ((at - center).normalize(), at.distance(center));
    let across = shine.cross(up).normalize();
    // Nearer walls leave less room; it is as bright all the same.
    let half = HALF * free;
    let [u, v] = [across, shine.cross(across)].map(|edge| half * distance * edge);
    // Irradiance is radiance times area over the squared distance: π makes white shine with 1.
    let radiance = std::f32::consts::PI / (4.0 * half * half);
    (Placement::rectangle(center.as_dvec3(), u, v), radiance)
}

/// Whether the eye is in a room, where no sky is seen: something is on at least five of its six sides.
pub(super) fn is_indoors(view: &View, geometry: &Geometry) -> bool {
    let from = Vec3::from(view.from);
    let forward = (Vec3::from(view.at) - from).normalize_or(Vec3::NEG_Z);
    let across = forward.cross(Vec3::from(view.up)).normalize_or(Vec3::X);
    let sides = [forward, across, across.cross(forward)];
    let walls = sides.into_iter().flat_map(|side| [side, -side]);
    walls.filter(|side| first_hit(geometry, from, *side).is_some()).count() >= 5
}

/// How many times `step` it is from `from` to the first triangle in its way, seen by all of them.
fn first_hit(geometry: &Geometry, from: Vec3, step: Vec3) -> Option<f32> {
    let distances = geometry.triangles.iter().filter_map(|triangle| {
        let [a, b, c] = triangle.corners.map(Vec3::from);
        // Möller and Trumbore, Fast, minimum storage ray-triangle intersection, 1997.
        let (u, v, away) = (b - a, c - a, from - a);
        let across = step.cross(v);
        let inverse = u.dot(across).recip();
        let second = away.cross(u);
        let (x, y, t) = (away.dot(across) * inverse, step.dot(second) * inverse, v.dot(second) * inverse);
        (x >= 0.0 && y >= 0.0 && x + y <= 1.0 && t > 1e-5).then_some(t)
    });
    distances.min_by(f32::total_cmp)
}
