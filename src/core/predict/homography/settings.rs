//! How a homography is looked for, and what is found.

use super::mapping::Homography;

/// How far noise on the inliers may be magnified at the corners of their bounding box.
pub const MAX_GAIN: f64 = 10.0;

/// How [`estimate`](super::estimate) searches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Largest distance of an inlier in the second picture, in pixels; above 0.
    pub threshold: f64,
    /// Probability with which the search should have met a sample of inliers only; 0 to less than 1.
    pub confidence: f64,
    /// Most samples.
    pub max_iterations: u32,
    /// Picks the samples; any number.
    pub seed: u32,
}

impl Default for Settings {
    /// Threshold 3 pixels, confidence 0.995, 5000 samples.
    fn default() -> Self {
        Settings { threshold: 3.0, confidence: 0.995, max_iterations: 5_000, seed: 0 }
    }
}

/// What [`estimate`](super::estimate) found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// The mapping from the first picture to the second.
    pub homography: Homography,
    /// Pairs with an [error](Homography::error) of at most the threshold.
    pub inliers: u32,
    /// Estimated standard deviation of the inliers' noise in x and in y, in pixels of the second picture; at
    /// least a millionth of the spread of the points and at most twice the threshold.
    pub sigma: f64,
    /// Samples drawn.
    pub iterations: u32,
}
