//! The light that falls on an atlas: samples where noise is, and none on texels that nothing touches.
//!
//! The core's film has the charts as islands: totals, kernel, filter and smoothing see one at a time.

use super::atlas::Atlas;
use super::dilate::dilate;
use crate::error::Error;
use crate::frame::attributes::attributes;
use crate::frame::memory::zeros;
use crate::frame::settings::Settings;
use crate::frame::threads::{self, Crew, start_threads};
use crate::frame::{guide, layers};
use crate::picture::frame_io::Picture;
use crate::scene::LoadedScene;
use pmcip_core::predict::Prior;
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::{Memory, Sampler, Schedule, Tally};
use pmcip_core::tracer::scene::Scene;
use std::time::Instant;

/// A baked atlas; planes are rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Lightmap {
    /// Texels a side.
    pub size: u32,
    /// Irradiance, in the scene's units of radiance times steradians. Around islands it is dilated, else black.
    pub irradiance: Vec<[f32; 3]>,
    /// Samples of each texel.
    pub count: Vec<u32>,
    /// The chart of each texel, 0 for none.
    pub labels: Vec<u16>,
    /// Samples accepted and rejected.
    pub tally: Tally,
    /// Wall time without loading and layout.
    pub seconds: f64,
}

impl Lightmap {
    /// As it goes to disk, with `mask` (1 where there is a surface) and `count`.
    pub fn picture(&self, scene: &LoadedScene, settings: &Settings) -> Picture {
        let mask = self.labels.iter().map(|label| f32::from(u8::from(*label != 0))).collect();
        let count = self.count.iter().map(|count| *count as f32).collect();
        Picture {
            width: self.size,
            height: self.size,
            rgb: self.irradiance.clone(),
            planes: [("mask".to_owned(), mask), ("count".to_owned(), count)].into(),
            attributes: attributes(scene, settings),
        }
    }

    /// Irradiance at a place in texels, interpolated between the four nearest.
    pub fn at(&self, [x, y]: [f32; 2]) -> [f32; 3] {
        let last = self.size as usize - 1;
        let split = |at: f32| {
            let at = (at - 0.5).clamp(0.0, last as f32);
            (at as usize, (at as usize + 1).min(last), at.fract())
        };
        let ((x0, x1, fx), (y0, y1, fy)) = (split(x), split(y));
        let texel = |x: usize, y: usize| self.irradiance[y * self.size as usize + x];
        let mix = |a: [f32; 3], b: [f32; 3], f: f32| [0, 1, 2].map(|c| a[c] + (b[c] - a[c]) * f);
        mix(mix(texel(x0, y0), texel(x1, y0), fx), mix(texel(x0, y1), texel(x1, y1), fx), fy)
    }
}

/// Bakes an atlas, by `settings` for a picture of its size, on `threads` threads, on all there are if that is `None`.
///
/// # Errors
/// [`Error::Setting`] if the core refuses the scene or a setting, [`Error::Work`] if threads or memory are lacking.
pub fn bake(
    atlas: &Atlas<'_>,
    scene: Scene<'_>,
    settings: &Settings,
    threads: Option<usize>,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Lightmap, Error> {
    let start = Instant::now();
    let crew = Crew::new(scene, settings, None, start_threads(threads)?)?;
    let required = Sampler::required_with_labels(atlas.size, atlas.size);
    let (mut floats, mut words) = (zeros(required.floats)?, zeros(required.words)?);
    let memory = Memory { floats: &mut floats, words: &mut words };
    let used = atlas.used() as u64;
    let mut film =
        Sampler::with_labels(settings.film_of(used), memory, &atlas.labels).map_err(Error::setting)?;
    let mut tally = Tally::default();
    for samples in Schedule::new(used, settings.spp, settings.pilot(), settings.iterations) {
        threads::begin(crew.pool(), &mut film, samples, Prior::Beliefs(&[])).map_err(Error::setting)?;
        crew.bake(film.jobs(), atlas, progress);
        tally = film.end().map_err(Error::work)?;
    }
    let texels = atlas.labels.len();
    let (mut irradiance, mut count) = (zeros(texels)?, zeros(texels)?);
    match settings.sampler.estimator {
        Estimator::Guided => {
            guide::resolve(&film, &atlas.features(), crew.pool(), &mut |_| Ok(()), &mut irradiance)?;
        }
        estimator => layers::resolve(&film, estimator, crew.pool(), &mut irradiance)?,
    }
    film.count(&mut count).map_err(Error::setting)?;
    dilate(&mut irradiance, &atlas.labels, atlas.size as usize);
    let (size, labels, seconds) = (atlas.size, atlas.labels.clone(), start.elapsed().as_secs_f64());
    Ok(Lightmap { size, irradiance, count, labels, tally, seconds })
}
