//! The body under the robe: a torso, arms and crossed legs of rods and ellipsoids that flow into each other.

use super::super::sdf::{chain, ellipsoid, join, mirrored, rod, sphere};
use glam::{Vec3, vec3};

/// Chest, waist, hips, shoulders.
pub fn torso(p: Vec3) -> f32 {
    let hips = ellipsoid(p, vec3(0.0, 0.12, -0.04), vec3(0.225, 0.15, 0.17));
    let waist = ellipsoid(p, vec3(0.0, 0.28, -0.02), vec3(0.155, 0.20, 0.12));
    let chest = ellipsoid(p, vec3(0.0, 0.47, -0.03), vec3(0.20, 0.165, 0.125));
    let m = mirrored(p);
    let breast = ellipsoid(m, vec3(0.085, 0.485, 0.04), vec3(0.085, 0.065, 0.055));
    let shoulder = rod(m, (vec3(0.05, 0.625, -0.03), 0.055), (vec3(0.215, 0.565, -0.03), 0.08));
    let trunk = join(join(hips, waist, 0.12), chest, 0.12);
    join(join(trunk, breast, 0.05), shoulder, 0.09)
}

/// The arm on the side where x is positive, from the shoulder to the wrist.
pub fn arm(p: Vec3) -> f32 {
    let (shoulder, elbow, wrist) =
        (vec3(0.235, 0.555, -0.03), vec3(0.315, 0.275, 0.01), vec3(0.10, 0.165, 0.225));
    let upper = rod(p, (shoulder, 0.074), (elbow, 0.056));
    let fore = rod(p, (elbow, 0.056), (wrist, 0.035));
    join(upper, fore, 0.03)
}

/// The neck with its three lines of beauty.
fn neck(p: Vec3) -> f32 {
    let lines = 0.004 * (1.0 - super::super::sdf::ridges(p.y / 0.026 + 0.3 * p.z / 0.06));
    rod(p, (vec3(0.0, 0.58, -0.03), 0.075), (vec3(0.0, 0.76, -0.005), 0.058)) + lines
}

/// What the robe leaves bare, and what it covers where it is thin.
pub fn bare(p: Vec3) -> f32 {
    let right = vec3(-p.x, p.y, p.z);
    join(join(torso(p), neck(p), 0.06), arm(right), 0.03)
}

/// Crossed legs and the lap between them.
pub fn legs(p: Vec3) -> f32 {
    let m = mirrored(p);
    let (hip, knee) = (vec3(0.13, 0.11, -0.02), vec3(0.455, 0.085, 0.17));
    let thigh = rod(m, (hip, 0.125), (knee, 0.09));
    let lift = 0.015 * p.x.signum();
    let shin = rod(m, (knee, 0.086), (vec3(0.02, 0.075 + lift, 0.335), 0.058));
    let lap = ellipsoid(p, vec3(0.0, 0.06, 0.14), vec3(0.34, 0.085, 0.20));
    join(join(thigh, shin, 0.04), lap, 0.05)
}

/// The hands in the lap, one in the other, thumbs touching, and the foot that shows beside them.
pub fn hands_and_foot(p: Vec3) -> f32 {
    let near = sphere(p, vec3(0.05, 0.18, 0.27), 0.26);
    if near > 0.1 {
        return near;
    }
    let lower = hand(p, 1.0, 0.160);
    let upper = hand(vec3(-p.x, p.y, p.z), 1.0, 0.193);
    lower.min(upper).min(foot(p))
}

/// A hand whose wrist is on the side where x is positive, palm upwards at height `y`.
fn hand(p: Vec3, reach: f32, y: f32) -> f32 {
    let palm = ellipsoid(p, vec3(0.045, y, 0.255), vec3(0.075, 0.022, 0.055));
    let wrist = rod(p, (vec3(0.13, 0.165, 0.215), 0.034), (vec3(0.07, y, 0.245), 0.026));
    let finger = |i: f32| {
        let z = 0.218 + 0.0255 * i;
        let tip = -0.095 + 0.012 * (i - 1.4).abs();
        let points = [
            (vec3(0.02, y, z), 0.0145),
            (vec3(-0.045, y - 0.008, z + 0.004), 0.013),
            (vec3(tip * reach, y + 0.002, z + 0.002), 0.0105),
        ];
        chain(p, &points)
    };
    let fingers = (0..4).map(|i| finger(i as f32)).fold(f32::INFINITY, f32::min);
    let thumb = [
        (vec3(0.075, y + 0.01, 0.275), 0.018),
        (vec3(0.045, 0.232, 0.285), 0.0145),
        (vec3(0.008, 0.240, 0.288), 0.0115),
    ];
    join(join(join(palm, wrist, 0.03), fingers, 0.010), chain(p, &thumb), 0.014)
}

/// The sole of the foot that lies on the other shin, and its toes.
fn foot(p: Vec3) -> f32 {
    let q = super::super::sdf::turned(p, vec3(0.215, 0.165, 0.275), vec3(28.0, 24.0, -10.0));
    let sole = rod(q, (vec3(-0.06, 0.0, 0.0), 0.034), (vec3(0.055, 0.0, 0.0), 0.040));
    let toe = |i: f32| {
        let (z, x) = (-0.036 + 0.0185 * i, 0.105 - 0.006 * (i - 0.6).abs() * i);
        rod(q, (vec3(0.06, 0.005, 0.9 * z), 0.013), (vec3(x, 0.008, z), 0.0115 - 0.0006 * i))
    };
    join(sole, (0..5).map(|i| toe(i as f32)).fold(f32::INFINITY, f32::min), 0.012)
}
