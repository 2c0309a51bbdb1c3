//! A frame's guided picture: the film filtered by what the scene shows, and given its energy back.
//!
//! Memory while it is made, besides the features: 100 bytes a pixel and a margin for the filter, 12 for the guide.

use super::memory::zeros;
use super::threads::each;
use crate::error::Error;
use pmcip_core::sampler::Sampler;
use pmcip_core::sampler::guide::{Band, Feature, Filter};
use rayon::ThreadPool;

/// Writes the guided picture of a film that is at rest, on all threads of `pool`, on the caller's if there is none.
///
/// # Errors
/// [`Error::Setting`] if the film has not accumulated for it or has not one feature a pixel, [`Error::Work`] if memory
/// is lacking.
pub fn resolve(
    film: &Sampler<'_>,
    features: &[Feature],
    pool: Option<&ThreadPool>,
    rgb: &mut [[f32; 3]],
) -> Result<(), Error> {
    let mut guide = filtered(film, features, pool)?;
    let (width, height) = (film.settings().width, film.settings().height);
    let mut scratch = zeros(Sampler::resolve_scratch(width, height))?;
    film.level(&guide, &mut scratch, rgb).map_err(Error::setting)?;
    guide.copy_from_slice(rgb);
    film.resolve_guided(&guide, &mut scratch, rgb).map_err(Error::setting)
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
