//! A picture to be searched, and how.

/// Smallest side of a picture.
pub const MIN_SIDE: usize = 16;
/// Largest side of a picture.
pub const MAX_SIDE: usize = 16_384;

/// A plane of values row by row, with its size.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    pub(super) values: &'a [f32],
    pub(super) width: usize,
    pub(super) height: usize,
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

/// Why a picture has not been searched.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// A side is not in [`MIN_SIDE`] … [`MAX_SIDE`], or there are not width · height values.
    Size,
    /// A setting is out of its range.
    Settings,
    /// Less scratch than [`required`](super::required).
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

impl Settings {
    /// What can be wrong with them.
    pub(super) fn check(&self) -> Result<(), Error> {
        let fine = (0.8..=4.0).contains(&self.blur)
            && (0.0..=f32::MAX).contains(&self.contrast)
            && (1.0..=f32::MAX).contains(&self.edge);
        if fine { Ok(()) } else { Err(Error::Settings) }
    }
}
