//! Where photons start: on lamps, or on a disc between the scene and the sky.

use super::light::Lights;
use super::queue::Paths;
use super::rough;
use super::sky;
use super::vertex::Frame;
use crate::maths::functions::sin_cos_turn;
use crate::maths::sobol;
use crate::maths::vec3::{self, Vec3x8};
use crate::tracer::scene::{Scattering, Scene, Sky};
use wide::{f32x8, u32x8};

/// Where photons start.
pub(super) struct Source {
    /// Probability of the sky.
    from_sky: f32,
    /// What photons from the sky are aimed at: centre and radius of a ball.
    target: ([f32; 3], f32),
    /// How far from its centre they start, outside of the scene.
    distance: f32,
}

impl Source {
    /// Photons of about the same power, as far as lamps and sky are neither without any.
    pub fn new(scene: &Scene<'_>, target: Bounds, all: Bounds) -> Source {
        let ((centre, radius), (middle, reach)) = (target.ball(), all.ball());
        let away = vec3::sub(centre, middle);
        let distance = libm::sqrtf(vec3::dot(away, away)) + reach;
        let from_sky = match &scene.data().sky {
            None => 0.0,
            Some(_) if scene.data().lights.is_empty() => 1.0,
            Some(sky) => {
                // Luminance times area times solid angle, over π.
                let (sky, lamps) = (sky.power * radius * radius, 1.0 / scene.inverse_power());
                (sky / (sky + lamps)).clamp(0.125, 0.875)
            }
        };
        Source { from_sky, target: (centre, radius), distance }
    }

    /// Photons on their way, with their share of the power of `paths` paths.
    pub fn emit(&self, scene: &Scene<'_>, paths: u32, index: u32x8, key: u32x8) -> Paths {
        let (u, v) = sobol::point(index, key, 1);
        let part = f32x8::splat(self.from_sky);
        match &scene.data().sky {
            None => from_lamps(scene, paths, (u, v), index, key),
            Some(sky) if self.from_sky == 1.0 => self.leave_sky(sky, paths, (u, v), index, key),
            Some(sky) => {
                let outside = u.simd_lt(part);
                let of_lamp = (u - part) / (f32x8::ONE - part);
                let mut lamp = from_lamps(scene, paths, (of_lamp.fast_max(f32x8::ZERO), v), index, key);
                lamp.throughput = lamp.throughput * (f32x8::ONE / (f32x8::ONE - part));
                let of_sky = (u / part).fast_min(f32x8::splat(1.0 - f32::EPSILON));
                let far = self.leave_sky(sky, paths, (of_sky, v), index, key);
                Paths {
                    origin: Vec3x8::select(outside, far.origin, lamp.origin),
                    direction: Vec3x8::select(outside, far.direction, lamp.direction),
                    throughput: Vec3x8::select(outside, far.throughput, lamp.throughput),
                    ..lamp
                }
            }
        }
    }

    /// Photons from the sky, through a disc outside of the scene.
    fn leave_sky(
        &self,
        sky: &Sky<'_>,
        paths: u32,
        (u, v): (f32x8, f32x8),
        index: u32x8,
        key: u32x8,
    ) -> Paths {
        let point = sky::sample(sky, u, v);
        let (centre, radius) = self.target;
        let (across, around) = sobol::point(index, key, 2);
        let (sin, cos) = sin_cos_turn(around);
        let out = across.sqrt() * f32x8::splat(radius);
        let frame = Frame::new(point.direction);
        let start = frame.to_world(Vec3x8::new(out * cos, out * sin, f32x8::splat(self.distance)));
        let area = core::f32::consts::PI * radius * radius;
        let flux = f32x8::splat(area / (self.from_sky * paths as f32)) / point.density;
        starting(Vec3x8::splat(centre) + start, -point.direction, point.radiance * flux, index, key)
    }
}

/// Photons on their way off the lamps.
///
/// By the exact density: the rounding of the table moves a good part of a faint lamp's share. A lamp with less than 2^-24
/// of the power may have no share at all.
fn from_lamps(scene: &Scene<'_>, paths: u32, (u, v): (f32x8, f32x8), index: u32x8, key: u32x8) -> Paths {
    let point = Lights::by_power(scene, scene.time(index, key)).sample(u, v);
    let (u, v) = sobol::point(index, key, 2);
    let frame = Frame::new(point.normal);
    let flux = f32x8::splat(core::f32::consts::PI / paths as f32) / point.exact_density;
    let origin = point.position + point.normal * point.clearance;
    let direction = frame.to_world(rough::cosine_direction(u, v));
    starting(origin, direction, point.radiance * flux, index, key)
}

/// Photons at their start.
fn starting(origin: Vec3x8, direction: Vec3x8, power: Vec3x8, index: u32x8, key: u32x8) -> Paths {
    Paths {
        origin,
        direction,
        throughput: power,
        density: f32x8::splat(f32::INFINITY),
        compression: f32x8::ONE,
        normal: u32x8::ZERO,
        index,
        key,
        slot: u32x8::ZERO,
        lanes: 8,
    }
}

/// A box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    lower: [f32; 3],
    upper: [f32; 3],
}

impl Bounds {
    /// Around all surfaces that scatter as `counts` says, a little wider; none if there are none.
    pub fn of(scene: &Scene<'_>, counts: impl Fn(Scattering) -> bool) -> Option<Bounds> {
        let data = scene.data();
        let mut bounds = Bounds { lower: [f32::INFINITY; 3], upper: [f32::NEG_INFINITY; 3] };
        let motion = data.motion.map_or(&[][..], |motion| motion.triangles);
        let moved = motion.iter().zip(data.surfaces);
        for (triangle, surface) in data.triangles.iter().zip(data.surfaces).chain(moved) {
            if !counts(data.materials[surface.material as usize].scattering) {
                continue;
            }
            for corner in triangle.corners {
                bounds.lower = [0, 1, 2].map(|i| bounds.lower[i].min(corner[i]));
                bounds.upper = [0, 1, 2].map(|i| bounds.upper[i].max(corner[i]));
            }
        }
        let size = [0, 1, 2].map(|i| bounds.upper[i] - bounds.lower[i]);
        let margin = 1e-4 * size.iter().fold(0.0, |a: f32, b| a.max(*b));
        let is_used = margin.is_finite() && bounds.lower[0] <= bounds.upper[0];
        is_used.then(|| Bounds {
            lower: bounds.lower.map(|v| v - margin),
            upper: bounds.upper.map(|v| v + margin),
        })
    }

    /// Centre and radius of the ball around it.
    fn ball(&self) -> ([f32; 3], f32) {
        let half = vec3::scale(vec3::sub(self.upper, self.lower), 0.5);
        let centre = [0, 1, 2].map(|i| self.lower[i] + half[i]);
        (centre, libm::sqrtf(vec3::dot(half, half)))
    }

    /// The lanes whose ray passes through the box, as bits.
    pub fn meets(&self, paths: &Paths) -> u32 {
        let (o, d) = (paths.origin, paths.direction);
        let (mut enter, mut leave) = (f32x8::ZERO, f32x8::splat(f32::INFINITY));
        for (axis, (o, d)) in [(o.x, d.x), (o.y, d.y), (o.z, d.z)].into_iter().enumerate() {
            // Parallel rays divide by almost nothing instead of zero.
            let slope = f32x8::ONE / d.abs().fast_max(f32x8::splat(1e-18)).copysign(d);
            let a = (f32x8::splat(self.lower[axis]) - o) * slope;
            let b = (f32x8::splat(self.upper[axis]) - o) * slope;
            enter = enter.fast_max(a.fast_min(b));
            leave = leave.fast_min(a.fast_max(b));
        }
        enter.simd_le(leave).to_bitmask()
    }
}
