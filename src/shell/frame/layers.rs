//! The layers of a frame beside its picture, as planes by channel name.

use super::features::Seen;
use super::memory::zeros;
use super::settings::{Layer, Layers, Settings, word};
use super::threads;
use crate::error::Error;
use pmcip_core::sampler::Sampler;
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::guide::Feature;
use rayon::ThreadPool;
use std::collections::BTreeMap;

/// Depth where nothing is seen: behind everything, and still a number. Cycles has the same.
pub const NOTHING_SEEN: f32 = 1e10;

/// Checks that the film of a frame can make every layer asked for.
///
/// # Errors
/// [`Error::Setting`] that names the layer.
pub(super) fn check(settings: &Settings) -> Result<(), Error> {
    let estimator = settings.sampler.estimator;
    match settings.layers.iter().find(|layer| !layer.is_served_by(estimator)) {
        None => Ok(()),
        Some(layer) => Err(Error::Setting(format!(
            "the layer '{}' needs the estimator balanced, difference or guided, not {}",
            layer.name(),
            word(estimator)
        ))),
    }
}

/// Whether `layers` show what the scene looks like without light.
pub(super) fn need_features(layers: Layers) -> bool {
    layers.iter().any(|layer| matches!(layer, Layer::Albedo | Layer::Normal)) || need_coverage(layers)
}

/// Whether `layers` depend on how much of a pixel is covered.
pub(super) fn need_coverage(layers: Layers) -> bool {
    layers.contains(Layer::Coverage) || layers.contains(Layer::Depth)
}

/// Those of `layers` that film and scene make, by channel: rows from the top. `seen` is what [`need_features`] and
/// [`need_coverage`] ask for; where the eye sees the `sky` everything is covered. Pictures are made on all threads of `pool`, on
/// the caller's if there is none.
///
/// # Errors
/// [`Error::Setting`] if the film has not accumulated for one of them, [`Error::Work`] if memory is lacking.
pub(super) fn planes(
    film: &Sampler<'_>,
    seen: &Seen,
    sky: bool,
    layers: Layers,
    pool: Option<&ThreadPool>,
) -> Result<BTreeMap<String, Vec<f32>>, Error> {
    let mut planes = BTreeMap::new();
    for layer in layers.iter() {
        let channels = layer.channels().iter().map(|name| (*name).to_owned());
        planes.extend(channels.zip(values(film, seen, sky, layer, pool)?));
    }
    Ok(planes)
}

/// The planes of a layer in the order of its channels; none of a layer that is made elsewhere.
fn values(
    film: &Sampler<'_>,
    seen: &Seen,
    sky: bool,
    layer: Layer,
    pool: Option<&ThreadPool>,
) -> Result<Vec<Vec<f32>>, Error> {
    let of = |value: &dyn Fn(&Feature) -> f32| plane(&seen.features, value);
    match layer {
        Layer::Coverage => Ok(vec![plane(&seen.coverage, |coverage| if sky { 1.0 } else { *coverage })?]),
        Layer::Unbiased => colours(film, Estimator::Difference, pool),
        Layer::Balanced => colours(film, Estimator::Balanced, pool),
        Layer::Albedo => (0..3).map(|c| of(&|feature| feature.albedo[c])).collect(),
        Layer::Normal => (0..3).map(|c| of(&|feature| feature.normal[c])).collect(),
        Layer::Depth => Ok(vec![depth(seen)?]),
        Layer::Motion | Layer::Variance | Layer::Count | Layer::Kernel => Ok(Vec::new()),
    }
}

/// One number of each pixel.
fn plane<T>(pixels: &[T], value: impl Fn(&T) -> f32) -> Result<Vec<f32>, Error> {
    let mut plane = zeros(pixels.len())?;
    plane.iter_mut().zip(pixels).for_each(|(out, pixel)| *out = value(pixel));
    Ok(plane)
}

/// The film by an estimator, a plane a colour.
fn colours(
    film: &Sampler<'_>,
    estimator: Estimator,
    pool: Option<&ThreadPool>,
) -> Result<Vec<Vec<f32>>, Error> {
    let (width, height) = (film.settings().width, film.settings().height);
    let mut rgb: Vec<[f32; 3]> = zeros(width as usize * height as usize)?;
    resolve(film, estimator, pool, &mut rgb)?;
    (0..3).map(|c| plane(&rgb, |rgb| rgb[c])).collect()
}

/// Writes the picture by an estimator that needs the film alone, on all threads of `pool`, on the caller's if there is none.
///
/// # Errors
/// [`Error::Setting`] if the film has not accumulated for it, [`Error::Work`] if memory is lacking.
pub(crate) fn resolve(
    film: &Sampler<'_>,
    estimator: Estimator,
    pool: Option<&ThreadPool>,
    rgb: &mut [[f32; 3]],
) -> Result<(), Error> {
    let mut scratch = zeros(Sampler::resolve_scratch(film.settings().width, film.settings().height))?;
    let resolving =
        film.resolving(estimator, &mut scratch, rgb.as_flattened_mut()).map_err(Error::setting)?;
    threads::resolve(pool, resolving);
    Ok(())
}

/// The mean depth of what is seen: the rays that see nothing have none.
fn depth(seen: &Seen) -> Result<Vec<f32>, Error> {
    let mut depth = plane(&seen.features, |feature| feature.depth)?;
    for (depth, coverage) in depth.iter_mut().zip(&seen.coverage) {
        *depth = if *coverage > 0.0 { *depth / coverage } else { NOTHING_SEEN };
    }
    Ok(depth)
}
