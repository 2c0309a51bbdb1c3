//! Points that can be found again in another picture of the same scene, and who is who among them.
//!
//! The scale-invariant features of Lowe (*Distinctive image features from scale-invariant keypoints*, 2004): extrema
//! of differences of Gaussians in place and scale, located between pixels and scales by a quadratic fit (Brown and
//! Lowe 2002), those of low contrast and on edges rejected; a dominant gradient direction; histograms of gradients
//! over 4 × 4 cells. Descriptors are compared by the Hellinger kernel (RootSIFT: Arandjelović and Zisserman, *Three
//! things everyone should know to improve object retrieval*, 2012), and a pair counts if it is clearly better than the
//! second best.
//!
//! Made for coarse frames of four samples a pixel, it differs from Lowe's in this:
//! - The picture is not doubled first: its finest scales are noise.
//! - Contrast and edge limits are lower; the ratio test removes what they let in.
//! - A descriptor cell is four scales wide, one more. Descriptor and direction sample a fixed grid of 16 × 16
//!   gradients, turned and scaled. A gradient is divided over the two histogram directions next to it by
//!   decomposition into these two, which needs no angle.
//! - Bright blobs are compared with bright ones and dark ones with dark ones only.
//!
//! A picture is a plane of numbers that look evenly spaced to the eye, 0 black and 1 white: display-coded luminance,
//! (L/L_white)^(1/2.2), serves. Values are clamped to 0 … 1, so that fireflies count as white, and what is not a number is
//! 0. Take [`median3`] first if there are single wild pixels. The same picture gives the same bits.
//!
//! ```
//! use pmcip_core::predict::features::{self, Feature, Picture, Settings};
//!
//! let (width, height) = (48, 40);
//! let mut values = [0.2; 48 * 40];
//! for (i, value) in values.iter_mut().enumerate() {
//!     let (x, y) = ((i % width) as f32 - 20.0, (i / width) as f32 - 18.0);
//!     *value += 0.6 / (1.0 + 0.02 * (x * x + y * y) * (x * x + y * y) / 16.0);
//! }
//! let picture = Picture::new(&values, width, height)?;
//! let mut scratch = [0.0; features::required(48, 40)];
//! let mut found = [Feature::default(); 16];
//! let count = features::detect(picture, &Settings::default(), &mut scratch, &mut found)?;
//! assert!(found[..count].iter().any(|f| (f.x - 20.5).abs() < 0.3 && (f.y - 18.5).abs() < 0.3));
//! # Ok::<(), features::Error>(())
//! ```

mod blur;
mod describe;
mod extrema;
mod matching;
mod median;
mod strongest;

pub use describe::{DESCRIPTOR, UNIT};
pub use matching::{Match, matches};
pub use median::median3;

use describe::Describer;
use extrema::Finder;
use strongest::Strongest;

/// Steps of scale an octave is divided into.
const STEPS: usize = 3;
/// Blurred pictures of an octave: two more than differences, which are two more than steps.
const LEVELS: usize = STEPS + 3;
/// Smallest side of a picture.
pub const MIN_SIDE: usize = 16;
/// Largest side of a picture.
pub const MAX_SIDE: usize = 16_384;
/// Blur that a picture is taken to have, in pixels.
const CAMERA_BLUR: f32 = 0.5;

/// A plane of values row by row, with its size.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    values: &'a [f32],
    width: usize,
    height: usize,
}

impl<'a> Picture<'a> {
    /// A view of `width · height` values.
    ///
    /// # Errors
    /// [`Error::Size`] if a side is not in [`MIN_SIDE`] … [`MAX_SIDE`] or the length differs.
    pub fn new(values: &'a [f32], width: usize, height: usize) -> Result<Self, Error> {
        let fits = |side| (MIN_SIDE..=MAX_SIDE).contains(&side);
        if !(fits(width) && fits(height)) || values.len() != width * height {
            return Err(Error::Size);
        }
        Ok(Picture { values, width, height })
    }
}

/// Which points are features.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Blur of the finest scale in pixels, 0.8 to 4. Lower finds smaller details, and more noise.
    pub blur: f32,
    /// Least difference of Gaussians, as part of white; 0 or more.
    pub contrast: f32,
    /// Largest ratio of the curvatures along and across an edge; 1 or more.
    pub edge: f32,
}

impl Default for Settings {
    /// Blur 1.4, contrast 0.0033, edge 20: chosen on frames of four samples a pixel.
    fn default() -> Self {
        Settings { blur: 1.4, contrast: 0.0033, edge: 20.0 }
    }
}

/// A point of a picture with its surroundings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feature {
    /// Position in pixels from the left edge; the first pixel's centre is 0.5.
    pub x: f32,
    /// Position in pixels from the upper edge.
    pub y: f32,
    /// Standard deviation in pixels of the Gaussian whose size the feature has.
    pub scale: f32,
    /// Dominant gradient direction in turns, 0 to 1, from the x axis towards the y axis.
    pub turn: f32,
    /// Difference of Gaussians: positive for a dark blob, negative for a bright one.
    pub response: f32,
    /// Square roots of a histogram of gradients: 4 × 4 cells of 8 directions; its norm is [`UNIT`] but for rounding.
    pub descriptor: [i16; DESCRIPTOR],
}

impl Default for Feature {
    fn default() -> Self {
        Feature { x: 0.0, y: 0.0, scale: 0.0, turn: 0.0, response: 0.0, descriptor: [0; DESCRIPTOR] }
    }
}

/// Why a picture has not been searched.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// A side is not in [`MIN_SIDE`] … [`MAX_SIDE`], or there are not width · height values.
    Size,
    /// A setting is out of its range.
    Settings,
    /// Less scratch than [`required`].
    Scratch,
}

impl core::fmt::Display for Error {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Error::Size => "a picture has 16 to 16384 pixels a side and as many values as pixels",
            Error::Settings => "blur must be 0.8 to 4, contrast 0 or more, the edge ratio 1 or more",
            Error::Scratch => "less scratch than features::required says",
        })
    }
}

impl core::error::Error for Error {}

/// Floats of scratch that [`detect`] needs for a picture of this size.
pub const fn required(width: usize, height: usize) -> usize {
    LEVELS * width * height + blur::row_len(width)
}

/// Finds features and writes them to `features`, in no particular order; returns how many.
///
/// If there are more than fit, those of the largest responses stay. A point with several dominant directions is several
/// features.
///
/// # Errors
/// [`Error::Settings`] or [`Error::Scratch`].
pub fn detect(
    picture: Picture<'_>,
    settings: &Settings,
    scratch: &mut [f32],
    features: &mut [Feature],
) -> Result<usize, Error> {
    check(settings)?;
    let (mut width, mut height) = (picture.width, picture.height);
    let scratch = scratch.get_mut(..required(width, height)).ok_or(Error::Scratch)?;
    let (planes, row) = scratch.split_at_mut(LEVELS * width * height);
    start(&picture, settings.blur, planes, row);
    let finder = Finder::new(settings);
    let describer = Describer::new();
    let mut found = Strongest::new(features);
    let mut pixel = 1.0;
    loop {
        let octave = &mut planes[..LEVELS * width * height];
        blur_levels(octave, (width, height), settings.blur, row);
        let octave = Octave { planes: octave, width, height };
        finder.find(&octave, |point| describer.describe(&octave, &point, settings.blur, pixel, &mut found));
        if width.min(height) < 2 * MIN_SIDE {
            return Ok(found.len());
        }
        (width, height) = halve(planes, width, height);
        pixel *= 2.0;
    }
}

/// What can be wrong with settings.
fn check(settings: &Settings) -> Result<(), Error> {
    let fine = (0.8..=4.0).contains(&settings.blur)
        && (0.0..=f32::MAX).contains(&settings.contrast)
        && (1.0..=f32::MAX).contains(&settings.edge);
    if fine { Ok(()) } else { Err(Error::Settings) }
}

/// The blurred pictures of one octave.
struct Octave<'a> {
    planes: &'a [f32],
    width: usize,
    height: usize,
}

impl Octave<'_> {
    /// One of the blurred pictures.
    fn level(&self, level: usize) -> &[f32] {
        let pixels = self.width * self.height;
        &self.planes[level * pixels..][..pixels]
    }
}

/// The picture, clamped and blurred, as the first level.
fn start(picture: &Picture<'_>, blur: f32, planes: &mut [f32], row: &mut [f32]) {
    let size = (picture.width, picture.height);
    let (target, rest) = planes.split_at_mut(picture.values.len());
    let source = &mut rest[..picture.values.len()];
    for (clamped, value) in source.iter_mut().zip(picture.values) {
        *clamped = if *value > 0.0 { value.min(1.0) } else { 0.0 };
    }
    let by = libm::sqrtf(blur * blur - CAMERA_BLUR * CAMERA_BLUR);
    blur::blur(source, target, size, by, row);
}

/// Every level from the one below it.
fn blur_levels(planes: &mut [f32], size: (usize, usize), first: f32, row: &mut [f32]) {
    let pixels = size.0 * size.1;
    for level in 1..LEVELS {
        let (done, rest) = planes.split_at_mut(level * pixels);
        let (old, new) = (level_blur(first, level as f32 - 1.0), level_blur(first, level as f32));
        let by = libm::sqrtf(new * new - old * old);
        blur::blur(&done[(level - 1) * pixels..], &mut rest[..pixels], size, by, row);
    }
}

/// Blur of a level in pixels of its octave.
fn level_blur(first: f32, level: f32) -> f32 {
    first * libm::exp2f(level / STEPS as f32)
}

/// Every second pixel of the level of twice the first one's blur becomes the first level of the next octave.
fn halve(planes: &mut [f32], width: usize, height: usize) -> (usize, usize) {
    let (target, source) = planes.split_at_mut(STEPS * width * height);
    let (half_width, half_height) = (width / 2, height / 2);
    for (target, source) in
        target.chunks_exact_mut(half_width).take(half_height).zip(source.chunks_exact(2 * width))
    {
        target.iter_mut().zip(source.iter().step_by(2)).for_each(|(to, from)| *to = *from);
    }
    (half_width, half_height)
}

#[cfg(test)]
mod tests;
