//! The plinth: stepped mouldings, a frieze of rosettes, rows of dentils and pearls.

use super::super::sdf::{join, slab, sphere};
use glam::{Vec3, vec3};

/// Pitch of the rosettes along the frieze.
const PITCH: f32 = 0.158;
/// Half the width and depth of the frieze.
const FRIEZE: (f32, f32) = (0.474, 0.395);

/// The plinth under a seat at the origin.
pub fn solid(p: Vec3) -> f32 {
    let near = p.y + 0.24;
    if near > 0.06 {
        return near;
    }
    let course = |y: f32, half: f32, height: f32, round: f32| {
        let size = vec3(FRIEZE.0 + half, height, FRIEZE.1 + half);
        slab(p, vec3(0.0, y, 0.0), size, round)
    };
    let mouldings = [
        course(-0.315, 0.105, 0.022, 0.008),
        course(-0.352, 0.070, 0.018, 0.016),
        course(-0.382, 0.040, 0.014, 0.004),
        course(-0.48, 0.0, 0.10, 0.004),
        course(-0.585, 0.045, 0.015, 0.004),
        course(-0.615, 0.075, 0.020, 0.018),
        course(-0.685, 0.120, 0.060, 0.010),
    ];
    let stone = mouldings.into_iter().fold(f32::INFINITY, f32::min);
    if stone > 0.06 {
        return stone;
    }
    let (along, out) = face(p);
    join(stone, ornament(along, p.y, out), 0.006)
}

/// Position along the nearest side of the plinth and distance before the frieze's face there.
fn face(p: Vec3) -> (f32, f32) {
    let (x, z) = (p.x.abs() - FRIEZE.0, p.z.abs() - FRIEZE.1);
    if x > z { (p.z, x) } else { (p.x, z) }
}

/// What stands out from the faces.
fn ornament(along: f32, y: f32, out: f32) -> f32 {
    let cell = (along / PITCH).round() * PITCH;
    let local = vec3(along - cell, y + 0.48, out);
    rosette(local).min(frame(local)).min(row(along, y, out))
}

/// A flower of eight petals in a ring.
fn rosette(q: Vec3) -> f32 {
    let (radius, angle) = (q.x.hypot(q.y), q.x.atan2(q.y));
    let lobes = 0.046 + 0.012 * (8.0 * angle).cos();
    let petals = 0.020 * (1.0 - (radius / lobes).powi(2)).max(-0.5) * (0.4 + 1.6 * (radius / 0.05)).min(1.0);
    let flower = (q.z - petals).max(radius - 0.056);
    let heart = sphere(q, vec3(0.0, 0.0, 0.008), 0.015);
    let ring = (radius - 0.066).hypot(q.z) - 0.0065;
    flower.min(heart).min(ring)
}

/// Bars between the rosettes and along the frieze's edges.
fn frame(q: Vec3) -> f32 {
    let bar = (0.5 * PITCH - q.x.abs()).hypot(q.z) - 0.0065;
    let edge = (0.090 - q.y.abs()).hypot(q.z) - 0.010;
    bar.max(q.y.abs() - 0.092).min(edge)
}

/// Dentils under the cornice and pearls on the foot.
fn row(along: f32, y: f32, out: f32) -> f32 {
    let repeat = |pitch: f32| along - (along / pitch).round() * pitch;
    let tooth = vec3(repeat(0.0465).abs() - 0.013, (y + 0.352).abs() - 0.011, out - 0.078);
    let dentil = tooth.max(Vec3::ZERO).length() + tooth.max_element().min(0.0) - 0.002;
    let pearl = vec3(repeat(0.0425), y + 0.615, out - 0.075).length() - 0.015;
    let roundel = vec3(repeat(0.12), y + 0.688, out - 0.106);
    let disc = roundel.x.hypot(roundel.y) - 0.036;
    let disc = disc.max(roundel.z.abs() - 0.022).min((disc.abs()).hypot(roundel.z - 0.02) - 0.006);
    dentil.min(pearl).min(disc)
}
