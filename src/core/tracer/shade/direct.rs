//! Direct lighting over packets: what lamps send straight to the first rough surface.
//!
//! A sample follows mirrors and glass to the first rough surface. There it aims at a number of points on lights and
//! draws a number of directions from the scattering function; both kinds are weighted by the power heuristic with
//! their numbers (Veach 1997, section 9.2: n²p² over the sum of all n²p²). Light that the surface gets from other
//! surfaces, or from lamps through mirrors and glass, is left out: that is what distinguishes it from
//! [`PathTracer`]. At depth 2 the two have the same expectation.
//!
//! Depth counts as for the path tracer: with a depth of D the rough surface is met at the latest by segment D − 1.
//! There is no Russian roulette.
//!
//! The points of one pixel sample are consecutive points of its Sobol sets, and those of its successor follow: all
//! points of a pixel are one well-spread sequence, which repeats after 2³² of them.

use super::cutout::{self, Chance};
use super::emitters::Emitters;
use super::hit::SurfacePoints;
use super::light::are_few;
use super::path::{self, PathTracer, Traffic, Wavefront};
use super::queue::{Open, Packet, Paths};
use super::rough::Rough;
use super::vertex::{self, Frame, SETS, scatter, scatter_specular};
use crate::maths::sobol;
use crate::sampler::batch::{Batch8, Integrand, Rgb8};
use crate::tracer::camera::Camera;
use crate::tracer::scene::{Scattering, Scene};
use wide::{f32x8, u32x8};

/// How often each pixel sample looks for light at the rough surface it meets. Zeros count as one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Samples {
    /// Points on lights.
    pub light: u32,
    /// Directions drawn from the scattering function.
    pub bsdf: u32,
}

/// The direct lighting integrator. Implements [`Integrand`].
pub struct DirectLighting<'a> {
    /// Follows the specular chain and traces shadow rays.
    paths: PathTracer<'a>,
    /// Rays along sampled directions, waiting for a packet to fill up.
    stray: Open,
    samples: Samples,
}

impl<'a> DirectLighting<'a> {
    /// Direct lighting of `scene` seen through `camera`, after chains of mirrors and glass of up to `max_depth`
    /// segments, those to the rough surface and to the light included.
    ///
    /// `memory` is scratch: [`PathTracer::required`] says how much, and what happens with less.
    pub fn new(
        scene: Scene<'a>,
        camera: Camera,
        max_depth: u32,
        samples: Samples,
        memory: &'a mut [Packet],
    ) -> Self {
        let samples = Samples { light: samples.light.max(1), bsdf: samples.bsdf.max(1) };
        let paths = PathTracer::new(scene, camera, max_depth, memory);
        DirectLighting { paths, stray: Open::default(), samples }
    }

    /// What has been traced so far.
    pub fn traffic(&self) -> Traffic {
        self.paths.traffic()
    }

    /// Samples the light that arrives in the lanes of `rough`, in both ways.
    fn light(
        &mut self,
        paths: &Paths,
        surface: &SurfacePoints,
        rough: f32x8,
        depth: u32,
        radiance: &mut [Rgb8],
    ) {
        let frame = Frame::new(surface.normal);
        let bsdf = Rough::new(surface, frame.to_local(-paths.direction));
        let Samples { light, bsdf: scattered } = self.samples;
        let share = f32x8::splat(scattered as f32 / light as f32);
        let (scene, mut part) = (*self.paths.tracer.scene(), *paths);
        let few = are_few(&scene);
        let emitters = Emitters::new(&scene, &mut part, surface);
        part.throughput = paths.throughput * f32x8::splat(1.0 / light as f32);
        for number in 0..light {
            let point = sobol::point(nth(paths, light, number), paths.key, SETS * depth - 2);
            let shadow = emitters.aim(&part, surface, &frame, &bsdf, point, share);
            self.paths.queue_shadows(&shadow, rough, radiance);
        }
        part.throughput = paths.throughput * f32x8::splat(1.0 / scattered as f32);
        for number in 0..scattered {
            let index = nth(paths, scattered, number);
            let point = sobol::point(index, paths.key, SETS * depth - 1);
            let mut next = part;
            scatter(&mut next, surface, &frame, &bsdf, rough, point, || {
                sobol::point(index, paths.key, SETS * depth).0
            });
            vertex::reject_nan(&next, rough, radiance);
            next.density *= share;
            next.origin = surface.leave(next.direction);
            let alive = rough & next.throughput.max_component().simd_gt(f32x8::ZERO);
            let tracer = &mut self.paths;
            if few {
                tracer.end_on_lights(&next, alive, radiance);
                continue;
            }
            self.stray
                .push(&next, alive.to_bitmask(), |packet| stray_arrives(tracer, &packet.unpack(), radiance));
        }
    }
}

/// Any depth of segments that do not come from the eye.
const STRAY: u32 = 2;

/// Number in a Sobol set of the `number`-th of `count` points that each sample takes from it.
#[inline(always)]
fn nth(paths: &Paths, count: u32, number: u32) -> u32x8 {
    paths.index * u32x8::splat(count) + u32x8::splat(number)
}

/// Traces a packet of rays along sampled directions and adds the light that they meet.
fn stray_arrives(tracer: &mut PathTracer<'_>, paths: &Paths, radiance: &mut [Rgb8]) {
    // Its paths may be of different depths, and several of one sample.
    let salt = sobol::hash8(bytemuck::cast(paths.direction.x));
    let chance = Chance { key: paths.key ^ salt, ..paths.chance(0) };
    _ = arrive(tracer, paths, (STRAY, chance), radiance);
}

/// Traces a packet, segment number `depth` of its paths, and adds what it meets of surfaces that emit and of the sky;
/// returns the surfaces, if there are any. `chance` decides at cut-outs.
#[inline(always)]
pub(super) fn arrive(
    tracer: &mut PathTracer<'_>,
    paths: &Paths,
    (depth, chance): (u32, Chance),
    radiance: &mut [Rgb8],
) -> Option<SurfacePoints> {
    let rays = paths.rays(tracer.tracer.scene());
    tracer.traffic.packets += 1;
    tracer.traffic.rays += u64::from(paths.lanes);
    let hits = cutout::closest(&mut tracer.tracer, &rays, chance);
    tracer.add_sky(paths, &hits, depth, radiance);
    if !hits.any() {
        return None;
    }
    let surface = SurfacePoints::at(tracer.tracer.scene(), &rays, &hits);
    tracer.add_emission(paths, &surface, &hits, radiance);
    Some(surface)
}

impl<'a> Wavefront<'a> for DirectLighting<'a> {
    fn paths(&mut self) -> &mut PathTracer<'a> {
        &mut self.paths
    }

    /// Takes one packet through one segment of its chain.
    fn bounce(&mut self, paths: &Paths, depth: u32, radiance: &mut [Rgb8]) {
        let order = (depth, paths.chance(depth));
        let Some(surface) = arrive(&mut self.paths, paths, order, radiance) else { return };
        if depth >= self.paths.max_depth {
            return;
        }
        let rough = surface.scatters(Scattering::Rough);
        if rough.any() && self.paths.tracer.scene().is_lit() {
            self.light(paths, &surface, rough, depth, radiance);
        }
        let specular = surface.hit & !rough;
        if specular.any() {
            let mut next = *paths;
            let (choice, _) = sobol::point(paths.index, paths.key, SETS * depth);
            scatter_specular(&mut next, &surface, choice);
            vertex::reject_nan(&next, specular, radiance);
            let alive = specular & next.throughput.max_component().simd_gt(f32x8::ZERO);
            next.origin = surface.leave(next.direction);
            self.paths.queue.push(&next, alive.to_bitmask());
        }
    }

    fn finish(&mut self, radiance: &mut [Rgb8]) {
        let DirectLighting { paths, stray, .. } = self;
        stray.drain(|packet| stray_arrives(paths, &packet.unpack(), radiance));
    }
}

impl Integrand for DirectLighting<'_> {
    fn radiance(&mut self, batch: &Batch8) -> Rgb8 {
        path::radiance(self, batch)
    }

    fn stream(&mut self, batches: &[Batch8], radiance: &mut [Rgb8]) {
        path::stream(self, batches, radiance);
    }
}
