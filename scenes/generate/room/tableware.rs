//! What stands on the tables: glasses, a bottle, a bowl of fruit, books, cups.

use super::super::noise;
use super::super::polygonise;
use super::super::sdf::sphere;
use super::super::shapes::{at, block, turned_at};
use super::lamps::turned;
use super::set::Set;
use super::shelf::vase;
use glam::{Affine3A, Vec3, vec3};

/// On the dining table, its top at the origin.
pub fn dining() -> Set {
    let mut set = Set::default();
    set.place_all(&glass(), at(-0.20, 0.0, 0.20));
    set.place_all(&glass(), at(0.22, 0.0, 0.13));
    set.place_all(&bottle(), at(0.10, 0.0, -0.17));
    set.place("porcelain", &plate(), at(-0.24, 0.0, -0.05));
    set.place("steel", &jug(), at(-0.05, 0.0, -0.28));
    set
}

/// On the coffee table.
pub fn coffee(step: f32) -> Set {
    let mut set = Set::default();
    set.place_all(&fruit_bowl(step), at(0.05, 0.0, -0.02));
    for (i, (material, turn)) in
        [("indigo", 8.0), ("terracotta", -5.0), ("mustard", 20.0)].into_iter().enumerate()
    {
        let y = 0.014 + 0.03 * i as f32;
        let half = vec3(0.13 - 0.012 * i as f32, 0.014, 0.095 - 0.008 * i as f32);
        set.place(material, &block(half, 0.003, 2), turned_at(turn, -0.36, y, 0.05));
        set.place(
            "paper",
            &block(half - vec3(-0.001, 0.003, 0.004), 0.001, 1),
            turned_at(turn, -0.36, y, 0.05),
        );
    }
    set.place("porcelain", &cup(), at(0.36, 0.0, 0.14));
    set.place("porcelain", &cup(), at(0.42, 0.0, -0.10));
    set
}

/// A tall vase for twigs, on the floor.
pub fn floor_vase() -> Set {
    let mut set = Set::default();
    set.add("celadon", &vase(0.15, 0.55, 0.4));
    set
}

/// A wine glass.
fn glass() -> Set {
    let mut set = Set::default();
    let profile = [
        (0.0, 0.0),
        (0.034, 0.0),
        (0.035, 0.002),
        (0.012, 0.006),
        (0.0045, 0.02),
        (0.0045, 0.075),
        (0.012, 0.088),
        (0.033, 0.110),
        (0.040, 0.140),
        (0.036, 0.175),
        (0.033, 0.190),
        (0.0315, 0.190),
        (0.0345, 0.173),
        (0.0385, 0.140),
        (0.0315, 0.112),
        (0.010, 0.092),
        (0.0, 0.092),
    ];
    set.add("glass", &turned(&profile, 64));
    set
}

/// A green bottle.
fn bottle() -> Set {
    let mut set = Set::default();
    let outer = [
        (0.0, 0.0),
        (0.036, 0.0),
        (0.038, 0.006),
        (0.038, 0.19),
        (0.034, 0.215),
        (0.015, 0.245),
        (0.0135, 0.30),
        (0.016, 0.302),
        (0.016, 0.312),
        (0.0125, 0.314),
    ];
    let inner =
        [(0.0105, 0.312), (0.0105, 0.245), (0.031, 0.213), (0.035, 0.19), (0.035, 0.012), (0.0, 0.012)];
    let profile: Vec<_> = outer.into_iter().chain(inner).collect();
    set.add("glass", &turned(&profile, 64));
    set
}

/// A glass bowl with oranges and apples.
fn fruit_bowl(step: f32) -> Set {
    let mut set = Set::default();
    let profile = [
        (0.0, 0.0),
        (0.055, 0.0),
        (0.06, 0.006),
        (0.095, 0.02),
        (0.14, 0.06),
        (0.158, 0.10),
        (0.157, 0.104),
        (0.153, 0.102),
        (0.134, 0.064),
        (0.09, 0.027),
        (0.04, 0.014),
        (0.0, 0.013),
    ];
    set.add("glass", &turned(&profile, 96));
    let fruits = [
        ("orange", -0.052, 0.060, 0.012),
        ("orange", 0.047, 0.060, 0.040),
        ("apple", 0.022, 0.060, -0.055),
        ("orange", 0.004, 0.125, -0.004),
        ("apple", 0.072, 0.098, -0.028),
    ];
    for (i, (material, x, y, z)) in fruits.into_iter().enumerate() {
        let fruit = |p: Vec3| {
            let dent = 0.012 * (-(p.x * p.x + p.z * p.z) / 0.0003).exp() * p.y.signum().max(0.0);
            let skin = if material == "orange" { 0.0006 * noise::value(p * 420.0) } else { 0.0 };
            0.9 * (sphere(p * vec3(1.0, 1.06, 1.0), Vec3::ZERO, 0.038) + dent + skin)
        };
        let mesh = polygonise::surface(fruit, Vec3::splat(-0.045), Vec3::splat(0.045), 0.20 * step);
        set.place(material, &mesh, Affine3A::from_rotation_z(0.3 * i as f32 - 0.5).with_translation(x, y, z));
    }
    set
}

trait WithTranslation {
    fn with_translation(self, x: f32, y: f32, z: f32) -> Self;
}

impl WithTranslation for Affine3A {
    fn with_translation(self, x: f32, y: f32, z: f32) -> Self {
        at(x, y, z) * self
    }
}

fn plate() -> super::super::mesh::Mesh {
    turned(
        &[
            (0.0, 0.0),
            (0.07, 0.0),
            (0.08, 0.006),
            (0.12, 0.018),
            (0.122, 0.020),
            (0.119, 0.021),
            (0.078, 0.011),
            (0.0, 0.008),
        ],
        72,
    )
}

fn jug() -> super::super::mesh::Mesh {
    turned(
        &[
            (0.0, 0.0),
            (0.05, 0.0),
            (0.056, 0.01),
            (0.062, 0.06),
            (0.045, 0.13),
            (0.035, 0.17),
            (0.042, 0.205),
            (0.039, 0.205),
            (0.032, 0.17),
            (0.042, 0.13),
            (0.057, 0.06),
            (0.048, 0.012),
            (0.0, 0.01),
        ],
        72,
    )
}

fn cup() -> super::super::mesh::Mesh {
    turned(
        &[
            (0.0, 0.0),
            (0.022, 0.0),
            (0.024, 0.004),
            (0.036, 0.03),
            (0.040, 0.062),
            (0.038, 0.063),
            (0.033, 0.03),
            (0.02, 0.008),
            (0.0, 0.007),
        ],
        56,
    )
}
