//! The head: a calm face with lowered lids, long ears, hair in snail curls, and a halo behind.

use super::super::sdf::{both, chain, cut, ellipsoid, join, mirrored, ridges, rod, sphere, step};
use glam::{Vec3, vec3};
use std::f32::consts::{PI, TAU};

/// The middle of the head, and metres to a unit of the coordinates used below.
const CENTRE: Vec3 = vec3(0.0, 0.862, 0.012);
const UNIT: f32 = 0.148;
/// Curls on a whole ball of hair, and on the knot on top.
const CURLS: (u32, u32) = (300, 90);

/// The head and the halo behind it.
pub fn solid(p: Vec3) -> f32 {
    let q = (p - CENTRE) / UNIT;
    let near = q.length() - 2.0;
    let halo = halo(p);
    if near > 1.0 {
        return halo.min(near * UNIT);
    }
    let head = join(face(q), ear(mirrored(q)), 0.06).min(hair(q));
    halo.min(head * UNIT)
}

fn face(q: Vec3) -> f32 {
    let m = mirrored(q);
    let skull = ellipsoid(q, vec3(0.0, 0.18, -0.06), vec3(0.77, 0.86, 0.86));
    let jaw = ellipsoid(q, vec3(0.0, -0.30, 0.20), vec3(0.615, 0.66, 0.58));
    let cheek = sphere(m, vec3(0.33, -0.24, 0.42), 0.30);
    let chin = sphere(q, vec3(0.0, -0.80, 0.53), 0.155);
    let shape = join(join(join(skull, jaw, 0.35), cheek, 0.25), chin, 0.22);
    let socket = ellipsoid(m, vec3(0.30, 0.04, 0.86), vec3(0.24, 0.12, 0.13));
    let shape = cut(shape, socket, 0.14);
    let lid = ellipsoid(m, vec3(0.295, -0.005, 0.60), vec3(0.20, 0.135, 0.205));
    let shape = join(shape, lid, 0.035);
    let brow = [
        (vec3(0.07, 0.07, 0.83), 0.035),
        (vec3(0.17, 0.20, 0.83), 0.042),
        (vec3(0.36, 0.24, 0.755), 0.038),
        (vec3(0.56, 0.10, 0.60), 0.02),
    ];
    let shape = join(shape, chain(m, &brow), 0.09);
    let shape = join(shape, nose(q, m), 0.08);
    let shape = join(shape, lips(q, m), 0.07);
    carve(shape, m)
}

fn nose(q: Vec3, m: Vec3) -> f32 {
    let bridge = rod(q, (vec3(0.0, 0.14, 0.80), 0.060), (vec3(0.0, -0.26, 0.945), 0.088));
    let wing = sphere(m, vec3(0.095, -0.295, 0.86), 0.068);
    join(bridge, wing, 0.06)
}

fn lips(q: Vec3, m: Vec3) -> f32 {
    let upper = [
        (vec3(0.0, -0.502, 0.772), 0.038),
        (vec3(0.065, -0.488, 0.768), 0.044),
        (vec3(0.25, -0.525, 0.645), 0.018),
    ];
    let lower = ellipsoid(q, vec3(0.0, -0.602, 0.722), vec3(0.165, 0.062, 0.080));
    join(chain(m, &upper), lower, 0.03)
}

/// Furrows: between the lids, between the lips, above the upper lip; and the mark on the forehead.
fn carve(shape: f32, m: Vec3) -> f32 {
    let lids = [
        (vec3(0.12, -0.050, 0.775), 0.010),
        (vec3(0.20, -0.080, 0.772), 0.020),
        (vec3(0.31, -0.088, 0.762), 0.024),
        (vec3(0.41, -0.068, 0.710), 0.020),
        (vec3(0.50, -0.025, 0.635), 0.010),
    ];
    let mouth = [
        (vec3(0.0, -0.552, 0.835), 0.012),
        (vec3(0.09, -0.544, 0.815), 0.013),
        (vec3(0.27, -0.522, 0.665), 0.010),
    ];
    let philtrum = rod(m, (vec3(0.0, -0.38, 0.87), 0.022), (vec3(0.0, -0.45, 0.85), 0.026));
    let furrows = chain(m, &lids).min(chain(m, &mouth));
    let shape = cut(cut(shape, furrows, 0.03), philtrum, 0.06);
    join(shape, sphere(m, vec3(0.0, 0.33, 0.795), 0.045), 0.015)
}

fn ear(m: Vec3) -> f32 {
    let shell = ellipsoid(m, vec3(0.80, 0.0, -0.02), vec3(0.075, 0.30, 0.17));
    let hollow = ellipsoid(m, vec3(0.89, 0.03, 0.02), vec3(0.07, 0.20, 0.095));
    let lobe = rod(m, (vec3(0.80, -0.22, 0.02), 0.085), (vec3(0.80, -0.70, 0.05), 0.07));
    let hole = ellipsoid(m, vec3(0.80, -0.56, 0.05), vec3(0.2, 0.13, 0.030));
    cut(cut(join(shell, lobe, 0.06), hollow, 0.04), hole, 0.02)
}

/// A cap of curls down to the hairline, and the knot on top with its jewel.
fn hair(q: Vec3) -> f32 {
    let (cap_at, cap) = (vec3(0.0, 0.22, -0.10), vec3(0.83, 0.90, 0.90));
    let line = q.y - (0.50 - 1.0 * step(0.55, -0.35, q.z) - 0.10 * q.x * q.x);
    let base = ellipsoid(q, cap_at, cap);
    if base > 0.8 {
        return base.min(ellipsoid(q, vec3(0.0, 1.1, -0.14), Vec3::splat(0.45)));
    }
    let curled = join(base, curls(q, base, cap_at, cap, CURLS.0, 0.100), 0.03);
    let covered = both(curled, -line, 0.06);
    let (knot_at, knot) = (vec3(0.0, 1.10, -0.14), vec3(0.42, 0.36, 0.42));
    let ball = ellipsoid(q, knot_at, knot);
    let bun = join(ball, curls(q, ball, knot_at, knot, CURLS.1, 0.098), 0.03);
    let jewel = ellipsoid(q, vec3(0.0, 1.50, -0.12), vec3(0.10, 0.15, 0.10));
    join(covered, bun, 0.04).min(jewel)
}

/// Snail curls in a spiral lattice over an ellipsoid at distance `base`: the distance to the nearest, with its coil
/// in relief; infinite where the ellipsoid is far.
fn curls(q: Vec3, base: f32, centre: Vec3, radii: Vec3, count: u32, size: f32) -> f32 {
    if base.abs() > 0.3 {
        return f32::INFINITY;
    }
    let nearest = (0..count)
        .map(|i| centre + radii * lattice(i, count))
        .min_by(|a, b| a.distance_squared(q).total_cmp(&b.distance_squared(q)));
    let Some(curl) = nearest else { return f32::INFINITY };
    let axis = ((curl - centre) / radii / radii).normalize();
    let offset = q - curl;
    let side = axis.any_orthonormal_vector();
    let angle = offset.dot(axis.cross(side)).atan2(offset.dot(side)) / TAU;
    let from_axis = (offset - axis * offset.dot(axis)).length();
    let coil = 0.022 * (1.0 - ridges(from_axis / 0.045 + angle));
    offset.length() - size + coil
}

/// Point `i` of `count` spread evenly over the unit ball's surface (Fibonacci lattice).
fn lattice(i: u32, count: u32) -> Vec3 {
    let y = 1.0 - (2.0 * i as f32 + 1.0) / count as f32;
    let turn = PI * (3.0 - 5f32.sqrt()) * i as f32;
    let radius = (1.0 - y * y).sqrt();
    vec3(radius * turn.cos(), y, radius * turn.sin())
}

/// A disc behind the head: rays, a ring of petals, a rim of pearls.
fn halo(p: Vec3) -> f32 {
    let q = p - vec3(0.0, 0.88, -0.155);
    let (radius, angle) = (q.x.hypot(q.y), q.x.atan2(q.y));
    let near = (radius - 0.33).max(q.z.abs() - 0.05);
    if near > 0.06 {
        return near;
    }
    let rays = 0.010 * ridges(32.0 * angle / TAU) * step(0.145, 0.16, radius) * step(0.232, 0.220, radius);
    let ring = |at: f32, width: f32| (1.0 - ((radius - at) / width).powi(2)).max(0.0).powi(2);
    let rings = 0.012 * ring(0.24, 0.018) + 0.014 * ring(0.300, 0.020);
    let disc = both(radius - 0.312, q.z.abs() - 0.020 - rays - rings, 0.01);
    let sector = TAU / 48.0;
    let around = (angle / sector).round() * sector;
    let pearl = sphere(q.with_z(q.z.abs()), vec3(0.271 * around.sin(), 0.271 * around.cos(), 0.018), 0.0155);
    let neck = rod(p, (vec3(0.0, 0.60, -0.13), 0.06), (vec3(0.0, 0.80, -0.155), 0.05));
    disc.min(pearl).min(neck)
}
