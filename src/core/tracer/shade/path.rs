//! A path tracer over packets: next-event estimation, multiple importance sampling, Russian roulette.
//!
//! Paths advance together, bounce by bounce. A bounce traces every packet, adds what the surfaces emit, queues a
//! shadow ray towards a light, samples the next direction and packs the survivors into full packets again (see
//! `queue`). Light that a path meets by chance and light that was aimed at are weighted by the power heuristic
//! (Veach 1997, section 9.2.4). Depth counts as in Mitsuba: 1 is emitted light seen directly, 2 is direct
//! lighting. From depth 5 on a path survives with the probability of its throughput, at most 0.95.
//!
//! All randomness comes from the samples' own Sobol sets, three for each depth, whatever is traced beside it;
//! only hits that are equal up to rounding can depend on the other rays of a packet.

use super::cutout;
use super::emitters::{Emitters, add_sky};
use super::hit::SurfacePoints;
use super::light;
use super::queue::{Paths, Queue};
use super::rough::Rough;
use super::shadow::{ShadowRays, Shadows};
use super::vertex::{Frame, SETS, SHADOW_REACH, emitted, reject_nan, scatter, scatter_specular, survivors};
use crate::maths::sobol;
use crate::maths::vec3::Vec3x8;
use crate::sampler::batch::{Batch8, Integrand, Rgb8};
use crate::tracer::camera::{Camera, Primary};
use crate::tracer::scene::{Scattering, Scene};
use crate::tracer::trace::{Hits8, Tracer};
use wide::{f32x8, u32x8};

pub use super::queue::Packet;

/// How full packets were: rays traced over eight times the packets traced is the occupancy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Packets traced for the nearest hit.
    pub packets: u64,
    /// Rays in them.
    pub rays: u64,
    /// Packets traced for occlusion.
    pub shadow_packets: u64,
    /// Rays in them.
    pub shadow_rays: u64,
}

/// The path tracer. Implements [`Integrand`].
pub struct PathTracer<'a> {
    pub(super) tracer: Tracer<'a>,
    /// None where paths start elsewhere.
    camera: Option<Camera>,
    pub(super) max_depth: u32,
    pub(super) queue: Queue<'a>,
    pub(super) shadows: Shadows,
    pub(super) traffic: Traffic,
}

impl<'a> PathTracer<'a> {
    /// Packets of memory needed to work on `samples` samples at once. More samples keep the lanes fuller; above
    /// about two thousand the gain ends and the caches overflow.
    pub const fn required(samples: usize) -> usize {
        Queue::required(samples)
    }

    /// A path tracer for `scene` seen through `camera`, with paths of up to `max_depth` segments.
    ///
    /// `memory` is scratch: [`required`](Self::required) says how much. With less than needed for one packet
    /// nothing is traced and all radiance is NaN, which the film rejects and counts.
    pub fn new(scene: Scene<'a>, camera: Camera, max_depth: u32, memory: &'a mut [Packet]) -> Self {
        PathTracer { camera: Some(camera), ..PathTracer::blind(scene, max_depth, memory) }
    }

    /// A path tracer for paths that do not start at a camera.
    pub(super) fn blind(scene: Scene<'a>, max_depth: u32, memory: &'a mut [Packet]) -> Self {
        PathTracer {
            tracer: Tracer::new(scene),
            camera: None,
            max_depth,
            queue: Queue::new(memory, &scene),
            shadows: Shadows::default(),
            traffic: Traffic::default(),
        }
    }

    /// What has been traced so far.
    pub fn traffic(&self) -> Traffic {
        self.traffic
    }

    /// Fills the queue with the primary rays of `batches`.
    fn start(&mut self, batches: &[Batch8]) {
        let Some(camera) = self.camera else { return };
        self.queue.clear();
        for (number, batch) in batches.iter().enumerate() {
            let Primary { origin, direction } = camera.rays(batch);
            self.queue.start(&begin(batch, number, origin, direction));
        }
    }

    /// Adds what the surface emits towards the path, weighted against aiming at it.
    pub(super) fn add_emission(
        &self,
        paths: &Paths,
        surface: &SurfacePoints,
        hits: &Hits8,
        radiance: &mut [Rgb8],
    ) {
        if let Some((value, lit)) = emitted(self.tracer.scene(), paths, surface, hits) {
            super::shadow::accumulate(radiance, paths.slot, value, lit.to_bitmask());
        }
    }

    /// Adds what paths that meet nothing see of the sky, weighted against aiming at it. `depth` counts their segments.
    #[inline(always)]
    pub(super) fn add_sky(&self, paths: &Paths, hits: &Hits8, depth: u32, radiance: &mut [Rgb8]) {
        if let Some(sky) = &self.tracer.scene().data().sky {
            add_sky(self.tracer.scene(), sky, paths, hits, depth == 1, radiance);
        }
    }

    /// Ends paths whose next segment counts only if it ends on a light: looks for the light first, and for what is in
    /// between only if there is one. For scenes of [few lights](light::are_few).
    pub(super) fn end_on_lights(&mut self, paths: &Paths, alive: f32x8, radiance: &mut [Rgb8]) {
        let t_max = alive.select(f32x8::splat(f32::INFINITY), f32x8::splat(-1.0));
        let rays = paths.rays_to(t_max, self.tracer.scene());
        let hits = self.tracer.closest_light(&rays);
        if !hits.any() {
            return;
        }
        let surface = SurfacePoints::at(self.tracer.scene(), &rays, &hits);
        if let Some((value, lit)) = emitted(self.tracer.scene(), paths, &surface, &hits) {
            let t_max = hits.t * f32x8::splat(SHADOW_REACH);
            let (origin, direction, slot) = (paths.origin, paths.direction, paths.slot);
            let shadow = ShadowRays { origin, direction, t_max, time: rays.time, value, slot };
            self.queue_shadows(&shadow, lit, radiance);
        }
    }

    /// Queues a shadow ray and samples the next direction in the lanes of `rough`.
    pub(super) fn scatter_rough(
        &mut self,
        next: &mut Paths,
        surface: &SurfacePoints,
        rough: f32x8,
        depth: u32,
        radiance: &mut [Rgb8],
    ) {
        let frame = Frame::new(surface.normal);
        let bsdf = Rough::new(surface, frame.to_local(-next.direction));
        if self.tracer.scene().is_lit() {
            let point = sobol::point(next.index, next.key, SETS * depth - 2);
            let emitters = Emitters::new(self.tracer.scene(), next, surface);
            let shadow = emitters.aim(next, surface, &frame, &bsdf, point, f32x8::ONE);
            self.queue_shadows(&shadow, rough, radiance);
        }
        let point = sobol::point(next.index, next.key, SETS * depth - 1);
        let (index, key) = (next.index, next.key);
        let part = || sobol::point(index, key, SETS * depth).0;
        scatter(next, surface, &frame, &bsdf, rough, point, part);
    }

    /// Queues the shadow rays in the lanes of `rough` that carry anything.
    #[inline(always)]
    pub(super) fn queue_shadows(&mut self, shadow: &ShadowRays, rough: f32x8, radiance: &mut [Rgb8]) {
        // What is not a number is wanted, too: it arrives, and the film counts it.
        let wanted = (rough & !shadow.value.max_component().simd_le(f32x8::ZERO)).to_bitmask();
        self.shadows.fill(shadow, wanted);
        if self.shadows.lanes() == 8 {
            self.trace_shadows(radiance);
        }
    }

    pub(super) fn trace_shadows(&mut self, radiance: &mut [Rgb8]) {
        self.traffic.shadow_packets += 1;
        self.traffic.shadow_rays += u64::from(self.shadows.lanes());
        let rays = self.shadows.rays();
        let free = match self.tracer.scene().is_cut_out() {
            true => self.shadows.dim(cutout::transmitted(&mut self.tracer, &rays)),
            false => !self.tracer.occluded(&rays),
        };
        self.shadows.deliver(free, radiance);
        self.shadows.pass();
    }
}

/// Paths of batch `number` of a stream that have met nothing yet.
pub(super) fn begin(batch: &Batch8, number: usize, origin: Vec3x8, direction: Vec3x8) -> Paths {
    Paths {
        origin,
        direction,
        throughput: Vec3x8::splat([1.0; 3]),
        density: f32x8::splat(f32::INFINITY),
        compression: f32x8::ONE,
        normal: u32x8::ZERO,
        index: batch.index,
        key: batch.key,
        slot: u32x8::splat(8 * number as u32) + u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]),
        lanes: batch.lanes.clamp(1, 8),
    }
}

/// An integrator that follows paths bounce by bounce, with a path tracer's queue and shadow rays.
pub(super) trait Wavefront<'a> {
    /// The path tracer it works with.
    fn paths(&mut self) -> &mut PathTracer<'a>;

    /// Fills the queue with the first rays of `batches`; returns the depth that they are of.
    fn start(&mut self, batches: &[Batch8], _radiance: &mut [Rgb8]) -> u32 {
        self.paths().start(batches);
        1
    }

    /// Takes one packet through one bounce.
    fn bounce(&mut self, paths: &Paths, depth: u32, radiance: &mut [Rgb8]);

    /// Traces what is left when the last bounce is over, but for shadow rays.
    fn finish(&mut self, _radiance: &mut [Rgb8]) {}
}

/// The radiance of many samples: as many at once as the queue has room for, NaN if it has none.
pub(super) fn stream<'a>(integrator: &mut impl Wavefront<'a>, batches: &[Batch8], radiance: &mut [Rgb8]) {
    let capacity = integrator.paths().queue.capacity();
    if capacity == 0 {
        let nan = f32x8::splat(f32::NAN);
        radiance.fill(Rgb8 { r: nan, g: nan, b: nan });
        return;
    }
    for (batches, radiance) in batches.chunks(capacity).zip(radiance.chunks_mut(capacity)) {
        radiance.fill(Rgb8::default());
        let first = integrator.start(batches, radiance);
        for depth in first..=integrator.paths().max_depth {
            for i in 0..integrator.paths().queue.len() {
                let paths = integrator.paths().queue.packet(i);
                integrator.bounce(&paths, depth, radiance);
            }
            integrator.paths().queue.turn();
        }
        integrator.finish(radiance);
        if integrator.paths().shadows.lanes() > 0 {
            integrator.paths().trace_shadows(radiance);
        }
    }
}

/// The radiance of eight samples, by [`stream`].
pub(super) fn radiance<'a>(integrator: &mut impl Wavefront<'a>, batch: &Batch8) -> Rgb8 {
    let mut out = [Rgb8::default()];
    stream(integrator, core::slice::from_ref(batch), &mut out);
    out[0]
}

impl<'a> Wavefront<'a> for PathTracer<'a> {
    fn paths(&mut self) -> &mut PathTracer<'a> {
        self
    }

    fn bounce(&mut self, paths: &Paths, depth: u32, radiance: &mut [Rgb8]) {
        let rays = paths.rays(self.tracer.scene());
        self.traffic.packets += 1;
        self.traffic.rays += u64::from(paths.lanes);
        let hits = cutout::closest(&mut self.tracer, &rays, paths.chance(depth));
        self.add_sky(paths, &hits, depth, radiance);
        if !hits.any() {
            return;
        }
        let surface = SurfacePoints::at(self.tracer.scene(), &rays, &hits);
        self.add_emission(paths, &surface, &hits, radiance);
        if depth >= self.max_depth {
            return;
        }
        let mut next = *paths;
        let rough = surface.scatters(Scattering::Rough);
        if rough.any() {
            self.scatter_rough(&mut next, &surface, rough, depth, radiance);
        }
        if (surface.hit & !rough).any() {
            let (choice, _) = sobol::point(paths.index, paths.key, SETS * depth);
            scatter_specular(&mut next, &surface, choice);
        }
        reject_nan(&next, surface.hit, radiance);
        let alive = survivors(&mut next, surface.hit, depth);
        next.origin = surface.leave(next.direction);
        if depth + 1 == self.max_depth && light::are_few(self.tracer.scene()) {
            self.end_on_lights(&next, alive, radiance);
        } else {
            self.queue.push(&next, alive.to_bitmask());
        }
    }
}

impl Integrand for PathTracer<'_> {
    fn radiance(&mut self, batch: &Batch8) -> Rgb8 {
        radiance(self, batch)
    }

    fn stream(&mut self, batches: &[Batch8], radiance: &mut [Rgb8]) {
        stream(self, batches, radiance);
    }
}

#[cfg(test)]
mod tests;
