//! A tall plant with broad leaves, and a hanging one.

use super::super::mesh::Mesh;
use super::super::noise::between;
use super::super::shapes::{at, sheet, tube};
use super::lamps::turned;
use super::set::Set;
use glam::{Affine3A, Quat, Vec3, vec3};
use std::f32::consts::{PI, TAU};

/// A fig tree in a pot, on the floor at the origin.
pub fn fig() -> Set {
    let mut set = Set::default();
    set.add("terracotta", &pot(0.17, 0.30));
    set.place("earth", &super::super::shapes::drum(0.145, 0.0, 0.01, 48), at(0.0, 0.262, 0.0));
    for stem in 0..4u32 {
        let turn = TAU * (stem as f32 + between(stem, 0.0, 0.5)) / 4.0;
        let out = vec3(turn.sin(), 0.0, turn.cos());
        let height = between(stem + 10, 1.0, 1.6);
        let at_height = |t: f32| out * (0.04 + 0.20 * t * t) + Vec3::Y * (0.26 + height * t);
        let path: Vec<_> =
            (0..=12).map(|i| i as f32 / 12.0).map(|t| (at_height(t), 0.013 * (1.0 - 0.6 * t))).collect();
        set.add("bark", &tube(&path, 12));
        for leaf in 0..14u32 {
            let key = 100 * stem + leaf + 40;
            let t = 0.30 + 0.70 * leaf as f32 / 13.0;
            let heading = 2.4 * leaf as f32 + between(key, -0.3, 0.3);
            let size = between(key + 500, 0.17, 0.25) * (1.1 - 0.35 * t);
            add_leaf(&mut set, at_height(t), heading, between(key + 900, 0.15, 0.7), size);
        }
    }
    set
}

/// A leaf on a short stalk that grows from `foot` towards `heading`, drooping by `droop`.
fn add_leaf(set: &mut Set, foot: Vec3, heading: f32, droop: f32, size: f32) {
    let turn = Quat::from_rotation_y(heading) * Quat::from_rotation_x(droop - 0.45);
    let place = Affine3A::from_rotation_translation(turn, foot);
    set.place("leaf", &leaf(size), place);
    set.place("bark", &tube(&[(Vec3::ZERO, 0.003), (vec3(0.0, 0.0, 0.26 * size), 0.002)], 6), place);
}

/// A leaf in the xz plane along +z: waved rim, raised midrib, arched.
fn leaf(size: f32) -> Mesh {
    sheet(10, 16, |u, v| {
        let s = 1.0 - 2.0 * u;
        let t = v.clamp(0.0, 1.0);
        let width = 0.36 * (PI * t.powf(0.75)).sin().max(0.0).powf(0.8) * (1.0 + 0.35 * t) + 0.02;
        let wave = 0.03 * (5.0 * PI * t).sin() * s * s;
        let veins = 0.008 * (16.0 * t - 5.0 * s.abs()).sin() * s.abs();
        let y = -0.42 * t * t + 0.10 * s.abs() + wave + veins;
        size * vec3(width * s, y, 0.25 + v)
    })
}

/// A trailing plant, its pot at the origin.
pub fn trailing() -> Set {
    let mut set = Set::default();
    set.add("porcelain", &pot(0.08, 0.13));
    for vine in 0..16u32 {
        let turn = TAU * (vine as f32 + between(vine + 7, 0.0, 0.8)) / 16.0;
        let out = vec3(turn.sin(), 0.0, 0.35 + 0.65 * turn.cos());
        let length = between(vine + 70, 0.2, 0.6);
        let at_length = |t: f32| {
            let over = (t * 3.0).min(1.0);
            out * (0.13 * over) + Vec3::Y * (0.12 + 0.07 * (PI * over).sin() - length * (t - 0.2).max(0.0))
        };
        let path: Vec<_> = (0..=14).map(|i| (at_length(i as f32 / 14.0), 0.0016)).collect();
        set.add("bark", &tube(&path, 6));
        for i in 0..12u32 {
            let key = 50 * vine + i + 3000;
            let t = 0.12 + 0.88 * i as f32 / 11.0;
            add_leaf(
                &mut set,
                at_length(t),
                between(key, 0.0, TAU),
                between(key + 800, 0.3, 1.2),
                between(key + 1600, 0.04, 0.065),
            );
        }
    }
    set
}

fn pot(radius: f32, height: f32) -> Mesh {
    let (r, h) = (radius, height);
    turned(
        &[
            (0.0, 0.0),
            (0.72 * r, 0.0),
            (0.74 * r, 0.02 * h),
            (0.95 * r, 0.85 * h),
            (1.05 * r, 0.86 * h),
            (1.05 * r, h),
            (0.92 * r, h),
            (0.88 * r, 0.8 * h),
            (0.0, 0.78 * h),
        ],
        64,
    )
}
