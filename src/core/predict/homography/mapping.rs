//! Projective mappings of the plane, and the pairs of points they map.

use crate::maths::matrix::{adjugate, determinant};

/// Largest coordinate of a point, either way.
pub const MAX_COORDINATE: f64 = 1e6;

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

    /// Where a point goes; nothing if it lies on or behind the horizon, or so near before it that no number says where.
    #[inline]
    pub fn apply(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        let [a, b, w] = self.matrix.map(|row| row[0] * x + row[1] * y + row[2]);
        let point = [a / w, b / w];
        (w > 0.0 && point.iter().all(|x| x.is_finite())).then_some(point)
    }

    /// The mapping back; nothing if the matrix is singular.
    ///
    /// What `self` maps in front of the horizon, the inverse maps in front of it as well.
    pub fn inverse(&self) -> Option<Homography> {
        let determinant = determinant(&self.matrix);
        let matrix = adjugate(&self.matrix).map(|row| row.map(|entry| entry / determinant));
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
    /// Less scratch than [`required`](super::required).
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
