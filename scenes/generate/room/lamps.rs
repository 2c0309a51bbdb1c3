//! Lamps, large and small. Their flux ranges over more than a thousand to one.

use super::super::mesh::Mesh;
use super::super::shapes::{at, ball, block, drum, lathe, panel, tube};
use super::set::Set;
use super::shell::{HIGH, LOW};
use glam::{Affine3A, Vec3, vec3};

/// A lamp shade open at both ends: its outside glows as cloth does before a bulb.
fn shade(set: &mut Set, glow: &'static str, low: (f32, f32), high: (f32, f32)) {
    const WALL: f32 = 0.002;
    let inside = [(high.0 - WALL, high.1), (low.0 - WALL, low.1)];
    set.add(glow, &lathe(&[low, high], 48));
    set.add("cloth", &lathe(&inside, 48));
    set.add("cloth", &lathe(&[inside[1], low], 48));
    set.add("cloth", &lathe(&[high, inside[0]], 48));
}

/// A floor lamp.
pub fn floor_lamp() -> Set {
    let mut set = Set::default();
    let foot = [
        (0.0, 0.0),
        (0.14, 0.0),
        (0.14, 0.012),
        (0.13, 0.02),
        (0.02, 0.032),
        (0.011, 0.06),
        (0.011, 1.42),
        (0.0, 1.42),
    ];
    set.add("brass", &lathe(&foot, 64));
    set.place("bulb-large", &ball(0.09, 16), at(0.0, 1.50, 0.0));
    shade(&mut set, "glow-large", (0.21, 1.36), (0.14, 1.64));
    set
}

/// A lamp for the side table: a glazed belly and a shade.
pub fn table_lamp() -> Set {
    let mut set = Set::default();
    let belly = [
        (0.0, 0.0),
        (0.06, 0.0),
        (0.065, 0.01),
        (0.05, 0.02),
        (0.075, 0.07),
        (0.09, 0.12),
        (0.08, 0.17),
        (0.045, 0.21),
        (0.018, 0.235),
        (0.015, 0.26),
        (0.0, 0.26),
    ];
    set.add("celadon", &lathe(&rounded(&belly), 64));
    set.add("brass", &drum(0.008, 0.25, 0.32, 16));
    set.place("bulb-medium", &ball(0.06, 16), at(0.0, 0.36, 0.0));
    shade(&mut set, "glow-medium", (0.15, 0.26), (0.10, 0.45));
    set
}

/// A copper bell that hangs from the ceiling; its bulb is at the origin.
pub fn pendant() -> Set {
    let mut set = Set::default();
    let arc = |r: f32, grow: f32| {
        (0..=20).map(move |i| {
            let angle = std::f32::consts::FRAC_PI_2 * i as f32 / 20.0;
            (r * angle.cos().max(0.05) + grow, 0.75 * r * angle.sin() - 0.03)
        })
    };
    let outer: Vec<_> = arc(0.17, 0.0).collect();
    let inner: Vec<_> = arc(0.167, 0.0).collect::<Vec<_>>().into_iter().rev().collect();
    set.add("copper", &lathe(&outer, 72));
    set.add("enamel", &lathe(&inner, 72));
    set.add("copper", &lathe(&[inner[inner.len() - 1], outer[0]], 72));
    set.add("black", &tube(&[(vec3(0.0, 0.09, 0.0), 0.004), (vec3(0.0, 1.2, 0.0), 0.004)], 10));
    set.add("bulb-pendant", &ball(0.075, 16));
    set
}

/// A candle on a brass foot; its flame shines.
fn candle(height: f32) -> Set {
    let mut set = Set::default();
    let foot =
        [(0.0, 0.0), (0.035, 0.0), (0.035, 0.004), (0.012, 0.01), (0.012, 0.03), (0.02, 0.034), (0.0, 0.034)];
    set.add("brass", &lathe(&foot, 40));
    set.add("wax", &drum(0.011, 0.034, height, 32));
    let flame = [(0.0, 0.0), (0.006, 0.006), (0.008, 0.014), (0.005, 0.030), (0.0, 0.044)];
    set.place("flame", &lathe(&flame, 6), at(0.0, height + 0.006, 0.0));
    set.add("black", &tube(&[(vec3(0.0, height, 0.0), 0.001), (vec3(0.0, height + 0.008, 0.0), 0.001)], 6));
    set
}

/// Three candles around the origin.
pub fn candles() -> Set {
    let mut set = Set::default();
    for (x, z, height) in [(0.0, 0.0, 0.24), (0.085, 0.04, 0.18), (-0.06, 0.075, 0.14)] {
        set.place_all(&candle(height), at(x, 0.0, z));
    }
    set
}

/// The panel in the ceiling, the picture light, light strips in the bookcase at `shelf`, and a standby light.
pub fn fixed(shelf: Affine3A) -> Set {
    let mut set = Set::default();
    let (x, z) = (-0.3, 0.5);
    set.place("paint", &block(vec3(0.62, 0.012, 0.32), 0.006, 2), at(x, HIGH.y - 0.012, z));
    set.add("ceiling-panel", &panel(vec3(x, HIGH.y - 0.026, z), Vec3::X * 0.58, Vec3::Z * 0.28));
    let picture = vec3(-0.45, 2.21, LOW.z + 0.14);
    let arm = [
        (picture + vec3(0.0, -0.04, -0.13), 0.006),
        (picture + vec3(0.0, 0.02, -0.07), 0.006),
        (picture, 0.006),
    ];
    set.add("brass", &tube(&arm, 12));
    set.add("brass", &tube(&[(picture - Vec3::X * 0.2, 0.015), (picture + Vec3::X * 0.2, 0.015)], 24));
    set.add("picture-light", &panel(picture - Vec3::Y * 0.017, Vec3::X * 0.19, Vec3::Z * 0.016));
    for y in [1.238, 1.628] {
        set.place("strip", &panel(vec3(0.0, y, 0.135), Vec3::X * 0.86, Vec3::Z * 0.006), shelf);
    }
    set.place("standby", &ball(0.004, 8), shelf * at(-0.8, 0.115, 0.165));
    set
}

/// A profile with its corners rounded by two rounds of corner cutting (Chaikin), ends kept.
fn rounded(profile: &[(f32, f32)]) -> Vec<(f32, f32)> {
    let cut = |points: Vec<(f32, f32)>| {
        let mut out = vec![points[0]];
        for w in points.windows(2) {
            let mix = |t: f32| (w[0].0 + t * (w[1].0 - w[0].0), w[0].1 + t * (w[1].1 - w[0].1));
            out.extend([mix(0.25), mix(0.75)]);
        }
        out.push(points[points.len() - 1]);
        out
    };
    cut(cut(profile.to_vec()))
}

/// A profile rounded as above, turned.
pub fn turned(profile: &[(f32, f32)], sides: usize) -> Mesh {
    lathe(&rounded(profile), sides)
}
