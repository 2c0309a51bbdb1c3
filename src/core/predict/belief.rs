//! What is believed of a pixel before a frame has seen it.

/// What is believed of a pixel.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Belief {
    /// Variance of a sample's luminance, scene units squared.
    pub variance: f32,
    /// Mean luminance, scene units.
    pub light: f32,
    /// Degrees of freedom of the variance: of how many samples more than one it could be. 0: nothing is known.
    pub freedom: f32,
}

impl Belief {
    /// Nothing is known.
    pub const NONE: Belief = Belief { variance: 0.0, light: 0.0, freedom: 0.0 };

    /// Itself if it can be used: finite, and of positive freedom.
    #[inline]
    pub fn usable(&self) -> Option<Belief> {
        let fine = (0.0..f32::MAX).contains(&self.variance) && self.light.is_finite();
        (fine && self.freedom > 0.0 && self.freedom < f32::MAX).then_some(*self)
    }
}

/// What a frame starts from.
#[derive(Clone, Copy, Debug)]
pub enum Prior<'a> {
    /// One belief a pixel; they fill in where the frame itself knows too little, in any iteration.
    Beliefs(&'a [Belief]),
    /// A kernel, as published: it takes the place of the frame's own. What is not a number is taken for the mean.
    Alpha(&'a [f32]),
}

/// Why there is no prediction.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// A plane has not as many entries as the picture has pixels, or the picture has no columns.
    Size,
    /// Lent memory is shorter than asked for.
    Scratch,
}

impl core::fmt::Display for Error {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Error::Size => "all planes of a prediction must have one entry a pixel",
            Error::Scratch => "lent memory is too short for a prediction",
        })
    }
}

impl core::error::Error for Error {}
