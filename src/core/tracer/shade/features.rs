//! What is seen without light: albedo, normal and depth of the first rough surface, pixel by pixel.
//!
//! Eight rays a pixel, stratified over it, follow mirrors and smooth glass: at glass the way most light takes, so that chance
//! does not enter. Albedo is tinted by what it is seen in; that of the sky is its radiance, up to 1. No lights, no
//! shadows: a pixel costs one packet of coherent rays, and one more for every segment of a chain. The points are the same
//! in every frame, whatever its seed; see [`Feature`] for what comes out.

use super::cutout;
use super::hit::SurfacePoints;
use super::path::begin;
use super::queue::Paths;
use super::sky;
use super::vertex::scatter_specular;
use crate::maths::sobol::{self, PixelKeys};
use crate::maths::vec3::Vec3x8;
use crate::sampler::batch::Batch8;
use crate::sampler::guide::Feature;
use crate::tracer::camera::{Camera, Primary};
use crate::tracer::scene::{Scattering, Scene};
use crate::tracer::trace::Tracer;
use wide::{f32x8, u32x8};

/// Key of the points: its own, so that features are independent of the samples.
const SEED: u32 = 0xfea7;

/// Sees features of a scene.
pub struct Features<'a> {
    tracer: Tracer<'a>,
    camera: Camera,
    max_depth: u32,
}

/// What eight rays have met so far.
#[derive(Clone, Copy, Default)]
struct Seen {
    albedo: Vec3x8,
    normal: Vec3x8,
    depth: f32x8,
    /// 1 where the ray itself has met anything.
    covered: f32x8,
}

impl<'a> Features<'a> {
    /// Features of `scene` seen through `camera`, after chains of mirrors and glass of up to `max_depth` segments. Where a
    /// chain is longer the last surface counts.
    pub fn new(scene: Scene<'a>, camera: Camera, max_depth: u32) -> Self {
        Features { tracer: Tracer::new(scene), camera, max_depth }
    }

    /// Writes the features of the leftmost pixels of row `y`, as many as there is room for, and for as many of them as there
    /// is room for in `coverage` the part of the pixel where any surface is seen, 0 to 1 in eighths.
    pub fn row(&mut self, y: u32, out: &mut [Feature], coverage: &mut [f32]) {
        let mut coverage = coverage.iter_mut();
        for (x, out) in (0..).zip(out) {
            let seen = self.look(x, y);
            *out = seen.mean();
            coverage.next().into_iter().for_each(|coverage| *coverage = mean(seen.covered));
        }
    }

    /// Follows eight rays through a pixel.
    fn look(&mut self, x: u32, y: u32) -> Seen {
        let mut paths = self.start(x, y);
        let (mut seen, mut alive) = (Seen::default(), f32x8::splat(f32::from_bits(u32::MAX)));
        for segment in 0..self.max_depth {
            let t_max = alive.select(f32x8::splat(f32::INFINITY), f32x8::splat(-1.0));
            let rays = paths.rays_to(t_max, self.tracer.scene());
            let hits = cutout::closest(&mut self.tracer, &rays, paths.chance(segment + 1));
            seen.note_sky(self.tracer.scene(), &paths, alive & !hits.lanes(), segment == 0);
            if !hits.any() {
                break;
            }
            let surface = SurfacePoints::at(self.tracer.scene(), &rays, &hits);
            seen.depth += surface.hit & hits.t;
            if segment == 0 {
                seen.covered = surface.hit & f32x8::ONE;
            }
            seen.note(&paths, &surface);
            alive = surface.hit & !surface.scatters(Scattering::Rough);
            if !alive.any() {
                break;
            }
            scatter_specular(&mut paths, &surface, f32x8::HALF);
            paths.origin = surface.leave(paths.direction);
        }
        seen
    }

    /// Rays through the first eight points of a pixel's sequence.
    fn start(&self, x: u32, y: u32) -> Paths {
        let index = u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]);
        let key = PixelKeys::new(SEED, 0).at(u32x8::splat(y << 16 | x));
        let (u, v) = sobol::point(index, key, 0);
        let (x, y) = (f32x8::splat(x as f32) + u, f32x8::splat(y as f32) + v);
        let batch = Batch8 { lanes: 8, x, y, index, key };
        let Primary { origin, direction } = self.camera.rays(&batch);
        begin(&batch, 0, origin, direction)
    }
}

impl Seen {
    /// Replaces what was seen in the lanes that have met `surface`.
    #[inline(always)]
    fn note(&mut self, paths: &Paths, surface: &SurfacePoints) {
        let reflected = surface.diffuse + surface.specular;
        let shines = surface.emission.max_component().simd_gt(f32x8::ZERO);
        let albedo = Vec3x8::select(shines, Vec3x8::splat([1.0; 3]), reflected);
        self.note_albedo(paths, albedo, surface.hit);
        self.normal = Vec3x8::select(surface.hit, surface.normal, self.normal);
    }

    /// Replaces the albedo in the lanes that have `missed` everything by what the sky shows.
    fn note_sky(&mut self, scene: &Scene<'_>, paths: &Paths, missed: f32x8, is_first: bool) {
        match &scene.data().sky {
            Some(sky) if missed.any() && (sky.visible || !is_first) => {
                self.note_albedo(paths, capped(sky::radiance(sky, paths.direction)), missed);
            }
            _ => {}
        }
    }

    /// Replaces the albedo in `lanes`, tinted by what it is seen in.
    #[inline(always)]
    fn note_albedo(&mut self, paths: &Paths, albedo: Vec3x8, lanes: f32x8) {
        let tint = paths.throughput * (f32x8::ONE / paths.compression);
        self.albedo = Vec3x8::select(lanes, capped(albedo.scaled(tint)), self.albedo);
    }

    /// Means over the rays.
    fn mean(&self) -> Feature {
        Feature {
            albedo: [self.albedo.x, self.albedo.y, self.albedo.z].map(mean),
            normal: [self.normal.x, self.normal.y, self.normal.z].map(mean),
            depth: mean(self.depth),
        }
    }
}

/// Components up to 1.
#[inline(always)]
fn capped(v: Vec3x8) -> Vec3x8 {
    let one = f32x8::ONE;
    Vec3x8::new(v.x.fast_min(one), v.y.fast_min(one), v.z.fast_min(one))
}

/// The mean of eight numbers.
#[inline(always)]
fn mean(lanes: f32x8) -> f32 {
    lanes.to_array().iter().sum::<f32>() / 8.0
}
