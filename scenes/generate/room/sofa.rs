//! The sofa and its pillows: soft solids, polygonised.

use super::super::mesh::Mesh;
use super::super::sdf::{ridges, slab};
use super::super::shapes::{at, drum, with_box_uv};
use super::super::{noise, polygonise};
use super::set::Set;
use glam::{Affine3A, EulerRot, Quat, Vec3, vec3};

/// Half its width.
const HALF: f32 = 1.05;

/// A sofa that looks along +z, on the floor at the origin; cells of side `step`.
pub fn build(step: f32) -> Set {
    let mut set = Set::default();
    let fabric = |half: Vec3, round: f32, bulge: f32, seed: f32| {
        with_box_uv(&cushion(half, round, bulge, seed, step), 6.0)
    };
    let mut add = |mesh: &Mesh, x: f32, y: f32, z: f32| set.place("sofa", mesh, at(x, y, z));
    add(&fabric(vec3(HALF, 0.10, 0.42), 0.03, 0.0, 0.0), 0.0, 0.22, 0.0);
    add(&fabric(vec3(HALF, 0.30, 0.11), 0.08, 0.0, 5.0), 0.0, 0.52, -0.33);
    for (side, seed) in [(-1.0, 11.0), (1.0, 12.0)] {
        add(&fabric(vec3(0.10, 0.25, 0.42), 0.08, 0.01, seed), side * (HALF - 0.02), 0.37, 0.0);
    }
    for (i, seed) in [(-1.0, 1.0), (0.0, 2.0), (1.0, 3.0)] {
        add(&fabric(vec3(0.305, 0.085, 0.34), 0.05, 0.03, seed), 0.615 * i, 0.385, 0.07);
        add(&fabric(vec3(0.30, 0.20, 0.085), 0.06, 0.035, seed + 6.0), 0.615 * i, 0.655, -0.17);
    }
    for (x, z) in [(-0.95, -0.34), (0.95, -0.34), (-0.95, 0.34), (0.95, 0.34)] {
        set.place("walnut", &drum(0.025, 0.0, 0.12, 24), at(x, 0.0, z));
    }
    for (material, x, turn, seed) in
        [("mustard", -0.80, 0.35, 21.0), ("terracotta", -0.52, -0.12, 22.0), ("linen", 0.78, -0.3, 23.0)]
    {
        let pillow = cushion(vec3(0.22, 0.20, 0.055), 0.035, 0.065, seed, step);
        let lean = Quat::from_euler(EulerRot::YXZ, turn, -0.38, 0.12 * (seed - 22.0));
        set.place(
            material,
            &with_box_uv(&pillow, 6.0),
            Affine3A::from_rotation_translation(lean, vec3(x, 0.665, 0.045)),
        );
    }
    set
}

/// A rounded box whose large faces bulge, with piping along the edge and creases.
fn cushion(half: Vec3, round: f32, bulge: f32, seed: f32, step: f32) -> Mesh {
    let reach = half + bulge + 0.03;
    let field = |p: Vec3| {
        let t = (p / half).clamp(Vec3::NEG_ONE, Vec3::ONE);
        let full = (1.0 - t * t).max(Vec3::ZERO);
        // The shortest side bulges where the two others are in their middle.
        let thin = half.min_position();
        let swell = bulge * (full[(thin + 1) % 3] * full[(thin + 2) % 3]).sqrt();
        let crease = 0.006 * noise::fractal(p * 7.0 + seed, 2)
            + 0.004 * (ridges((p.x + p.y) * 5.0 + seed) - 0.6) * full[thin];
        slab(p, Vec3::ZERO, half + Vec3::AXES[thin] * swell, round) - crease
    };
    polygonise::surface(field, -reach, reach, step)
}
