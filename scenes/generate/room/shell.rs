//! Floor, walls, ceiling, window and mouldings.

use super::super::shapes::{at, block, panel};
use super::set::Set;
use glam::{Vec3, vec3};

/// The room's inner faces: least and greatest x, y, z.
pub const LOW: Vec3 = vec3(-2.7, 0.0, -2.2);
/// See [`LOW`].
pub const HIGH: Vec3 = vec3(2.7, 2.7, 2.9);
/// The window in the wall of least x: its middle, and half its width and height.
pub const WINDOW: (Vec3, f32, f32) = (vec3(-2.7, 1.55, -0.35), 0.85, 0.72);

/// The whole shell.
pub fn build() -> Set {
    let mut set = Set::default();
    let (middle, half) = (0.5 * (LOW + HIGH), 0.5 * (HIGH - LOW));
    let mut face = |material, out: Vec3, u: Vec3, v: Vec3, tile: f32| {
        let mut wall = panel(middle - out * half, u * half, v * half);
        let size = 2.0 * glam::vec2(half.dot(u.abs()), half.dot(v.abs())) / tile;
        wall.uvs.iter_mut().for_each(|uv| *uv *= size);
        set.add(material, &wall);
    };
    face("parquet", Vec3::Y, Vec3::X, -Vec3::Z, 1.6);
    face("ceiling", -Vec3::Y, Vec3::X, Vec3::Z, 1.0);
    face("wallpaper", Vec3::Z, Vec3::X, Vec3::Y, 0.45);
    face("plaster", -Vec3::Z, -Vec3::X, Vec3::Y, 1.0);
    face("plaster", -Vec3::X, Vec3::Z, Vec3::Y, 1.0);
    window_wall(&mut set);
    window(&mut set);
    mouldings(&mut set);
    set
}

/// The wall around the window, and the reveal.
fn window_wall(set: &mut Set) {
    let (at, w, h) = WINDOW;
    let mut piece = |y: (f32, f32), z: (f32, f32)| {
        let centre = vec3(LOW.x, 0.5 * (y.0 + y.1), 0.5 * (z.0 + z.1));
        set.add("plaster", &panel(centre, Vec3::NEG_Z * 0.5 * (z.1 - z.0), Vec3::Y * 0.5 * (y.1 - y.0)));
    };
    let (left, right) = (at.z - w, at.z + w);
    piece((LOW.y, HIGH.y), (LOW.z, left));
    piece((LOW.y, HIGH.y), (right, HIGH.z));
    piece((LOW.y, at.y - h), (left, right));
    piece((at.y + h, HIGH.y), (left, right));
    let reveal = vec3(LOW.x - 0.1, at.y, at.z);
    let deep = Vec3::X * 0.1;
    set.add("paint", &panel(reveal - Vec3::Y * h, Vec3::Z * w, deep));
    set.add("paint", &panel(reveal + Vec3::Y * h, deep, Vec3::Z * w));
    set.add("paint", &panel(reveal - Vec3::Z * w, deep, Vec3::Y * h));
    set.add("paint", &panel(reveal + Vec3::Z * w, Vec3::Y * h, deep));
    // The evening outside.
    set.add("dusk", &panel(reveal - 1.5 * deep, Vec3::NEG_Z * w, Vec3::Y * h));
}

/// Frame, bars, sill and panes.
fn window(set: &mut Set) {
    let (middle, w, h) = WINDOW;
    let x = middle.x - 0.06;
    let mut bar = |y: f32, z: f32, half_y: f32, half_z: f32| {
        set.place("paint", &block(vec3(0.025, half_y, half_z), 0.006, 1), at(x, middle.y + y, middle.z + z));
    };
    bar(0.0, -w + 0.03, h, 0.03);
    bar(0.0, w - 0.03, h, 0.03);
    bar(0.0, 0.0, h, 0.025);
    bar(h - 0.03, 0.0, 0.03, w);
    bar(-h + 0.03, 0.0, 0.03, w);
    bar(0.22, 0.0, 0.015, w);
    let sill = block(vec3(0.13, 0.02, w + 0.06), 0.008, 2);
    set.place("paint", &sill, at(middle.x + 0.03, middle.y - h - 0.02, middle.z));
    for side in [-0.5, 0.5] {
        let pane = block(vec3(0.003, h - 0.04, 0.5 * w - 0.02), 0.001, 1);
        set.place("glass", &pane, at(x, middle.y, middle.z + side * w));
    }
}

/// Skirting board and cornice along the walls that are in view.
fn mouldings(set: &mut Set) {
    let (middle, half) = (0.5 * (LOW + HIGH), 0.5 * (HIGH - LOW));
    for (y, height, depth) in
        [(0.055, 0.055, 0.012), (HIGH.y - 0.03, 0.03, 0.05), (HIGH.y - 0.075, 0.015, 0.03)]
    {
        let back = block(vec3(half.x, height, depth), 0.006, 2);
        set.place("paint", &back, at(middle.x, y, LOW.z + depth));
        let side = block(vec3(depth, height, half.z), 0.006, 2);
        set.place("paint", &side, at(LOW.x + depth, y, middle.z));
        set.place("paint", &side, at(HIGH.x - depth, y, middle.z));
    }
}
