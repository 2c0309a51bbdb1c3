//! What happens where a path meets a surface: light that is met or aimed at, scattering, Russian roulette.

use super::hit::SurfacePoints;
use super::light::{self, Emitting, LightPoints, Lights, Receiver};
use super::queue::Paths;
use super::rough::Rough;
use super::shadow::ShadowRays;
use super::specular;
use crate::maths::sobol;
use crate::maths::vec3::{Vec3x8, pack_unit, unpack_unit};
use crate::sampler::batch::Rgb8;
use crate::tracer::scene::{Scattering, Scene};
use crate::tracer::trace::{Hits8, perpendicular};
use wide::f32x8;

/// Largest probability of surviving the roulette.
const MAX_SURVIVAL: f32 = 0.95;

/// Shadow rays end this fraction before the light, so that they do not hit it.
pub(super) const SHADOW_REACH: f32 = 1.0 - 1e-4;

/// Sobol sets a depth uses: light position, direction, and choices.
pub(super) const SETS: u32 = 3;

/// Depth from which on paths may be ended by chance.
pub(super) const ROULETTE_DEPTH: u32 = 5;

/// What the surface emits towards the path, weighted against aiming at it, and the lanes in which it does; none if
/// there is none.
#[inline(always)]
pub(super) fn emitted(
    scene: &Scene<'_>,
    paths: &Paths,
    surface: &SurfacePoints,
    hits: &Hits8,
) -> Option<(Vec3x8, f32x8)> {
    let front = surface.cosine.simd_gt(f32x8::ZERO);
    let lit = surface.hit & front & surface.emission.max_component().simd_gt(f32x8::ZERO);
    if !lit.any() {
        return None;
    }
    // Nobody aims at what is seen directly or in a mirror.
    let by_chance = lit & paths.density.simd_lt(f32x8::splat(f32::INFINITY));
    let receiver = || Receiver { position: paths.origin, normal: unpack_unit(paths.normal) };
    let emitters =
        Emitting { triangle: hits.triangle, time: surface.time, radiance: surface.typical_emission };
    let density = light::density(scene, receiver, &emitters, by_chance.to_bitmask());
    let density = density * f32x8::splat(scene.lamp_share());
    let aimed = density * hits.t * hits.t / surface.cosine;
    let weight = power_heuristic(paths.density, aimed);
    Some((paths.throughput.scaled(surface.emission) * weight, lit))
}

/// The lights as seen from the surface, whose normal the paths take along.
#[inline(always)]
pub(super) fn lights<'a>(scene: &'a Scene<'_>, next: &mut Paths, surface: &SurfacePoints) -> Lights<'a> {
    Lights::new(scene, surface.time, || {
        next.normal = pack_unit(surface.normal);
        Receiver { position: surface.position, normal: unpack_unit(next.normal) }
    })
}

/// Shadow rays towards points on the lights, with what they carry if nothing is in between. `share` is the
/// number of scattered directions for each point on a light.
#[inline(always)]
pub(super) fn aim(
    paths: &Paths,
    surface: &SurfacePoints,
    frame: &Frame,
    bsdf: &Rough,
    point: &LightPoints,
    share: f32x8,
) -> ShadowRays {
    // What arrives is reckoned from the surface itself; only the ray starts off it.
    let toward = point.position - surface.position;
    let distance = toward.length();
    let direction = toward * (f32x8::ONE / distance);
    let cosine = -direction.dot(point.normal);
    let (value, scattered) = bsdf.evaluate(frame.to_local(direction));
    let per_solid_angle = distance * distance / cosine;
    let weight = power_heuristic(point.density * per_solid_angle, scattered * share)
        / (point.exact_density * per_solid_angle);
    let value = paths.throughput.scaled(value).scaled(point.radiance) * weight;
    let lit = cosine.simd_gt(f32x8::ZERO) & surface.faces(direction);
    let origin = surface.leave(toward);
    let ray = point.position - origin;
    let length = ray.length();
    ShadowRays {
        origin,
        direction: ray * (f32x8::ONE / length),
        t_max: length * f32x8::splat(SHADOW_REACH),
        time: surface.time,
        value: Vec3x8::select(lit, value, Vec3x8::default()),
        slot: paths.slot,
    }
}

/// Replaces direction and throughput in the lanes of `rough` by a sample of the scattering function.
#[inline(always)]
pub(super) fn scatter(
    next: &mut Paths,
    surface: &SurfacePoints,
    frame: &Frame,
    bsdf: &Rough,
    rough: f32x8,
    (u, v): (f32x8, f32x8),
    part: impl FnOnce() -> f32x8,
) {
    let incoming = bsdf.sample(u, v, part);
    let (value, density) = bsdf.evaluate(incoming);
    let weight = value * (f32x8::ONE / density);
    let none = Vec3x8::default();
    // Not "above 0": a density that is not a number must not end the path like one of zero (see `reject_nan`).
    let direction = frame.to_world(incoming);
    let lost = density.simd_le(f32x8::ZERO) | !surface.faces(direction);
    let throughput = Vec3x8::select(lost, none, next.throughput.scaled(weight));
    next.throughput = Vec3x8::select(rough, throughput, next.throughput);
    next.direction = Vec3x8::select(rough, direction, next.direction);
    next.density = rough.select(density, next.density);
}

/// Replaces direction and throughput in the lanes that hit a mirror or a dielectric.
pub(super) fn scatter_specular(next: &mut Paths, surface: &SurfacePoints, choice: f32x8) {
    let infinite = f32x8::splat(f32::INFINITY);
    let mirror = surface.scatters(Scattering::Mirror);
    let glass = surface.scatters(Scattering::Dielectric);
    let through = specular::dielectric(surface, next.direction, choice);
    let mirrored = specular::reflect(next.direction, surface.normal);
    let weight = Vec3x8::select(glass, through.weight, surface.specular);
    let direction = Vec3x8::select(glass, through.direction, mirrored);
    let either = mirror | glass;
    next.throughput = Vec3x8::select(either, next.throughput.scaled(weight), next.throughput);
    next.direction = Vec3x8::select(either, direction, next.direction);
    next.density = either.select(infinite, next.density);
    next.compression = glass.select(next.compression * through.compression, next.compression);
}

/// Makes the radiance of samples whose path, in the lanes of `hit`, carries what is not a number, or goes there, NaN, so
/// that the film rejects and counts them: the path itself ends without a word, since NaN is not above 0 and a ray
/// without a direction hits nothing.
#[inline(always)]
pub(super) fn reject_nan(paths: &Paths, hit: f32x8, radiance: &mut [Rgb8]) {
    let sum = |v: Vec3x8| v.x + v.y + v.z;
    let all = sum(paths.throughput) + sum(paths.direction);
    let lost = hit & !all.simd_eq(all);
    if lost.any() {
        super::shadow::accumulate(radiance, paths.slot, Vec3x8::splat([f32::NAN; 3]), lost.to_bitmask());
    }
}

/// Ends paths that carry nothing, and by chance those that carry little; returns the others.
pub(super) fn survivors(next: &mut Paths, hit: f32x8, depth: u32) -> f32x8 {
    let carried = next.throughput.max_component();
    let mut alive = hit & carried.simd_gt(f32x8::ZERO);
    if depth >= ROULETTE_DEPTH {
        let (_, chance) = sobol::point(next.index, next.key, SETS * depth);
        let survival = (carried / next.compression).fast_min(f32x8::splat(MAX_SURVIVAL));
        alive &= chance.simd_lt(survival);
        next.throughput = next.throughput * (f32x8::ONE / survival);
    }
    alive
}

/// Weight of a technique of density `own` beside one of density `other`: a²/(a² + b²), without overflow.
#[inline(always)]
pub(super) fn power_heuristic(own: f32x8, other: f32x8) -> f32x8 {
    let ratio = other / own;
    f32x8::ONE / (f32x8::ONE + ratio * ratio)
}

/// An orthonormal frame whose third axis is the shading normal.
pub(super) struct Frame {
    tangent: Vec3x8,
    bitangent: Vec3x8,
    normal: Vec3x8,
}

impl Frame {
    #[inline(always)]
    pub(super) fn new(normal: Vec3x8) -> Self {
        let (tangent, bitangent) = perpendicular(normal);
        Frame { tangent, bitangent, normal }
    }

    #[inline(always)]
    pub(super) fn to_local(&self, v: Vec3x8) -> Vec3x8 {
        Vec3x8::new(v.dot(self.tangent), v.dot(self.bitangent), v.dot(self.normal))
    }

    /// One lane's frame in all lanes.
    #[inline(always)]
    pub(super) fn lane(&self, lane: usize) -> Self {
        Frame {
            tangent: self.tangent.lane(lane),
            bitangent: self.bitangent.lane(lane),
            normal: self.normal.lane(lane),
        }
    }

    #[inline(always)]
    pub(super) fn to_world(&self, v: Vec3x8) -> Vec3x8 {
        self.tangent * v.x + self.bitangent * v.y + self.normal * v.z
    }
}
