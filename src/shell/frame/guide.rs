//! A frame's guided picture: the film filtered by what the scene shows, and given its energy back.
//!
//! Memory while it is made: 28 bytes a pixel for the features, 100 and a margin for the filter, 12 for the guide.

use super::memory::zeros;
use crate::error::Error;
use pmcip_core::sampler::Sampler;
use pmcip_core::sampler::guide::{Band, Feature, Filter};
use pmcip_core::tracer::camera::Camera;
use pmcip_core::tracer::scene::Scene;
use pmcip_core::tracer::shade::features::Features;
use rayon::ThreadPool;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// Rows of features that a thread sees at once.
const ROWS: usize = 8;

/// What a frame shows, to be seen without light.
#[derive(Clone, Copy)]
pub struct Sight<'a> {
    /// The scene.
    pub scene: Scene<'a>,
    /// The frame's camera.
    pub camera: Camera,
    /// Longest chain of mirrors and glass.
    pub max_depth: u32,
}

/// Writes the guided picture of a film that is at rest, on all threads of `pool`, on the caller's if there is none.
///
/// # Errors
/// [`Error::Setting`] if the film has not accumulated for it, [`Error::Work`] if memory is lacking.
pub fn resolve(
    film: &Sampler<'_>,
    sight: Sight<'_>,
    pool: Option<&ThreadPool>,
    rgb: &mut [[f32; 3]],
) -> Result<(), Error> {
    let features = features(sight, film.settings().width, rgb.len(), pool)?;
    let mut guide = filtered(film, &features, pool)?;
    let (width, height) = (film.settings().width, film.settings().height);
    let mut scratch = zeros(Sampler::resolve_scratch(width, height))?;
    film.level(&guide, &mut scratch, rgb).map_err(Error::setting)?;
    guide.copy_from_slice(rgb);
    film.resolve_guided(&guide, &mut scratch, rgb).map_err(Error::setting)
}

/// What all pixels show.
fn features(
    sight: Sight<'_>,
    width: u32,
    pixels: usize,
    pool: Option<&ThreadPool>,
) -> Result<Vec<Feature>, Error> {
    let mut features: Vec<Feature> = zeros(pixels)?;
    let width = width as usize;
    each(pool, features.chunks_mut(ROWS * width).enumerate().collect(), |(part, rows)| {
        let mut eye = Features::new(sight.scene, sight.camera, sight.max_depth);
        for (dy, row) in rows.chunks_mut(width).enumerate() {
            eye.row((part * ROWS + dy) as u32, row);
        }
    });
    Ok(features)
}

/// The film, filtered.
fn filtered(
    film: &Sampler<'_>,
    features: &[Feature],
    pool: Option<&ThreadPool>,
) -> Result<Vec<[f32; 3]>, Error> {
    let mut scratch = zeros(Filter::required(film.settings().width, film.settings().height))?;
    let mut filter = Filter::new(film, features, &mut scratch).map_err(Error::setting)?;
    for _ in 0..Filter::PASSES {
        each(pool, filter.bands().collect(), |mut band: Band<'_>| band.filter());
        filter.next();
    }
    let mut guide = zeros(features.len())?;
    filter.write(&mut guide).map_err(Error::setting)?;
    Ok(guide)
}

/// Works on all parts, on all threads.
fn each<T: Send>(pool: Option<&ThreadPool>, parts: Vec<T>, work: impl Fn(T) + Send + Sync) {
    match pool {
        Some(pool) => pool.install(|| parts.into_par_iter().for_each(work)),
        None => parts.into_iter().for_each(work),
    }
}
