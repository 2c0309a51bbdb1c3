//! Curtains and the carpet, whose pile is made of single blades.

use super::super::mesh::Mesh;
use super::super::noise::{between, value};
use super::super::shapes::{add_sheet, at, block, sheet, tube};
use super::set::Set;
use super::shell::WINDOW;
use glam::{Vec3, vec2, vec3};
use std::f32::consts::TAU;

/// The middle of the carpet, and half its width and depth.
const CARPET: (Vec3, f32, f32) = (vec3(-0.55, 0.0, -0.15), 1.35, 0.95);

/// Carpet and curtains; `detail` 1 is as meant.
pub fn build(detail: f32) -> Set {
    let mut set = Set::default();
    let (middle, half_x, half_z) = CARPET;
    let base = block(vec3(half_x, 0.004, half_z), 0.002, 1);
    set.place("linen", &base, at(middle.x, 0.004, middle.z));
    set.add("carpet", &pile(detail));
    let rod_y = WINDOW.0.y + WINDOW.2 + 0.16;
    let (x, z) = (WINDOW.0.x + 0.10, WINDOW.0.z);
    let ends = [-1.0, 1.0].map(|side| (vec3(x, rod_y, z + side * 1.42), 0.012));
    set.add("brass", &tube(&ends, 24));
    for side in [-1.0, 1.0] {
        set.add("curtain", &curtain(vec3(x, rod_y, z + side * 1.08), side, detail));
    }
    set
}

/// A curtain of deep folds that hangs from the rod and is gathered at half its height.
fn curtain(top: Vec3, side: f32, detail: f32) -> Mesh {
    const HALF: f32 = 0.36;
    let drop = top.y - 0.015;
    let count = |n: f32| (n * detail).ceil() as usize;
    sheet(count(220.0), count(90.0), |u, v| {
        let fall = 1.0 - v;
        let gather = 1.0 - 0.42 * (-((fall - 0.58) / 0.20).powi(2)).exp();
        let wander = 0.25 * value(vec3(5.0 * u, 2.0 * fall, side));
        let fold = (TAU * (7.5 * u + 0.4 * wander)).sin();
        let depth = (0.028 + 0.022 * fall) * (0.35 + 0.65 * gather);
        let z = top.z + side * (HALF * (2.0 * u - 1.0) * gather + HALF * (1.0 - gather) * 0.9);
        vec3(top.x + depth * fold + 0.012 * wander, top.y - drop * fall, z)
    })
}

/// Blades that stand on the carpet and lean, coloured by where they stand.
fn pile(detail: f32) -> Mesh {
    let (middle, half_x, half_z) = CARPET;
    let pitch = 0.0125 / detail;
    let (columns, rows) = ((2.0 * half_x / pitch) as u32, (2.0 * half_z / pitch) as u32);
    let mut mesh = Mesh::default();
    for j in 0..rows {
        for i in 0..columns {
            let key = 4 * (j * columns + i);
            let (x, z) = (i as f32 + between(key, 0.1, 0.9), j as f32 + between(key + 1, 0.1, 0.9));
            let (u, v) = (x / columns as f32, z / rows as f32);
            let foot = middle + vec3(half_x * (2.0 * u - 1.0), 0.006, half_z * (2.0 * v - 1.0));
            let comb = 1.6 * value(foot * 3.0) + between(key + 2, -1.1, 1.1);
            let lean = vec3(comb.sin(), 0.0, comb.cos()) * between(key + 3, 0.004, 0.012);
            add_blade(&mut mesh, foot, lean, between(key + 1, 0.012, 0.020), pitch, vec2(u, 1.0 - v));
        }
    }
    mesh
}

/// A blade of two quads that bends towards its tip and shows its upper side.
fn add_blade(mesh: &mut Mesh, foot: Vec3, lean: Vec3, height: f32, width: f32, uv: glam::Vec2) {
    let across = lean.cross(Vec3::Y).normalize_or(Vec3::X) * 0.32 * width;
    let normal = (Vec3::Y - lean.normalize_or_zero()).normalize();
    add_sheet(mesh, 2, 3, |i, j| {
        let t = 0.5 * j as f32;
        let side = (2.0 * i as f32 - 1.0) * (1.0 - 0.7 * t);
        (foot + Vec3::Y * height * t * (1.0 - 0.2 * t) + lean * t * t + across * side, normal, uv)
    });
}
