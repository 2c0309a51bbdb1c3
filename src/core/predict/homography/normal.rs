//! The normal equations of a Gauss-Newton step, and what they say about the certainty of a homography.
//!
//! Parameters are the first eight entries of the matrix, the ninth is 1 at the centroid of the pairs. Residuals in x'
//! and y' share the derivatives by their own three parameters, so the equations have the form
//! ⎡S · B⎤
//! ⎢· S C⎥ with S 3 × 3, B and C 3 × 2, D 2 × 2,
//! ⎣Bᵀ Cᵀ D⎦
//! and are solved by S⁻¹ and the Schur complement of D, both in closed form.

use super::score::Block;
use crate::maths::matrix::{Matrix, adjugate, determinant};
use bytemuck::cast;
use wide::f64x4;

/// Sums over pairs: 6 of S, 5 of B, 5 of C, 3 of D, 8 of the right side, weights, weighted squared residuals.
const SUMS: usize = 29;

/// Sums over pairs that make the equations.
pub(super) struct Sums([f64x4; SUMS]);

impl Sums {
    /// No pairs yet.
    pub fn new() -> Self {
        Sums([f64x4::ZERO; SUMS])
    }

    /// Adds eight pairs with their weights.
    #[inline(always)]
    pub fn add(&mut self, matrix: &Matrix, block: &Block, weights: [f32; 8]) {
        let points: [[f64x4; 2]; 4] = block.double.map(cast);
        let weights: [f64x4; 2] = cast(weights.map(f64::from));
        for (half, weight) in weights.into_iter().enumerate() {
            self.add4(matrix, points.map(|p| p[half]), weight);
        }
    }

    #[inline(always)]
    fn add4(&mut self, m: &Matrix, [x, y, u, v]: [f64x4; 4], weight: f64x4) {
        let row = |row: &[f64; 3]| f64x4::splat(row[0]) * x + f64x4::splat(row[1]) * y + f64x4::splat(row[2]);
        let z = f64x4::ONE / row(&m[2]);
        let (p, q) = (row(&m[0]) * z, row(&m[1]) * z);
        let (r, s) = (u - p, v - q);
        let (x, y) = (x * z, y * z);
        let [wx, wy, wz] = [x, y, z].map(|d| d * weight);
        let squares = [wx * x, wx * y, wy * y, wx * z, wy * z];
        let mut next = self.0.iter_mut();
        let mut add = |terms: &[f64x4]| terms.iter().zip(&mut next).for_each(|(term, sum)| *sum += *term);
        add(&squares);
        add(&[wz * z]);
        add(&squares.map(|square| square * p));
        add(&squares.map(|square| square * q));
        let norm = p * p + q * q;
        add(&[squares[0] * norm, squares[1] * norm, squares[2] * norm]);
        add(&[wx * r, wy * r, wz * r, wx * s, wy * s, wz * s]);
        let along = r * p + s * q;
        add(&[wx * along, wy * along, weight, weight * (r * r + s * s)]);
    }

    /// The sums of all lanes: the equations, the sum of weights and that of weighted squared residuals.
    pub fn finish(&self) -> (Equations, f64, f64) {
        let t = self.0.map(|lanes| {
            let [a, b, c, d] = lanes.to_array();
            (a + b) + (c + d)
        });
        let coupling = |i: usize| [[-t[i], -t[i + 1]], [-t[i + 1], -t[i + 2]], [-t[i + 3], -t[i + 4]]];
        let equations = Equations {
            s: [[t[0], t[1], t[3]], [t[1], t[2], t[4]], [t[3], t[4], t[5]]],
            b: coupling(6),
            c: coupling(11),
            d: [[t[16], t[17]], [t[17], t[18]]],
            right: [t[19], t[20], t[21], t[22], t[23], t[24], -t[25], -t[26]],
        };
        (equations, t[27], t[28])
    }
}

/// The normal equations of one step.
pub(super) struct Equations {
    s: Matrix,
    b: [[f64; 2]; 3],
    c: [[f64; 2]; 3],
    d: [[f64; 2]; 2],
    right: [f64; 8],
}

/// The equations with S and the Schur complement of D inverted.
pub(super) struct Solver {
    inverse: Matrix,
    b: [[f64; 2]; 3],
    c: [[f64; 2]; 3],
    schur: [[f64; 2]; 2],
}

/// m·v.
fn times(m: &Matrix, v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// mᵀ·v.
fn down(m: &[[f64; 2]; 3], v: [f64; 3]) -> [f64; 2] {
    [0, 1].map(|j| m[0][j] * v[0] + m[1][j] * v[1] + m[2][j] * v[2])
}

impl Equations {
    /// Nothing if they are singular to working precision.
    pub fn solver(&self) -> Option<Solver> {
        let determinant = determinant(&self.s);
        let size = self.s[0][0] * self.s[1][1] * self.s[2][2];
        if determinant.is_nan() || determinant <= 1e-13 * size {
            return None;
        }
        let inverse = adjugate(&self.s).map(|row| row.map(|entry| entry / determinant));
        let mut rest = self.d;
        for half in [&self.b, &self.c] {
            for j in 0..2 {
                let solved = times(&inverse, [half[0][j], half[1][j], half[2][j]]);
                let taken = down(half, solved);
                (0..2).for_each(|i| rest[i][j] -= taken[i]);
            }
        }
        let [[a, b], [_, d]] = rest;
        let determinant = a * d - b * b;
        if determinant.is_nan() || determinant <= 1e-26 * self.d[0][0] * self.d[1][1] || a <= 0.0 {
            return None;
        }
        let schur = [[d / determinant, -b / determinant], [-b / determinant, a / determinant]];
        Some(Solver { inverse, b: self.b, c: self.c, schur })
    }

    /// `matrix` after one step; nothing if the equations are singular.
    pub fn step(&self, matrix: &Matrix) -> Option<Matrix> {
        let step = self.solver()?.solve(self.right);
        let mut moved = *matrix;
        moved.as_flattened_mut().iter_mut().zip(step).for_each(|(entry, by)| *entry += by);
        Some(moved)
    }
}

impl Solver {
    /// The solution for a right side.
    fn solve(&self, right: [f64; 8]) -> [f64; 8] {
        let [a0, a1, a2, b0, b1, b2, c0, c1] = right;
        let (p, q) = (times(&self.inverse, [a0, a1, a2]), times(&self.inverse, [b0, b1, b2]));
        let (bp, cq) = (down(&self.b, p), down(&self.c, q));
        let rest = [c0 - bp[0] - cq[0], c1 - bp[1] - cq[1]];
        let last = self.schur.map(|row| row[0] * rest[0] + row[1] * rest[1]);
        let back = |half: &[[f64; 2]; 3]| times(&self.inverse, half.map(|h| h[0] * last[0] + h[1] * last[1]));
        let (db, dc) = (back(&self.b), back(&self.c));
        [p[0] - db[0], p[1] - db[1], p[2] - db[2], q[0] - dc[0], q[1] - dc[1], q[2] - dc[2], last[0], last[1]]
    }

    /// Variance with which unit noise on every pair moves the image of a point, in the direction in which it moves
    /// it most. At a pair it is the pair's leverage: 1 if no other pair has a say there.
    pub fn variance(&self, m: &Matrix, [x, y]: [f64; 2]) -> f64 {
        let [p, q, w] = m.map(|row| row[0] * x + row[1] * y + row[2]);
        let (p, q) = (p / w, q / w);
        let (down, across) =
            ([0.0, 0.0, 0.0, x, y, 1.0, -x * q, -y * q], [x, y, 1.0, 0.0, 0.0, 0.0, -x * p, -y * p]);
        let (solved, solved_down) = (self.solve(across), self.solve(down));
        let dot = |a: &[f64; 8], b: &[f64; 8]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / (w * w);
        let (xx, xy, yy) = (dot(&across, &solved), dot(&down, &solved), dot(&down, &solved_down));
        let half = 0.5 * (xx - yy);
        0.5 * (xx + yy) + libm::sqrt(half * half + xy * xy)
    }
}
