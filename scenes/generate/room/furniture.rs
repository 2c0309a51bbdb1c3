//! Tables, chairs, pouf, pictures and the mirror.

use super::super::mesh::Mesh;
use super::super::shapes::{at, block, drum, lathe, panel, tube, turned_at};
use super::set::Set;
use super::shell::LOW;
use glam::{Affine3A, Quat, Vec3, vec3};
use std::f32::consts::{FRAC_PI_2, PI};

/// Height of the dining table, the coffee table and the side table.
pub const HEIGHTS: [f32; 3] = [0.75, 0.42, 0.55];
/// Where they stand.
pub const PLACES: [Vec3; 3] = [vec3(1.72, 0.0, 0.05), vec3(-0.55, 0.0, -0.30), vec3(-1.98, 0.0, -1.68)];

/// All of it.
pub fn build() -> Set {
    let mut set = Set::default();
    let [dining, coffee, side] = PLACES;
    set.place_all(&pedestal_table(HEIGHTS[0], 0.50), at(dining.x, 0.0, dining.z));
    set.place_all(&coffee_table(), at(coffee.x, 0.0, coffee.z));
    set.place_all(&pedestal_table(HEIGHTS[2], 0.25), at(side.x, 0.0, side.z));
    set.place_all(&chair(), turned_at(35.0, 1.12, 0.0, -0.42));
    set.place_all(&chair(), turned_at(-62.0, 2.32, 0.0, -0.32));
    set.place("knit", &pouf(), at(-1.62, 0.0, 0.75));
    set.place_all(&picture("canvas1", 0.62, 0.40), at(-0.45, 1.72, LOW.z + 0.02));
    set.place_all(&mirror(), at(-1.58, 1.66, LOW.z + 0.02));
    set
}

/// A round table on a turned column.
fn pedestal_table(height: f32, radius: f32) -> Set {
    let mut set = Set::default();
    let top = height - 0.03;
    set.add("walnut", &drum(radius, top, height, 96));
    let column = [
        (0.0, 0.0),
        (0.62 * radius, 0.0),
        (0.62 * radius, 0.015),
        (0.5 * radius, 0.03),
        (0.16 * radius, 0.06),
        (0.045, 0.12),
        (0.035, 0.2 * height),
        (0.055, 0.4 * height),
        (0.03, 0.5 * height),
        (0.03, 0.85 * height),
        (0.08, top - 0.01),
        (0.08, top),
        (0.0, top),
    ];
    set.add("walnut", &lathe(&column, 48));
    set
}

/// A rounded top on four splayed legs, with a shelf below.
fn coffee_table() -> Set {
    let mut set = Set::default();
    let height = HEIGHTS[1];
    set.place("walnut", &block(vec3(0.58, 0.018, 0.31), 0.014, 3), at(0.0, height - 0.018, 0.0));
    set.place("walnut", &block(vec3(0.46, 0.01, 0.22), 0.006, 2), at(0.0, 0.16, 0.0));
    for (x, z) in corners(0.46, 0.22) {
        let foot = vec3(1.12 * x, 0.0, 1.15 * z);
        set.add("brass", &tube(&[(foot, 0.012), (vec3(x, height - 0.02, z), 0.02)], 20));
    }
    set
}

/// A chair that looks along +z.
fn chair() -> Set {
    let mut set = Set::default();
    set.place("walnut", &block(vec3(0.21, 0.018, 0.20), 0.014, 3), at(0.0, 0.45, 0.0));
    set.place("linen", &block(vec3(0.195, 0.022, 0.185), 0.02, 4), at(0.0, 0.485, 0.0));
    for (x, z) in corners(0.175, 0.165) {
        let foot = (vec3(1.15 * x, 0.0, 1.2 * z), 0.011);
        let top = if z < 0.0 { (vec3(1.03 * x, 0.92, -0.225), 0.013) } else { (vec3(x, 0.44, z), 0.017) };
        set.add("walnut", &tube(&[foot, (vec3(x, 0.44, z), 0.018), top][..if z < 0.0 { 3 } else { 2 }], 16));
    }
    for y in [0.62, 0.74, 0.87] {
        let bend = |t: f32| {
            vec3(0.18 * t, y + 0.01 * (1.0 - t * t), -0.19 - 0.05 * (y - 0.5) - 0.045 * (1.0 - t * t))
        };
        let rail: Vec<_> = (0..=16).map(|i| (bend(i as f32 / 8.0 - 1.0), 0.011)).collect();
        set.add("walnut", &tube(&rail, 12));
    }
    for (x, z) in [(0.0, 0.165), (0.175, 0.0)] {
        let (a, b) = if x == 0.0 {
            (vec3(-0.18, 0.2, z), vec3(0.18, 0.2, z))
        } else {
            (vec3(x, 0.24, -0.17), vec3(x, 0.24, 0.17))
        };
        set.add("walnut", &tube(&[(a, 0.008), (b, 0.008)], 12));
        let flip = vec3(if x == 0.0 { 1.0 } else { -1.0 }, 1.0, if x == 0.0 { -1.0 } else { 1.0 });
        set.add("walnut", &tube(&[(a * flip, 0.008), (b * flip, 0.008)], 12));
    }
    set
}

fn corners(x: f32, z: f32) -> [(f32, f32); 4] {
    [(x, z), (-x, z), (x, -z), (-x, -z)]
}

/// A knitted pouf: a squashed ball with plaits that wind about it.
fn pouf() -> Mesh {
    const STRANDS: f32 = 26.0;
    super::super::shapes::sheet(400, 70, |u, v| {
        let (turn, height) = (2.0 * PI * u, (v - 0.5) * PI * 0.94);
        let plait = (STRANDS * PI * (u + 0.06 * v)).sin().abs();
        let knots = (60.0 * v + 3.0 * plait * plait).sin().abs();
        let radius = 0.29 * height.cos().abs().powf(0.55) + 0.016 * (plait + 0.35 * knots * plait);
        vec3(radius * turn.sin(), 0.19 + 0.17 * height.sin(), radius * turn.cos())
    })
}

/// A framed canvas that hangs on the back wall.
fn picture(canvas: &'static str, half_width: f32, half_height: f32) -> Set {
    let mut set = Set::default();
    set.add(canvas, &panel(Vec3::Z * 0.008, Vec3::X * half_width, Vec3::Y * half_height));
    let rim = 0.03;
    for side in [-1.0, 1.0] {
        let across = block(vec3(half_width + rim, 0.5 * rim, 0.02), 0.008, 3);
        set.place("brass", &across, at(0.0, side * (half_height + 0.5 * rim), 0.0));
        let up = block(vec3(0.5 * rim, half_height + rim, 0.02), 0.008, 3);
        set.place("brass", &up, at(side * (half_width + 0.5 * rim), 0.0, 0.0));
    }
    set
}

/// A round mirror in a brass ring.
fn mirror() -> Set {
    let mut set = Set::default();
    let upright = Affine3A::from_quat(Quat::from_rotation_x(FRAC_PI_2));
    set.place("mirror", &drum(0.30, 0.0, 0.012, 96), upright);
    let ring: Vec<_> = (0..=24)
        .map(|i| {
            let angle = 2.0 * PI * i as f32 / 24.0;
            (0.31 + 0.022 * angle.sin(), 0.006 - 0.022 * angle.cos())
        })
        .collect();
    set.place("brass", &lathe(&ring, 96), upright);
    set
}
