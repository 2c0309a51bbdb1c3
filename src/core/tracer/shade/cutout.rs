//! Surfaces that are only partly there: leaves on cards, wire, gauze.
//!
//! Where a material's opacity is o, a ray meets the surface with probability o, else it goes straight on, as the same
//! segment of its path: so the mean over samples is the picture of a surface of which the part o is there, without
//! bias. Shadow rays are dimmed by 1 − o at each layer instead of ended by chance, which has the same mean and less noise.
//! The points that decide are Sobol sets of their own, one for each depth and layer. Surfaces that coincide count as
//! one layer. Scenes where everything is opaque skip all of it.

use super::hit::{self, SurfacePoints};
use crate::maths::sobol;
use crate::maths::vec3::Vec3x8;
use crate::tracer::trace::{Hits8, Rays8, Tracer};
use wide::{f32x8, u32x8};

/// Layers that a ray passes at most: more than any scene has on a line, an end to rays that rounding keeps in place.
const MOST_LAYERS: u32 = 1024;

/// Tells the sets of points that decide here from all others.
const SETS: u32 = 1 << 31;

/// The Sobol sequences that decide whether eight rays pass.
#[derive(Clone, Copy)]
pub(super) struct Chance {
    /// Numbers of the samples.
    pub index: u32x8,
    /// Keys of the sequences.
    pub key: u32x8,
    /// Number of the segment.
    pub depth: u32,
}

impl Chance {
    fn at(&self, layer: u32) -> f32x8 {
        sobol::point(self.index, self.key, SETS | self.depth << 10 | layer).0
    }
}

/// What `rays` meet, cut-outs by chance. Distances are from the rays' origins.
#[inline(always)]
pub(super) fn closest(tracer: &mut Tracer<'_>, rays: &Rays8, chance: Chance) -> Hits8 {
    let hits = tracer.closest(rays);
    match tracer.scene().is_cut_out() {
        true => go_on(tracer, rays, hits, |layer| chance.at(layer)),
        false => hits,
    }
}

/// What is seen first along `rays`: surfaces of which less than half is there are not.
pub fn seen(tracer: &mut Tracer<'_>, rays: &Rays8) -> Hits8 {
    let hits = tracer.closest(rays);
    match tracer.scene().is_cut_out() {
        true => go_on(tracer, rays, hits, |_| f32x8::HALF),
        false => hits,
    }
}

/// Takes rays on through surfaces of which the part that is there is not above `chance(layer)`. Kept out of the loops that
/// call it, which are slower with it in scenes that have no cut-outs.
#[inline(never)]
fn go_on(tracer: &mut Tracer<'_>, rays: &Rays8, mut hits: Hits8, chance: impl Fn(u32) -> f32x8) -> Hits8 {
    let (start, mut rays) = (rays.origin, *rays);
    let mut on = hits.lanes();
    for layer in 0..MOST_LAYERS {
        if !on.any() {
            break;
        }
        let surface = SurfacePoints::at(tracer.scene(), &rays, &hits);
        on &= surface.hit & chance(layer).simd_ge(hit::opacity(tracer.scene(), &hits));
        if !on.any() {
            break;
        }
        pass(&mut rays, &surface, on);
        let beyond = tracer.closest(&rays);
        let so_far = (rays.origin - start).dot(rays.direction);
        hits = Hits8 {
            t: on.select(so_far + beyond.t, hits.t),
            u: on.select(beyond.u, hits.u),
            v: on.select(beyond.v, hits.v),
            triangle: on.select(beyond.triangle, hits.triangle),
        };
    }
    hits
}

/// The part of the light that passes along `rays`, 0 to 1.
#[inline(never)]
pub(super) fn transmitted(tracer: &mut Tracer<'_>, rays: &Rays8) -> f32x8 {
    let (mut rays, mut part) = (*rays, f32x8::ONE);
    for _ in 0..MOST_LAYERS {
        let hits = tracer.closest(&rays);
        if !hits.any() {
            break;
        }
        let surface = SurfacePoints::at(tracer.scene(), &rays, &hits);
        part = surface.hit.select(part * (f32x8::ONE - hit::opacity(tracer.scene(), &hits)), part);
        pass(&mut rays, &surface, surface.hit & part.simd_gt(f32x8::ZERO));
    }
    part
}

/// Starts rays anew beyond a surface in the lanes of `on`; the others become idle.
#[inline(always)]
fn pass(rays: &mut Rays8, surface: &SurfacePoints, on: f32x8) {
    let beyond = surface.leave(rays.direction);
    let step = (beyond - rays.origin).dot(rays.direction);
    rays.origin = Vec3x8::select(on, beyond, rays.origin);
    rays.t_max = on.select(rays.t_max - step, f32x8::splat(-1.0));
}
