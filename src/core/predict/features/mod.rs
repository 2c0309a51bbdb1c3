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
mod feature;
mod matching;
mod median;
mod octave;
mod picture;
mod strongest;

pub use feature::{DESCRIPTOR, Feature, UNIT};
pub use matching::{Match, matches};
pub use median::median3;
pub use picture::{Error, MAX_SIDE, MIN_SIDE, Picture, Settings};

use describe::Describer;
use extrema::Finder;
use octave::{LEVELS, Octave, blur_levels, halve, start};
use strongest::Strongest;

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
    settings.check()?;
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

#[cfg(test)]
mod tests;
