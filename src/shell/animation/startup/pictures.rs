//! Finds out from two pictures where what is seen was a frame ago.

use crate::error::Error;
use crate::frame::memory::zeros;
use crate::picture::metrics::luminance;
use pmcip_core::predict::features::{self, Feature, MIN_SIDE, Picture};
use pmcip_core::predict::homography::{self, Block, Pair};
use pmcip_core::predict::tracks::{self, Tracks};
use pmcip_core::sampler::Sampler;
use pmcip_core::sampler::estimate::Estimator;

/// Most features of a picture.
const MAX_FEATURES: usize = 1000;
/// Ratio of the best to the second best descriptor distance.
const RATIO: f32 = 0.8;
/// Quantile of the kernel from which on it is dense.
const DENSE: f32 = 0.9;
/// Pixels of a dense region, at least.
const LEAST: u32 = 64;
/// Luminance that is white, over the picture's mean.
const WHITE: f64 = 4.0;

/// The film's luminance as it looks: display-coded, the median of 3 × 3 pixels, 0 to 1.
pub(super) fn coded(film: &Sampler<'_>) -> Result<Vec<f32>, Error> {
    let core = film.settings();
    let (width, height) = (core.width as usize, core.height as usize);
    let (mut rgb, mut plane): (Vec<f32>, Vec<f32>) = (zeros(3 * width * height)?, zeros(width * height)?);
    let mut scratch = zeros(Sampler::resolve_scratch(core.width, core.height))?;
    film.resolve(Estimator::Pooled, &mut scratch, &mut rgb).map_err(Error::work)?;
    let light: Vec<f64> = rgb.as_chunks::<3>().0.iter().map(|rgb| luminance(*rgb)).collect();
    let mean = light.iter().sum::<f64>() / light.len() as f64;
    let code = |light: &f64| (light.max(0.0) / (WHITE * mean.max(1e-12))).min(1.0).powf(1.0 / 2.2) as f32;
    let values: Vec<f32> = light.iter().map(code).collect();
    match Picture::new(&values, width, height) {
        Ok(picture) => features::median3(picture, &mut plane).map_err(Error::work).map(|()| plane),
        // Too small to be searched.
        Err(_) => Ok(values),
    }
}

/// Where every pixel of the picture `now` was in the picture `before`, whose kernel was `alpha`; not a number where
/// nothing matches.
pub(super) fn positions(
    now: &[f32],
    before: &[f32],
    alpha: &[f32],
    width: usize,
    height: usize,
) -> Result<Vec<[f32; 2]>, Error> {
    let mut positions = vec![[f32::NAN; 2]; now.len()];
    if width.min(height) < MIN_SIDE {
        return Ok(positions);
    }
    let mut scratch = zeros(features::required(width, height))?;
    let mut find = |plane: &[f32]| -> Result<Vec<Feature>, Error> {
        let picture = Picture::new(plane, width, height).map_err(Error::work)?;
        let mut found = zeros(MAX_FEATURES)?;
        let settings = features::Settings::default();
        let count = features::detect(picture, &settings, &mut scratch, &mut found).map_err(Error::work)?;
        found.truncate(count);
        Ok(found)
    };
    let (now, before) = (find(now)?, find(before)?);
    let mut pairs: Vec<Pair> = zeros(MAX_FEATURES)?;
    let count = tracks::pairs(&now, &before, RATIO, &mut pairs);
    pairs.truncate(count);
    let mut smooth = zeros(alpha.len())?;
    if let Ok(plane) = Picture::new(alpha, width, height) {
        features::median3(plane, &mut smooth).map_err(Error::work)?;
    }
    let (mut labels, mut sizes): (Vec<u32>, Vec<u32>) = (zeros(alpha.len())?, zeros(alpha.len())?);
    tracks::regions(&smooth, width, DENSE, LEAST, &mut labels, &mut sizes).map_err(Error::work)?;
    let (mut picked, mut blocks) = (pairs.clone(), vec![Block::default(); homography::required(count)]);
    let settings = homography::Settings::default();
    let tracks =
        Tracks::find(&pairs, &labels, width, &settings, &mut picked, &mut blocks).map_err(Error::work)?;
    tracks.positions(&labels, width, height, &mut positions).map_err(Error::work)?;
    Ok(positions)
}
