//! How far an image is from a reference, in numbers a viewer and a statistician can use.
//!
//! - **Err**: mean over pixels of e²/tvi(L), e the luminance error and L the reference's luminance in cd/m², tvi the
//!   threshold of vision (Ferwerda et al. 1996): the measure of Lai et al. 2010.
//! - **Low-pass Err**: the same after an 8×8 box average of the error image and of the reference. The box slides
//!   pixel by pixel and only where it lies wholly inside the image; a smaller image gets a smaller box.
//! - **MSE**, **relMSE** = e²/(ref² + 0.01), means over pixels and colour channels, in scene units, and both without
//!   the worst 0.1 % of pixels (rounded up, judged by each measure on its own).
//! - **Energy bias**: Σe/Σref in luminance, with its standard error.
//! - **Oracle ratio**: |P|·Σσ²w/(Σσ√w)², w = 1/tvi: what the best allocation for known variances gains over uniform
//!   sampling in Err.
//! - **Flicker**, of two frames of an animation: mean of (e_t − e_{t−1})²/tvi(L).
//!
//! ```
//! use pmcip::picture::{frame_io::Picture, metrics::measure};
//!
//! let grey = |value| Picture { width: 1, height: 1, rgb: vec![[value; 3]], ..Picture::default() };
//! let metrics = measure(&grey(1.1), &grey(1.0), 100.0)?;
//! assert!((metrics.mse - 0.01).abs() < 1e-6);
//! # Ok::<(), pmcip::error::Error>(())
//! ```
//!
//! Sums are in f64. Limits: the standard error takes pixels as independent. From a `variance` plane it is right for
//! `pooled`, too small for estimators that spread energy over a neighbourhood; many runs tell more than one.

use crate::error::Error;
use crate::picture::frame_io::Picture;
use pmcip_core::maths::tvi::tvi;
use wide::f32x8;

/// Side of the low-pass box in pixels.
const BOX: usize = 8;
/// Part of the pixels that the trimmed measures leave out.
const TRIMMED: f64 = 0.001;
/// What keeps relMSE finite in the dark.
const DARK: f64 = 0.01;

/// The measures of one image against one reference.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Metrics {
    /// Mean of e²/tvi, luminance in cd/m².
    pub err: f64,
    /// The same after an 8×8 box average.
    pub err_lowpass: f64,
    /// Mean of e² over pixels and channels.
    pub mse: f64,
    /// The same without the worst 0.1 % of pixels.
    pub mse_trimmed: f64,
    /// Mean of e²/(ref² + 0.01) over pixels and channels.
    pub rel_mse: f64,
    /// The same without the worst 0.1 % of pixels.
    pub rel_mse_trimmed: f64,
    /// Σe/Σref, luminance.
    pub energy_bias: f64,
    /// Standard error of the energy bias.
    pub energy_bias_stderr: f64,
    /// What an oracle would gain over uniform sampling, if the reference has a `variance` plane.
    pub oracle_ratio: Option<f64>,
}

/// Measures `image` against `reference`; `cd_per_unit` turns scene units into cd/m².
///
/// # Errors
/// [`Error::Sizes`] if the sizes differ, [`Error::NotFinite`] if a pixel is infinite or not a number.
pub fn measure(image: &Picture, reference: &Picture, cd_per_unit: f64) -> Result<Metrics, Error> {
    check(image, reference)?;
    let luminances = |picture: &Picture| picture.rgb.iter().map(|&rgb| luminance(rgb)).collect::<Vec<f64>>();
    let (seen, truth) = (luminances(image), luminances(reference));
    let error: Vec<f64> = seen.iter().zip(&truth).map(|(a, b)| a - b).collect();
    let width = image.width as usize;
    let (squares, relative) = (channel_means(image, reference, 0.0), channel_means(image, reference, DARK));
    let (energy_bias, energy_bias_stderr) =
        energy_bias(&error, &truth, pixel_variance(image, reference).as_deref());
    Ok(Metrics {
        err: err(&error, &truth, cd_per_unit),
        err_lowpass: err(&box_average(&error, width), &box_average(&truth, width), cd_per_unit),
        mse: mean(&squares),
        mse_trimmed: trimmed_mean(squares),
        rel_mse: mean(&relative),
        rel_mse_trimmed: trimmed_mean(relative),
        energy_bias,
        energy_bias_stderr,
        oracle_ratio: sample_variance(reference).map(|variance| oracle_ratio(&variance, &truth, cd_per_unit)),
    })
}

/// The luminance error of every pixel of a frame, for [`flicker`].
#[derive(Clone, Debug, PartialEq)]
pub struct Errors {
    error: Vec<f64>,
    truth: Vec<f64>,
}

impl Errors {
    /// The errors of `image` against `reference`, which must have the same size.
    ///
    /// # Errors
    /// As [`measure`].
    pub fn new(image: &Picture, reference: &Picture) -> Result<Errors, Error> {
        check(image, reference)?;
        let truth: Vec<f64> = reference.rgb.iter().map(|&rgb| luminance(rgb)).collect();
        let error = image.rgb.iter().zip(&truth).map(|(&rgb, truth)| luminance(rgb) - truth).collect();
        Ok(Errors { error, truth })
    }
}

/// Flicker from one frame to the next: mean over pixels of (e_t − e_{t−1})²/tvi(L), L the mean of the two references.
///
/// Where two frames have independent noise it is about the sum of their Err; noise that stays the same does not
/// flicker. (With the later reference alone as L, noise of a bright object would be judged by a black background that
/// it has just uncovered.) Frames of different sizes have none: not a number.
pub fn flicker(before: &Errors, now: &Errors, cd_per_unit: f64) -> f64 {
    if before.error.len() != now.error.len() {
        return f64::NAN;
    }
    let pairs = |a: &[f64], b: &[f64], f: fn(f64, f64) -> f64| -> Vec<f64> {
        a.iter().zip(b).map(|(a, b)| f(*a, *b)).collect()
    };
    let change = pairs(&now.error, &before.error, |now, before| now - before);
    let level = pairs(&now.truth, &before.truth, |now, before| 0.5 * (now + before));
    err(&change, &level, cd_per_unit)
}

/// Luminance of linear Rec. 709 colour.
pub fn luminance([r, g, b]: [f32; 3]) -> f64 {
    0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
}

fn check(image: &Picture, reference: &Picture) -> Result<(), Error> {
    let (a, b) = ((image.width, image.height), (reference.width, reference.height));
    if a != b {
        return Err(Error::Sizes { image: a, reference: b });
    }
    for (which, picture) in [("image", image), ("reference", reference)] {
        let count = picture.broken_pixels();
        if count > 0 {
            return Err(Error::NotFinite { which, count });
        }
    }
    Ok(())
}

/// Mean of e²/tvi(L) for errors and luminances in scene units.
fn err(error: &[f64], truth: &[f64], cd_per_unit: f64) -> f64 {
    let terms = error.iter().zip(truth).map(|(e, l)| (e * cd_per_unit).powi(2) * acuity(*l, cd_per_unit));
    terms.sum::<f64>() / error.len() as f64
}

/// One over the threshold of vision at a luminance in scene units.
pub fn acuity(truth: f64, cd_per_unit: f64) -> f64 {
    1.0 / f64::from(tvi(f32x8::splat((truth * cd_per_unit) as f32)).to_array()[0])
}

/// Averages over a sliding box, for each position where it lies inside the image.
fn box_average(values: &[f64], width: usize) -> Vec<f64> {
    let rows: Vec<Vec<f64>> = values.chunks_exact(width).map(slide).collect();
    let columns = (0..rows[0].len()).map(|x| slide(&rows.iter().map(|row| row[x]).collect::<Vec<f64>>()));
    columns.flatten().collect()
}

/// Means over boxes of `radius` around every pixel, over the part that lies inside the image.
pub(crate) fn box_mean(values: &[f64], width: usize, radius: usize) -> Vec<f64> {
    let along = |values: &[f64], width: usize| -> Vec<f64> {
        // Each row becomes a column, so that twice the same pass is both ways.
        let height = values.len() / width;
        let mut out = vec![0.0; values.len()];
        for (y, row) in values.chunks_exact(width).enumerate() {
            for x in 0..width {
                out[x * height + y] = mean(&row[x.saturating_sub(radius)..(x + radius + 1).min(width)]);
            }
        }
        out
    };
    let height = values.len() / width;
    along(&along(values, width), height)
}

fn slide(values: &[f64]) -> Vec<f64> {
    values.windows(BOX.min(values.len())).map(mean).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Each pixel's mean over channels of e²/(ref² + dark); of e² alone if `dark` is 0.
fn channel_means(image: &Picture, reference: &Picture, dark: f64) -> Vec<f64> {
    let term = |a: f32, b: f32| {
        let (a, b) = (f64::from(a), f64::from(b));
        (a - b).powi(2) / if dark > 0.0 { b * b + dark } else { 1.0 }
    };
    let pixels = image.rgb.iter().zip(&reference.rgb);
    pixels.map(|(a, b)| (0..3).map(|i| term(a[i], b[i])).sum::<f64>() / 3.0).collect()
}

/// Mean without the largest 0.1 %, rounded up.
fn trimmed_mean(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    let worst = (values.len() as f64 * TRIMMED).ceil() as usize;
    mean(&values[..(values.len() - worst).max(1)])
}

/// Variance of the error of each pixel, from the planes of the image and, if it has one, of the reference.
fn pixel_variance(image: &Picture, reference: &Picture) -> Option<Vec<f64>> {
    let own = variance(image)?;
    let other = variance(reference).unwrap_or_else(|| vec![0.0; own.len()]);
    Some(own.into_iter().zip(other).map(|(a, b)| a + b).collect())
}

/// The plane of this name; values that no variance can have count as nothing known, hence 0.
fn variance(picture: &Picture) -> Option<Vec<f64>> {
    let sane = |value: &f32| if (0.0..=f32::MAX).contains(value) { f64::from(*value) } else { 0.0 };
    Some(picture.planes.get("variance")?.iter().map(sane).collect())
}

/// Σe/Σref and its standard error, from the pixels' variances or else from the spread of the errors.
fn energy_bias(error: &[f64], truth: &[f64], variance: Option<&[f64]>) -> (f64, f64) {
    let energy: f64 = truth.iter().sum();
    let shift = mean(error);
    let total = match variance {
        Some(variance) => variance.iter().sum(),
        None => error.iter().map(|e| (e - shift).powi(2)).sum::<f64>(),
    };
    (error.iter().sum::<f64>() / energy, total.sqrt() / energy)
}

/// Variance of a single sample in each pixel, up to a common factor: that of the mean times the count.
fn sample_variance(picture: &Picture) -> Option<Vec<f64>> {
    let mut variance = variance(picture)?;
    if let Some(count) = picture.planes.get("count") {
        variance.iter_mut().zip(count).for_each(|(variance, count)| *variance *= f64::from(count.max(0.0)));
    }
    Some(variance)
}

/// |P|·Σσ²w/(Σσ√w)², w = 1/tvi, from samples' variances σ² and luminances in scene units: what n ∝ σ√w would gain in Err over
/// uniform sampling of as many samples. 1 if nothing varies.
pub fn oracle_ratio(variance: &[f64], truth: &[f64], cd_per_unit: f64) -> f64 {
    oracle(variance, truth, std::iter::repeat(1.0), cd_per_unit)
}

/// Σc·Σσ²w/(Σσ√(wc))², c what a sample of the pixel costs: what n ∝ σ√(w/c) would gain in Err over uniform sampling of the
/// same cost. 1 if nothing varies, or of no length.
pub fn oracle_ratio_at_cost(variance: &[f64], truth: &[f64], cost: &[f32], cd_per_unit: f64) -> f64 {
    oracle(variance, truth, cost.iter().map(|cost| f64::from(*cost)), cd_per_unit)
}

fn oracle(variance: &[f64], truth: &[f64], cost: impl Iterator<Item = f64>, cd_per_unit: f64) -> f64 {
    let (mut costs, mut sum, mut roots) = (0.0, 0.0, 0.0);
    for ((v, l), cost) in variance.iter().zip(truth).zip(cost) {
        let term = v * acuity(*l, cd_per_unit);
        costs += cost;
        sum += term;
        roots += (term * cost).sqrt();
    }
    if sum > 0.0 && roots > 0.0 { costs * sum / (roots * roots) } else { 1.0 }
}

/// [`oracle_ratio_at_cost`] of a reference, if it has a `variance` plane and `cost` as many entries as pixels.
pub fn oracle_of(reference: &Picture, cost: &[f32], cd_per_unit: f64) -> Option<f64> {
    let truth: Vec<f64> = reference.rgb.iter().map(|&rgb| luminance(rgb)).collect();
    let variance = sample_variance(reference).filter(|_| cost.len() == truth.len())?;
    Some(oracle_ratio_at_cost(&variance, &truth, cost, cd_per_unit))
}
