//! Normalised coordinates, small matrices, and the homography through four pairs.

use super::mapping::{Error, Homography, MAX_COORDINATE, Pair};
use crate::maths::matrix::Matrix;

/// Least |area| of a triangle of a sample, twice, in normalised coordinates: below it points count as collinear.
pub(super) const MIN_AREA: f64 = 1e-6;

/// Least spread of points in every direction, as a part of their coordinates.
const MIN_SPREAD: f64 = 1e-8;

/// The point of a pair in the first (0) or second (1) picture.
#[inline(always)]
pub(super) fn side(pair: &Pair, side: usize) -> [f64; 2] {
    if side == 0 { pair.from } else { pair.to }
}

/// The normalised coordinates of a picture: (p − centre)·scale.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub centre: [f64; 2],
    pub scale: f64,
}

impl Frame {
    /// Centroid to 0, mean distance from it to √2.
    fn new(points: impl Iterator<Item = [f64; 2]> + Clone) -> Result<Frame, Error> {
        let count = points.clone().count() as f64;
        if !points.clone().flatten().all(|c| (-MAX_COORDINATE..=MAX_COORDINATE).contains(&c)) {
            return Err(Error::Coordinate);
        }
        let sum = points.clone().fold([0.0; 2], |s, p| [s[0] + p[0], s[1] + p[1]]);
        let centre = sum.map(|s| s / count);
        let (mut spread, mut moments) = (0.0, [0.0; 3]);
        for p in points {
            let (x, y) = (p[0] - centre[0], p[1] - centre[1]);
            spread += libm::sqrt(x * x + y * y) / count;
            [x * x, x * y, y * y].iter().zip(&mut moments).for_each(|(term, sum)| *sum += term);
        }
        // Coordinates have 2^-53 of themselves; a spread near that is rounding, and so is one across a line.
        let least = MIN_SPREAD * (1.0 + centre[0].abs().max(centre[1].abs()));
        let [xx, xy, yy] = moments.map(|sum| sum / count);
        let across = (xx * yy - xy * xy) / (xx + yy);
        if spread <= least || across.is_nan() || across <= least * least {
            return Err(Error::Degenerate);
        }
        Ok(Frame { centre, scale: core::f64::consts::SQRT_2 / spread })
    }

    /// A point in normalised coordinates.
    #[inline(always)]
    pub fn inward(&self, p: [f64; 2]) -> [f64; 2] {
        [(p[0] - self.centre[0]) * self.scale, (p[1] - self.centre[1]) * self.scale]
    }
}

/// The normalised coordinates of both pictures.
pub(super) fn frames(pairs: &[Pair]) -> Result<[Frame; 2], Error> {
    Ok([Frame::new(pairs.iter().map(|p| p.from))?, Frame::new(pairs.iter().map(|p| p.to))?])
}

/// A homography of normalised coordinates in those of the pictures.
pub(super) fn outward(matrix: &Matrix, frames: &[Frame; 2]) -> Homography {
    let [from, to] = frames;
    let inward = [
        [from.scale, 0.0, -from.scale * from.centre[0]],
        [0.0, from.scale, -from.scale * from.centre[1]],
        [0.0, 0.0, 1.0],
    ];
    let outward = [[1.0 / to.scale, 0.0, to.centre[0]], [0.0, 1.0 / to.scale, to.centre[1]], [0.0, 0.0, 1.0]];
    Homography { matrix: product(&product(&outward, matrix), &inward) }
}

/// a·b.
fn product(a: &Matrix, b: &Matrix) -> Matrix {
    a.map(|row| [0, 1, 2].map(|j| row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j]))
}

/// Twice the signed area of a triangle.
#[inline(always)]
fn area(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Twice the areas of the triangles without point 0, 1, 2 and 3.
#[inline(always)]
fn areas(p: &[[f64; 2]; 4]) -> [f64; 4] {
    [area(p[3], p[1], p[2]), area(p[0], p[3], p[2]), area(p[0], p[1], p[3]), area(p[0], p[1], p[2])]
}

/// The homography that maps four points to four others, with w = 1 at the origin.
///
/// In homogeneous coordinates p₃·d = Σ aᵢ·pᵢ with aᵢ the area of the triangle that has p₃ in place of pᵢ and d that
/// of p₀p₁p₂. The mapping takes pᵢ to p'ᵢ·a'ᵢ/aᵢ, i = 0, 1, 2, and then p₃ to p'₃ by itself; on the triangle's dual
/// basis it is Σ (a'ᵢ/aᵢ)·p'ᵢ ⊗ (pⱼ × pₖ). Nothing if a triangle's area is below `least`, if a triple is turned
/// over, or if the origin lies on or behind the horizon.
#[inline(always)]
pub(super) fn through(from: &[[f64; 2]; 4], to: &[[f64; 2]; 4], least: f64) -> Option<Matrix> {
    let (a, b) = (areas(from), areas(to));
    if !(0..4).all(|i| a[i] * b[i] > 0.0 && a[i].abs() >= least && b[i].abs() >= least) {
        return None;
    }
    let mut matrix = [[0.0; 3]; 3];
    for (i, (j, k)) in [(1, 2), (2, 0), (0, 1)].into_iter().enumerate() {
        let ratio = b[i] / a[i];
        // The cross product of pⱼ and pₖ with third coordinates 1.
        let (p, q) = (from[j], from[k]);
        let dual = [p[1] - q[1], q[0] - p[0], p[0] * q[1] - p[1] * q[0]];
        for (row, t) in matrix.iter_mut().zip([to[i][0] * ratio, to[i][1] * ratio, ratio]) {
            (0..3).for_each(|c| row[c] += t * dual[c]);
        }
    }
    // With the dual basis not divided by d, w has its sign.
    let w = matrix[2][2];
    (w * a[3] > 0.0).then(|| matrix.map(|row| row.map(|entry| entry / w)))
}

impl Homography {
    /// The homography through four pairs, exactly.
    ///
    /// # Errors
    /// [`Error::Coordinate`], or [`Error::Degenerate`] if three points of a picture are (nearly) collinear or the
    /// pairs do not keep the orientation of every triple.
    pub fn through(pairs: &[Pair; 4]) -> Result<Homography, Error> {
        let frames = frames(pairs)?;
        let [from, to] = [0, 1].map(|i| pairs.map(|pair| frames[i].inward(side(&pair, i))));
        let matrix = through(&from, &to, MIN_AREA).ok_or(Error::Degenerate)?;
        Ok(outward(&matrix, &frames))
    }
}
