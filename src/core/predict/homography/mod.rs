//! The homography that most of a set of point pairs agree on, whatever the others say.
//!
//! 1. Points are moved and scaled to centroid 0 and mean distance √2 (Hartley, *In defense of the eight-point
//!    algorithm*, 1997), in each picture by itself.
//! 2. Random samples of four pairs each give a homography in closed form, if no three points are collinear and
//!    all four triples keep their orientation (a mapping of one view into another neither mirrors nor cuts
//!    through the horizon).
//! 3. A homography is scored on all pairs, eight at a time, by Σ max(0, 1 − r²/T²)², r the distance in the second
//!    picture. Wald's sequential test ends the scoring of a bad one after a few pairs (Matas and Chum, *Randomized
//!    RANSAC with sequential probability ratio test*, 2005).
//! 4. The best so far is refined at once (Chum, Matas, Kittler, *Locally optimized RANSAC*, 2003): residuals are
//!    taken for a mixture of a Gaussian of unknown σ and a uniform part, as in MLESAC (Torr and Zisserman,
//!    2000), and expectation and a Gauss-Newton step of maximisation alternate, so that σ shrinks to what the
//!    data say. The threshold only bounds it: it may be half the noise without harm.
//! 5. Samples end when a better one has become unlikely (Fischler and Bolles, 1981).
//! 6. The result must be better than chance (Moisan and Stival, *A probabilistic criterion to detect rigid point
//!    matches between two images*, 2004) and well determined: noise of one threshold on the inliers may not move
//!    the corners of their bounding box by more than [`MAX_GAIN`] thresholds. Pairs without which some parameter would
//!    be free do not count for that: an outlier beside points on a line always fits.
//!
//! Residuals are measured in the second picture only. Scores are computed in `f32`, homographies in `f64`. The same
//! pairs, settings and seed give the same bits. A fit allocates nothing; [`required`] says what it needs.
//!
//! ```
//! use pmcip_core::predict::homography::{self, Block, Pair, Settings};
//!
//! let grid = |i: u32| [f64::from(i % 5) * 40.0, f64::from(i / 5) * 30.0];
//! let pairs: [Pair; 25] = core::array::from_fn(|i| {
//!     let [x, y] = grid(i as u32);
//!     Pair { from: [x, y], to: [0.9 * x - 0.1 * y + 7.0, 0.1 * x + 0.9 * y - 3.0] }
//! });
//! let mut scratch = [Block::default(); homography::required(25)];
//! let fit = homography::estimate(&pairs, &Settings::default(), &mut scratch)?;
//! assert_eq!(fit.inliers, 25);
//! let [x, y] = fit.homography.apply([10.0, 20.0]).expect("in front of the horizon");
//! assert!((x - 14.0).abs() < 1e-6 && (y - 16.0).abs() < 1e-6);
//! # Ok::<(), homography::Error>(())
//! ```

mod minimal;
mod normal;
mod refine;
mod score;
mod search;

pub(crate) use minimal::{adjugate, determinant};
pub use score::Block;

/// Largest coordinate of a point, either way.
pub const MAX_COORDINATE: f64 = 1e6;
/// How far noise on the inliers may be magnified at the corners of their bounding box.
pub const MAX_GAIN: f64 = 10.0;

/// A 3 × 3 matrix, row by row.
pub(crate) type Matrix = [[f64; 3]; 3];

/// A point of the first picture and the one it corresponds to in the second, in pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pair {
    /// x and y in the first picture.
    pub from: [f64; 2],
    /// x and y in the second picture.
    pub to: [f64; 2],
}

/// A projective mapping of the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Homography {
    /// Maps (x, y, 1) to (x', y', 1)·w. The sign is such that w > 0 in front of the horizon; the scale is free.
    pub matrix: [[f64; 3]; 3],
}

impl Homography {
    /// The mapping that leaves every point where it is.
    pub const IDENTITY: Homography =
        Homography { matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] };

    /// The homography through four pairs, exactly.
    ///
    /// # Errors
    /// [`Error::Coordinate`], or [`Error::Degenerate`] if three points of a picture are (nearly) collinear or the
    /// pairs do not keep the orientation of every triple.
    pub fn through(pairs: &[Pair; 4]) -> Result<Homography, Error> {
        let frames = minimal::frames(pairs)?;
        let [from, to] = [0, 1].map(|side| pairs.map(|pair| frames[side].inward(minimal::side(&pair, side))));
        let matrix = minimal::through(&from, &to, minimal::MIN_AREA).ok_or(Error::Degenerate)?;
        Ok(minimal::outward(&matrix, &frames))
    }

    /// Where a point goes; nothing if it lies on or behind the horizon.
    #[inline]
    pub fn apply(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        let [a, b, w] = self.matrix.map(|row| row[0] * x + row[1] * y + row[2]);
        (w > 0.0).then(|| [a / w, b / w])
    }

    /// The mapping back; nothing if the matrix is singular.
    ///
    /// What `self` maps in front of the horizon, the inverse maps in front of it as well.
    pub fn inverse(&self) -> Option<Homography> {
        let determinant = minimal::determinant(&self.matrix);
        let matrix = minimal::adjugate(&self.matrix).map(|row| row.map(|entry| entry / determinant));
        matrix.iter().flatten().all(|entry| entry.is_finite()).then_some(Homography { matrix })
    }

    /// Distance in the second picture between where a pair's first point goes and its second point, in pixels;
    /// infinite behind the horizon.
    #[inline]
    pub fn error(&self, pair: &Pair) -> f64 {
        self.apply(pair.from).map_or(f64::INFINITY, |[x, y]| {
            let (x, y) = (x - pair.to[0], y - pair.to[1]);
            libm::sqrt(x * x + y * y)
        })
    }
}

/// How [`estimate`] searches.
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

/// What [`estimate`] found.
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

/// Why there is no homography.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// Fewer than four pairs, or more than 2^24.
    Pairs,
    /// A coordinate is not a number or beyond [`MAX_COORDINATE`].
    Coordinate,
    /// The threshold is not a positive number, or the confidence not in 0 … 1.
    Settings,
    /// Less scratch than [`required`].
    Scratch,
    /// Points coincide or lie on a line, so that no homography is determined.
    Degenerate,
    /// No homography has more inliers than chance would give it.
    NoConsensus,
}

impl core::fmt::Display for Error {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Error::Pairs => "a homography needs 4 to 2^24 pairs of points",
            Error::Coordinate => "coordinates of points must be numbers between -1e6 and 1e6",
            Error::Settings => "the threshold must be above 0 and the confidence from 0 to less than 1",
            Error::Scratch => "less scratch than homography::required says",
            Error::Degenerate => "the points coincide or lie on a line: they determine no homography",
            Error::NoConsensus => "no homography fits more pairs than chance would",
        })
    }
}

impl core::error::Error for Error {}

/// Blocks of scratch that [`estimate`] needs for a number of pairs.
pub const fn required(pairs: usize) -> usize {
    pairs.div_ceil(8)
}

/// Finds the homography on which most pairs agree within the threshold.
///
/// Exactly four pairs are taken as they are: nothing can check them.
///
/// # Errors
/// See [`Error`]; a result is never guessed.
pub fn estimate(pairs: &[Pair], settings: &Settings, scratch: &mut [Block]) -> Result<Fit, Error> {
    check(pairs, settings)?;
    let scratch = scratch.get_mut(..required(pairs.len())).ok_or(Error::Scratch)?;
    let frames = minimal::frames(pairs)?;
    search::Search::new(pairs, frames, settings, scratch).run()
}

/// What can be wrong with the arguments of [`estimate`], coordinates aside.
fn check(pairs: &[Pair], settings: &Settings) -> Result<(), Error> {
    if !(4..=1 << 24).contains(&pairs.len()) {
        return Err(Error::Pairs);
    }
    let positive = settings.threshold > 0.0 && settings.threshold <= MAX_COORDINATE;
    if !(positive && (0.0..1.0).contains(&settings.confidence)) {
        return Err(Error::Settings);
    }
    Ok(())
}

#[cfg(test)]
mod tests;
