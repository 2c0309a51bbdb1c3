//! A frame's guided picture: the film filtered by what the scene shows, and given its energy back.
//!
//! Memory while it is made, besides the features: 100 bytes a pixel and a margin for the filter, 16 for the guide.

use super::memory::zeros;
use super::threads::{self, each};
use crate::error::Error;
use pmcip_core::sampler::Sampler;
use pmcip_core::sampler::guide::{Band, Feature, Filter};
use rayon::ThreadPool;

/// Rows that a thread writes at once.
const ROWS: usize = 8;

/// A frame's filtered film, rows from the top.
#[derive(Debug)]
pub struct Filtered<'a> {
    /// Columns and rows.
    pub size: (u32, u32),
    /// Radiance.
    pub rgb: Vec<[f32; 3]>,
    /// [`Filter::variance`].
    pub variance: Vec<f32>,
    /// What the pixels show.
    pub features: &'a [Feature],
}

/// Writes the guided picture of a film that is at rest, on all threads of `pool`, on the caller's if there is none. `change`
/// may change what was filtered: energy is given back afterwards.
///
/// # Errors
/// [`Error::Setting`] if the film has not accumulated for it or has not one feature a pixel, [`Error::Work`] if memory
/// is lacking, and what `change` returns.
pub fn resolve(
    film: &Sampler<'_>,
    features: &[Feature],
    pool: Option<&ThreadPool>,
    change: &mut dyn FnMut(&mut Filtered<'_>) -> Result<(), Error>,
    rgb: &mut [[f32; 3]],
) -> Result<(), Error> {
    let mut filtered = filtered(film, features, pool)?;
    let mut scratch = zeros(Sampler::resolve_scratch(filtered.size.0, filtered.size.1))?;
    threads::resolve(pool, film.leveling(&filtered.rgb, &mut scratch, rgb).map_err(Error::setting)?);
    filtered.rgb.copy_from_slice(rgb);
    change(&mut filtered)?;
    let resolving = film.resolving_guided(&filtered.rgb, &mut scratch, rgb).map_err(Error::setting)?;
    threads::resolve(pool, resolving);
    Ok(())
}

/// The film, filtered.
fn filtered<'a>(
    film: &Sampler<'_>,
    features: &'a [Feature],
    pool: Option<&ThreadPool>,
) -> Result<Filtered<'a>, Error> {
    let size = (film.settings().width, film.settings().height);
    let mut scratch = zeros(Filter::required_by(film))?;
    let mut filter = Filter::new(film, features, &mut scratch).map_err(Error::setting)?;
    for _ in 0..Filter::PASSES {
        each(pool, filter.bands().collect(), |mut band: Band<'_>| band.filter());
        filter.next();
    }
    let (mut rgb, mut variance) = (zeros(features.len())?, zeros(features.len())?);
    let parts = rgb.chunks_mut(ROWS * size.0 as usize).enumerate().collect();
    // They are whole rows of this picture: it is not refused.
    each(pool, parts, |(part, rows)| _ = filter.write_rows(part * ROWS, rows));
    filter.variance(&mut variance).map_err(Error::setting)?;
    Ok(Filtered { size, rgb, variance, features })
}
