//! Light from lamps and from the sky: which of them a surface aims at, and what a path that leaves the scene meets.

use super::hit::SurfacePoints;
use super::light::Lights;
use super::queue::Paths;
use super::rough::Rough;
use super::shadow::ShadowRays;
use super::sky::{self, SkyPoints};
use super::vertex::{Frame, aim, lights, power_heuristic};
use crate::maths::vec3::Vec3x8;
use crate::tracer::scene::{Scene, Sky};
use crate::tracer::trace::{Hits8, MISS};
use wide::{f32x8, u32x8};

/// All that shines, as it is picked for eight surface points.
pub(super) enum Emitters<'a> {
    Lamps(Lights<'a>),
    Sky(&'a Sky<'a>),
    Both(Lights<'a>, &'a Sky<'a>),
}

impl<'a> Emitters<'a> {
    /// Lamps and sky as seen from the surface, whose normal the paths take along. The scene must have one of them.
    #[inline(always)]
    pub fn new(scene: &'a Scene<'_>, next: &mut Paths, surface: &SurfacePoints) -> Self {
        let data = scene.data();
        match &data.sky {
            None => Emitters::Lamps(lights(scene, next, surface)),
            Some(sky) if data.lights.is_empty() => Emitters::Sky(sky),
            Some(sky) => Emitters::Both(lights(scene, next, surface), sky),
        }
    }

    /// Shadow rays towards points picked by `u` and `v`, as [`aim`] makes them. Where there are lamps and a sky, the halves
    /// of `u` are theirs.
    #[inline(always)]
    pub fn aim(
        &self,
        paths: &Paths,
        surface: &SurfacePoints,
        frame: &Frame,
        bsdf: &Rough,
        (u, v): (f32x8, f32x8),
        share: f32x8,
    ) -> ShadowRays {
        match self {
            Emitters::Lamps(lamps) => aim(paths, surface, frame, bsdf, &lamps.sample(u, v), share),
            Emitters::Sky(sky) => aim_at_sky(paths, surface, frame, bsdf, &sky::sample(sky, u, v), share),
            Emitters::Both(lamps, sky) => {
                let (outside, u) = halves(u);
                let (mut point, mut out) = (lamps.sample(u, v), sky::sample(sky, u, v));
                for density in [&mut point.density, &mut point.exact_density, &mut out.density] {
                    *density *= f32x8::HALF;
                }
                let lamp = aim(paths, surface, frame, bsdf, &point, share);
                ShadowRays::select(outside, &aim_at_sky(paths, surface, frame, bsdf, &out, share), &lamp)
            }
        }
    }
}

/// The lanes in which `u` is below ½, and how far it is through its half.
#[inline(always)]
pub(super) fn halves(u: f32x8) -> (f32x8, f32x8) {
    let lower = u.simd_lt(f32x8::HALF);
    (lower, u + u - lower.select(f32x8::ZERO, f32x8::ONE))
}

/// [`aim`] for the sky.
#[inline(always)]
fn aim_at_sky(
    paths: &Paths,
    surface: &SurfacePoints,
    frame: &Frame,
    bsdf: &Rough,
    point: &SkyPoints,
    share: f32x8,
) -> ShadowRays {
    let (value, scattered) = bsdf.evaluate(frame.to_local(point.direction));
    let weight = power_heuristic(point.density, scattered * share) / point.density;
    ShadowRays {
        origin: surface.leave(point.direction),
        direction: point.direction,
        t_max: f32x8::splat(f32::INFINITY),
        value: paths.throughput.scaled(value).scaled(point.radiance) * weight,
        slot: paths.slot,
    }
}

/// What paths that leave the scene bring of the sky, weighted against aiming at it, and the lanes in which they do; none
/// if there is no sky or nothing leaves. `is_first` says that the paths come from the eye.
#[inline(always)]
pub(super) fn from_sky(
    scene: &Scene<'_>,
    paths: &Paths,
    hits: &Hits8,
    is_first: bool,
) -> Option<(Vec3x8, u32)> {
    let sky = scene.data().sky.as_ref()?;
    if is_first && !sky.visible {
        return None;
    }
    let missed = hits.triangle.simd_eq(u32x8::splat(MISS)).to_bitmask() & ((1 << paths.lanes) - 1);
    if missed == 0 {
        return None;
    }
    let aimed = sky::density(sky, paths.direction) * f32x8::splat(1.0 - scene.lamp_share());
    // Nobody aims at what is seen directly or in a mirror: that density is infinite.
    let weight = power_heuristic(paths.density, aimed);
    Some((paths.throughput.scaled(sky::radiance(sky, paths.direction)) * weight, missed))
}
