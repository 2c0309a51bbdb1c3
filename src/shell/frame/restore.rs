//! A picture from any denoiser, put on the energy of the frame that it was made of.
//!
//! The frame's file has the fair samples in its layer `unbiased`; see [`Pictures`] for what is done with them. The mean of all
//! samples, which only matters where the picture is black, is the layer `balanced`, or else the frame's picture.

use super::memory::zeros;
use super::settings::Layer;
use crate::error::Error;
use crate::picture::frame_io::Picture;
use crate::picture::metrics::luminance;
use pmcip_core::sampler::Sampler;
use pmcip_core::sampler::guide::Pictures;
use std::path::Path;

/// A picture and where it came from.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    /// The file, for what is said of it.
    pub path: &'a Path,
    /// What is in it.
    pub picture: &'a Picture,
}

/// A picture that has its energy back.
#[derive(Clone, Debug, PartialEq)]
pub struct Restored {
    /// Linear RGB, rows from the top.
    pub rgb: Vec<[f32; 3]>,
    /// Mean luminance of the unbiased picture.
    pub energy: f64,
    /// How far the energy of the denoised picture was off, over that of the unbiased one.
    pub bias_before: f64,
    /// How far that of `rgb` is.
    pub bias_after: f64,
}

/// Gives `denoised` the energy that the fair samples of `frame` have in every neighbourhood.
///
/// # Errors
/// [`Error::Read`] that names the file if it has another size than the frame, pixels that are not finite, or if the frame
/// lacks the layer `unbiased` or its radius of neighbourhoods; [`Error::Work`] if memory is lacking.
pub fn restore(frame: Source<'_>, denoised: Source<'_>) -> Result<Restored, Error> {
    let (width, height) = (frame.picture.width, frame.picture.height);
    if (denoised.picture.width, denoised.picture.height) != (width, height) {
        let (w, h) = (denoised.picture.width, denoised.picture.height);
        let reason = format!("it has {w}×{h} pixels, {} {width}×{height}", frame.path.display());
        return Err(Error::read(denoised.path, reason));
    }
    let unbiased = colours(frame.picture, Layer::Unbiased).ok_or_else(|| {
        Error::read(frame.path, "it has no layer 'unbiased': render it with --layers unbiased")
    })?;
    let balanced = colours(frame.picture, Layer::Balanced);
    let mean = balanced.as_ref().unwrap_or(&frame.picture.rgb);
    finite(denoised.path, &denoised.picture.rgb)?;
    [&unbiased, mean].into_iter().try_for_each(|rgb| finite(frame.path, rgb))?;
    let guide = &denoised.picture.rgb;
    let pictures =
        Pictures { width, height, balance_radius: balance_radius(frame)?, guide, unbiased: &unbiased, mean };
    let mut scratch = zeros(Sampler::resolve_scratch(width, height))?;
    let mut rgb = zeros(unbiased.len())?;
    pictures.restore(&mut scratch, &mut rgb).map_err(|reason| Error::read(frame.path, reason))?;
    let energy = energy(&unbiased);
    let bias = |rgb: &[[f32; 3]]| self::energy(rgb) / energy - 1.0;
    Ok(Restored { energy, bias_before: bias(guide), bias_after: bias(&rgb), rgb })
}

/// A layer of three colours, if the picture has it.
fn colours(picture: &Picture, layer: Layer) -> Option<Vec<[f32; 3]>> {
    let mut planes = layer.channels().iter().map(|channel| picture.planes.get(*channel));
    let [r, g, b] = [planes.next()??, planes.next()??, planes.next()??];
    Some(r.iter().zip(g).zip(b).map(|((r, g), b)| [*r, *g, *b]).collect())
}

/// The radius of neighbourhoods that a frame's file tells.
fn balance_radius(frame: Source<'_>) -> Result<u32, Error> {
    let told = frame.picture.attributes.get("balance_radius").and_then(|radius| radius.parse().ok());
    told.ok_or_else(|| {
        Error::read(frame.path, "it does not say its balance_radius: it is no frame of render")
    })
}

/// That no pixel is infinite or not a number.
fn finite(path: &Path, rgb: &[[f32; 3]]) -> Result<(), Error> {
    match rgb.iter().filter(|rgb| rgb.iter().any(|v| !v.is_finite())).count() {
        0 => Ok(()),
        count => Err(Error::read(path, format!("it has {count} pixels that are not finite"))),
    }
}

/// Mean luminance.
fn energy(rgb: &[[f32; 3]]) -> f64 {
    rgb.iter().map(|rgb| luminance(*rgb)).sum::<f64>() / rgb.len() as f64
}
