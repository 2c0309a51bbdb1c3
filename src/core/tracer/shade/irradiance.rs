//! Irradiance: the light that falls on points of surfaces, as lightmaps keep it.
//!
//! A white diffuse surface sends out its irradiance over π, whatever the direction. So a sample is π times the light of a path
//! that begins at such a surface instead of a camera: with next-event estimation, multiple importance sampling and Russian
//! roulette as the [path tracer](super::path) has them.

use super::hit::SurfacePoints;
use super::path::{Packet, PathTracer, Wavefront, begin, radiance, stream};
use super::queue::Paths;
use super::vertex::{reject_nan, survivors};
use crate::maths::vec3::Vec3x8;
use crate::sampler::batch::{Batch8, Integrand, Rgb8};
use crate::tracer::scene::Scene;
use core::f32::consts::PI;
use wide::f32x8;

pub use super::site::Sites;

/// A plane whose points are points of surfaces: a lightmap's atlas.
pub trait Unwrapped {
    /// The points of surfaces at eight places of the plane, in pixels.
    fn sites(&self, x: f32x8, y: f32x8) -> Sites;
}

impl<U: Unwrapped + ?Sized> Unwrapped for &U {
    fn sites(&self, x: f32x8, y: f32x8) -> Sites {
        (**self).sites(x, y)
    }
}

/// The irradiance at points of an [`Unwrapped`] plane. Implements [`Integrand`].
pub struct Irradiance<'a, U> {
    paths: PathTracer<'a>,
    plane: U,
}

impl<'a, U: Unwrapped> Irradiance<'a, U> {
    /// Irradiance in `scene`, in its units of radiance times steradians, by paths of up to `max_depth` segments, counted as if
    /// the point were seen by a camera: 2 is direct light only. What moves stays where it is as the shutter opens.
    ///
    /// `memory` is scratch, as [`PathTracer::required`] says. With less than needed for one packet all is NaN.
    pub fn new(scene: Scene<'a>, plane: U, max_depth: u32, memory: &'a mut [Packet]) -> Self {
        Irradiance { paths: PathTracer::blind(scene.still(), max_depth, memory), plane }
    }
}

impl<'a, U: Unwrapped> Wavefront<'a> for Irradiance<'a, U> {
    fn paths(&mut self) -> &mut PathTracer<'a> {
        &mut self.paths
    }

    fn start(&mut self, batches: &[Batch8], radiance: &mut [Rgb8]) -> u32 {
        self.paths.queue.clear();
        for (number, batch) in batches.iter().enumerate() {
            let surface = SurfacePoints::white(&self.plane.sites(batch.x, batch.y));
            let mut next = begin(batch, number, surface.position, -surface.normal);
            next.throughput = Vec3x8::splat([PI; 3]);
            let used = super::queue::lane_mask((1 << next.lanes) - 1);
            self.paths.scatter_rough(&mut next, &surface, used, 1, radiance);
            reject_nan(&next, used, radiance);
            let alive = survivors(&mut next, used, 1);
            next.origin = surface.leave(next.direction);
            self.paths.queue.push(&next, alive.to_bitmask());
        }
        self.paths.queue.turn();
        2
    }

    fn bounce(&mut self, paths: &Paths, depth: u32, radiance: &mut [Rgb8]) {
        self.paths.bounce(paths, depth, radiance);
    }
}

impl<U: Unwrapped> Integrand for Irradiance<'_, U> {
    fn radiance(&mut self, batch: &Batch8) -> Rgb8 {
        radiance(self, batch)
    }

    fn stream(&mut self, batches: &[Batch8], radiance: &mut [Rgb8]) {
        stream(self, batches, radiance);
    }
}
