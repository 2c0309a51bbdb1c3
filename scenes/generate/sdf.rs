//! Solids as signed distances: negative inside, metres. Unions of them are lower bounds of the distance.
//!
//! The formulas are the common ones of implicit modelling (Hart 1996, *Sphere tracing*); the smooth minimum is the
//! quadratic one, which only acts where two solids are closer than its width.

use glam::{Quat, Vec2, Vec3};

/// A ball.
pub fn sphere(p: Vec3, centre: Vec3, radius: f32) -> f32 {
    p.distance(centre) - radius
}

/// An ellipsoid with its axes along x, y, z: first order in the distance.
pub fn ellipsoid(p: Vec3, centre: Vec3, radii: Vec3) -> f32 {
    let q = (p - centre) / radii;
    let (k0, k1) = (q.length(), (q / radii).length());
    if k1 < 1e-6 { -radii.min_element() } else { k0 * (k0 - 1.0) / k1 }
}

/// A rod from `a` to `b` whose radius runs linearly from `ra` to `rb`.
pub fn rod(p: Vec3, (a, ra): (Vec3, f32), (b, rb): (Vec3, f32)) -> f32 {
    let along = b - a;
    let t = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    p.distance(a + t * along) - (ra + t * (rb - ra))
}

/// Rods through points, each with its radius.
pub fn chain(p: Vec3, points: &[(Vec3, f32)]) -> f32 {
    points.windows(2).map(|w| rod(p, w[0], w[1])).fold(f32::INFINITY, f32::min)
}

/// A box of half sizes `half`, rounded by `round`.
pub fn slab(p: Vec3, centre: Vec3, half: Vec3, round: f32) -> f32 {
    let q = (p - centre).abs() - half + round;
    q.max(Vec3::ZERO).length() + q.max_element().min(0.0) - round
}

/// A disc of thickness `2·half` about the y axis through `centre`, rounded by `round`.
pub fn disc(p: Vec3, centre: Vec3, radius: f32, half: f32, round: f32) -> f32 {
    let q = p - centre;
    let d = Vec2::new(q.x.hypot(q.z) - radius, q.y.abs() - half) + round;
    d.max(Vec2::ZERO).length() + d.max_element().min(0.0) - round
}

/// A pointed oval in the plane: its tips at (0, ±`height`), its width 2·`width`.
pub fn pointed_oval(p: Vec2, width: f32, height: f32) -> f32 {
    // Two circles of radius r whose centres are ±d from the axis.
    let d = (height * height - width * width) / (2.0 * width);
    let q = p.abs();
    if (q.y - height) * d > q.x * height {
        q.distance(Vec2::new(0.0, height))
    } else {
        q.distance(Vec2::new(-d, 0.0)) - (width + d)
    }
}

/// Union with a fillet of width `k`.
pub fn join(a: f32, b: f32, k: f32) -> f32 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - 0.25 * h * h * k
}

/// What of `a` is not in `b`, the edge rounded by `k`.
pub fn cut(a: f32, b: f32, k: f32) -> f32 {
    -join(-a, b, k)
}

/// What is in both, the edge rounded by `k`.
pub fn both(a: f32, b: f32, k: f32) -> f32 {
    -join(-a, -b, k)
}

/// `p` mirrored to the side where x is positive.
pub fn mirrored(p: Vec3) -> Vec3 {
    Vec3::new(p.x.abs(), p.y, p.z)
}

/// `p` in a frame turned by `degrees` about the x, y and z axis through `centre`.
pub fn turned(p: Vec3, centre: Vec3, degrees: Vec3) -> Vec3 {
    let [x, y, z] = (degrees * std::f32::consts::PI / 180.0).to_array();
    let turn = Quat::from_rotation_z(z) * Quat::from_rotation_y(y) * Quat::from_rotation_x(x);
    turn.inverse() * (p - centre)
}

/// 0 below `low`, 1 above `high`, smooth between.
pub fn step(low: f32, high: f32, v: f32) -> f32 {
    let t = ((v - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Rounded ridges with a sharp furrow at every whole `phase`, from 0 to 1.
pub fn ridges(phase: f32) -> f32 {
    let s = (std::f32::consts::PI * phase).sin();
    (s * s + 0.02).sqrt()
}
