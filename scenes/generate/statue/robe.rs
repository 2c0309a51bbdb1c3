//! The robe: a skin over the body that leaves the right shoulder bare, with folds in relief and a thick hem.

use super::super::noise;
use super::super::sdf::{both, ellipsoid, join, ridges, sphere};
use super::body;
use glam::{Vec2, Vec3, vec3};
use std::f32::consts::TAU;

/// How far the cloth stands off the body.
const CLOTH: f32 = 0.010;

/// The whole robe.
pub fn solid(p: Vec3) -> f32 {
    let near = sphere(p, vec3(0.0, 0.25, 0.1), 0.75);
    if near > 0.15 {
        return near;
    }
    let cloth = join(join(upper(p), legs(p), 0.04), sleeve(p), 0.05);
    join(cloth, fan(p), 0.012)
}

/// Distance along the body from the hem that runs from the left side of the neck to the right hip; negative is cloth.
fn hem(p: Vec3) -> f32 {
    let n = Vec2::new(-0.80, 0.60);
    (Vec2::new(p.x, p.y) - Vec2::new(0.085, 0.66)).dot(n) + 0.55 * p.x * p.x - 0.02
}

/// The cloth over chest, back and left arm. Its folds follow the hem and sag towards the waist.
fn upper(p: Vec3) -> f32 {
    let body = join(body::torso(p), body::arm(p), 0.05);
    let line = hem(p);
    let sway = 0.010 * noise::value(p * 7.0);
    let over_arm = super::super::sdf::step(0.19, 0.27, p.x);
    let chest = ridges((line + sway) / 0.042);
    let arm = ridges((p.y + 0.45 * p.z + 0.3 * p.x + sway) / 0.040);
    let depth = 0.012 * (1.0 - over_arm) + 0.010 * over_arm;
    let folds = depth * (chest + over_arm * (arm - chest));
    let cloth = both(body - CLOTH - folds, line, 0.012);
    // The hem: a roll along the edge, thicker than the cloth.
    let band = 0.8 * (body - CLOTH - 0.006).hypot(0.7 * (line + 0.014)) - 0.012;
    join(cloth, band, 0.008)
}

/// The cloth over the legs: folds that sag from knee to knee.
fn legs(p: Vec3) -> f32 {
    let away = (0.55 * p.x).hypot(p.y + 0.8 * p.z - 0.95) + 0.014 * noise::value(p * 6.0 + 3.0);
    let fade = 1.0 - 0.7 * super::super::sdf::step(0.36, 0.50, p.x.abs());
    body::legs(p) - CLOTH - 0.012 * fade * ridges(away / 0.052)
}

/// Cloth that hangs from the left forearm.
fn sleeve(p: Vec3) -> f32 {
    let drop = ellipsoid(p, vec3(0.30, 0.185, 0.075), vec3(0.062, 0.165, 0.15));
    let folds = 0.010 * ridges((p.z + 0.35 * p.y + 0.008 * noise::value(p * 9.0)) / 0.038);
    drop - folds
}

/// The end of the robe, spread like a fan before the crossed shins.
fn fan(p: Vec3) -> f32 {
    let q = p - vec3(0.0, 0.03, 0.27);
    let (radius, angle) = (q.x.hypot(q.z), q.x.atan2(q.z));
    let scallop = 0.012 * (14.0 * angle).cos();
    let pleats = 0.010 * ridges(14.0 * angle / TAU + 0.5);
    let drape = 0.045 - 0.30 * (radius - 0.05).max(0.0);
    let sheet = (q.y - drape).abs() - 0.012 - pleats;
    let rim = radius - 0.205 - scallop;
    both(0.75 * sheet, rim, 0.02)
}
