//! Light from lamps and from the sky: which of them a surface aims at, and what a path that leaves the scene meets.

use super::hit::SurfacePoints;
use super::light::Lights;
use super::queue::Paths;
use super::rough::Rough;
use super::shadow::{ShadowRays, accumulate};
use super::sky::{self, SkyPoints};
use super::vertex::{Frame, aim, lights, power_heuristic};
use crate::maths::vec3::Vec3x8;
use crate::sampler::batch::Rgb8;
use crate::tracer::scene::{Scene, Sky};
use crate::tracer::trace::Hits8;
use wide::f32x8;

/// All that shines, as it is picked for eight surface points.
pub(super) enum Emitters<'a> {
    Lamps(Lights<'a>),
    Outside(Outside<'a>),
}

/// A sky, and the lamps if there are any.
pub(super) struct Outside<'a> {
    sky: &'a Sky<'a>,
    lamps: Option<Lights<'a>>,
}

impl<'a> Emitters<'a> {
    /// Lamps and sky as seen from the surface, whose normal the paths take along. The scene must have one of them.
    #[inline(always)]
    pub fn new(scene: &'a Scene<'_>, next: &mut Paths, surface: &SurfacePoints) -> Self {
        match &scene.data().sky {
            None => Emitters::Lamps(lights(scene, next, surface)),
            Some(sky) => Emitters::Outside(Outside::new(scene, sky, next, surface)),
        }
    }

    /// Shadow rays towards points picked by `u` and `v`, as [`aim`] makes them.
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
            Emitters::Outside(outside) => outside.aim(paths, surface, frame, bsdf, (u, v), share),
        }
    }
}

// Kept out of the loops that call it: with it they would be slower in scenes without a sky.
impl<'a> Outside<'a> {
    #[inline(never)]
    fn new(scene: &'a Scene<'_>, sky: &'a Sky<'a>, next: &mut Paths, surface: &SurfacePoints) -> Self {
        let lamps = (!scene.data().lights.is_empty()).then(|| lights(scene, next, surface));
        Outside { sky, lamps }
    }

    /// As [`Emitters::aim`]. Where there are lamps, too, the halves of `u` are theirs.
    #[inline(never)]
    fn aim(
        &self,
        paths: &Paths,
        surface: &SurfacePoints,
        frame: &Frame,
        bsdf: &Rough,
        (u, v): (f32x8, f32x8),
        share: f32x8,
    ) -> ShadowRays {
        let Some(lamps) = &self.lamps else {
            return aim_at_sky(paths, surface, frame, bsdf, &sky::sample(self.sky, u, v), share);
        };
        let (outside, u) = halves(u);
        let (mut point, mut out) = (lamps.sample(u, v), sky::sample(self.sky, u, v));
        for density in [&mut point.density, &mut point.exact_density, &mut out.density] {
            *density *= f32x8::HALF;
        }
        let lamp = aim(paths, surface, frame, bsdf, &point, share);
        ShadowRays::select(outside, &aim_at_sky(paths, surface, frame, bsdf, &out, share), &lamp)
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
    let value = paths.throughput.scaled(value).scaled(point.radiance) * weight;
    ShadowRays {
        origin: surface.leave(point.direction),
        direction: point.direction,
        t_max: f32x8::splat(f32::INFINITY),
        time: surface.time,
        value: Vec3x8::select(surface.faces(point.direction), value, Vec3x8::default()),
        slot: paths.slot,
    }
}

/// Adds what paths that leave the scene bring of the sky, weighted against aiming at it. `is_first` says that the paths
/// come from the eye.
#[inline(never)]
pub(super) fn add_sky(
    scene: &Scene<'_>,
    sky: &Sky<'_>,
    paths: &Paths,
    hits: &Hits8,
    is_first: bool,
    radiance: &mut [Rgb8],
) {
    let missed = (!hits.lanes()).to_bitmask() & ((1 << paths.lanes) - 1);
    if missed == 0 || is_first && !sky.visible {
        return;
    }
    let aimed = sky::density(sky, paths.direction) * f32x8::splat(1.0 - scene.lamp_share());
    // Nobody aims at what is seen directly or in a mirror: that density is infinite.
    let weight = power_heuristic(paths.density, aimed);
    let value = paths.throughput.scaled(sky::radiance(sky, paths.direction)) * weight;
    accumulate(radiance, paths.slot, value, missed);
}
