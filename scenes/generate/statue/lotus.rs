//! The lotus throne: two wreaths of petals, one opening upwards, one downwards, on an oval plan.

use super::super::sdf::{both, disc, join, pointed_oval, sphere};
use glam::{Vec2, Vec3, vec3};
use std::f32::consts::TAU;

/// Depth of the throne over its width.
const OVAL: f32 = 0.80;
const PETALS: f32 = 20.0;
const PEARLS: f32 = 64.0;

/// The throne under a seat at the origin.
pub fn solid(p: Vec3) -> f32 {
    let q = vec3(p.x, p.y, p.z / OVAL);
    let near = (q.x.hypot(q.z) - 0.66).max((p.y + 0.15).abs() - 0.21);
    if near > 0.08 {
        return near * OVAL;
    }
    let seat = disc(q, vec3(0.0, -0.02, 0.0), 0.555, 0.022, 0.012);
    let core = disc(q, vec3(0.0, -0.155, 0.0), 0.49, 0.15, 0.03);
    let angle = q.x.atan2(q.z);
    let wreaths = wreath(q, angle, -0.045, 1.0).min(wreath(q, angle + 0.5 * TAU / PETALS, -0.27, -1.0));
    let pearls = sphere(around(q, angle, PEARLS), vec3(0.0, -0.158, 0.525), 0.0205);
    let throne = join(join(seat, core, 0.02), wreaths, 0.01).min(pearls);
    throne * OVAL
}

/// `q` turned about the axis into the sector of the nearest of `count` copies, which lies along +z.
fn around(q: Vec3, angle: f32, count: f32) -> Vec3 {
    let sector = TAU / count;
    let local = angle - (angle / sector).round() * sector;
    let radius = q.x.hypot(q.z);
    vec3(radius * local.sin(), q.y, radius * local.cos())
}

/// Petals whose tips are at height `tip`, upwards (`up` = 1) or downwards (−1), and a second row between them.
fn wreath(q: Vec3, angle: f32, tip: f32, up: f32) -> f32 {
    let front = petal(around(q, angle, PETALS), tip, up, 0.0);
    let back = petal(around(q, angle + 0.5 * TAU / PETALS, PETALS), tip + 0.012 * up, up, -0.022);
    front.min(back)
}

/// One petal: a pointed oval bent outwards at its tip, with a rim and a raised heart.
fn petal(q: Vec3, tip: f32, up: f32, inset: f32) -> f32 {
    let below = (tip - q.y) * up;
    let outline = pointed_oval(Vec2::new(q.x, below - 0.115), 0.086, 0.118);
    let belly = 0.535
        + inset
        + 0.045 * (1.0 - ((below - 0.055) / 0.075).powi(2))
        + 0.05 * (0.03 - below).max(0.0) / 0.03;
    let rim = 0.008 * (1.0 - ((outline + 0.010).abs() / 0.010).min(1.0));
    let heart = 0.016 * (-outline - 0.026).clamp(0.0, 0.02) / 0.02;
    let vein = 0.006 * (1.0 - (q.x.abs() / 0.006).min(1.0)) * (-outline - 0.03).clamp(0.0, 0.01) / 0.01;
    let round = 0.9 * q.x * q.x / 0.09;
    let front = q.z - (belly - round) - rim - heart + vein;
    let back = belly - round - 0.07 - q.z;
    both(outline, 0.8 * front.max(back), 0.012)
}
