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

mod mapping;
mod minimal;
mod normal;
mod refine;
mod score;
mod search;
mod settings;

pub use mapping::{Error, Homography, MAX_COORDINATE, Pair};
pub use score::Block;
pub use settings::{Fit, MAX_GAIN, Settings};

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
