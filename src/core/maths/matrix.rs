//! 3 × 3 matrices in double precision.

/// A 3 × 3 matrix, row by row.
pub(crate) type Matrix = [[f64; 3]; 3];

/// The determinant.
pub(crate) fn determinant(m: &Matrix) -> f64 {
    let minor = cross(m[1], m[2]);
    m[0][0] * minor[0] + m[0][1] * minor[1] + m[0][2] * minor[2]
}

/// Transposed cofactors: the inverse times the determinant.
pub(crate) fn adjugate(m: &Matrix) -> Matrix {
    let [a, b, c] = [cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])];
    [0, 1, 2].map(|i| [a[i], b[i], c[i]])
}

/// a × b.
#[inline(always)]
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
