//! What a sample of each pixel costs: the rays that it needs, primary, bounced and aimed at lights.
//!
//! Rays are counted, not timed, so that the same frame always says the same. All rays are taken to cost the same, and a sample
//! nothing besides its rays.

use super::memory::zeros;
use super::settings::{Integrator, Settings};
use super::threads::{each, start_threads};
use crate::error::Error;
use crate::scene::LoadedScene;
use pmcip_core::maths::sobol::{hash, point};
use pmcip_core::sampler::batch::{Batch8, Integrand};
use pmcip_core::tracer::scene::Scene;
use pmcip_core::tracer::shade::direct::{DirectLighting, Samples};
use pmcip_core::tracer::shade::path::{Packet, PathTracer, Traffic};
use wide::{f32x8, u32x8};

/// Key of the points: its own, so that costs are independent of the samples.
const SEED: u32 = 0xc057;

/// An integrand that counts its rays.
trait Counted: Integrand {
    fn counted(&self) -> Traffic;
}

impl Counted for PathTracer<'_> {
    fn counted(&self) -> Traffic {
        self.traffic()
    }
}

impl Counted for DirectLighting<'_> {
    fn counted(&self) -> Traffic {
        self.traffic()
    }
}

/// Rays a sample of every pixel needs, means of eight, rows from the top. None for photon maps, whose look-ups are no rays.
///
/// # Errors
/// [`Error::Setting`] if the core refuses scene or camera, [`Error::Work`] if threads or memory are lacking.
pub fn rays(
    scene: &LoadedScene,
    settings: &Settings,
    threads: Option<usize>,
) -> Result<Option<Vec<f32>>, Error> {
    let core = &settings.sampler;
    let (width, height, depth) = (core.width, core.height, settings.max_depth);
    let camera = settings.camera().map_err(Error::setting)?;
    let scene = Scene::new(scene.data()).map_err(Error::setting)?;
    let mut rays = zeros(width as usize * height as usize)?;
    let rows = rays.chunks_mut(width as usize).enumerate().collect();
    let pool = start_threads(threads)?;
    match settings.integrator {
        Integrator::Gather { .. } => return Ok(None),
        Integrator::Path => each(pool.as_ref(), rows, |(y, row)| {
            let mut memory = packets();
            count(&mut PathTracer::new(scene, camera, depth, &mut memory), y as u32, row);
        }),
        Integrator::Direct { light_samples, bsdf_samples } => each(pool.as_ref(), rows, |(y, row)| {
            let mut memory = packets();
            let samples = Samples { light: light_samples, bsdf: bsdf_samples };
            count(&mut DirectLighting::new(scene, camera, depth, samples, &mut memory), y as u32, row);
        }),
    }
    Ok(Some(rays))
}

/// Memory for eight samples at once.
fn packets() -> Vec<Packet> {
    vec![Packet::default(); PathTracer::required(8)]
}

/// Counts the rays of row `y`.
fn count(tracer: &mut impl Counted, y: u32, row: &mut [f32]) {
    let index = u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]);
    let total = |traffic: Traffic| traffic.rays + traffic.shadow_rays;
    for (x, rays) in (0..).zip(row) {
        let key = u32x8::splat(hash(hash(y << 16 | x) ^ SEED));
        let (u, v) = point(index, key, 0);
        let (x, y) = (f32x8::splat(x as f32) + u, f32x8::splat(y as f32) + v);
        let before = total(tracer.counted());
        tracer.radiance(&Batch8 { lanes: 8, x, y, index, key });
        *rays = (total(tracer.counted()) - before) as f32 / 8.0;
    }
}
