//! Polygons as triangles: convex ones as fans around their first corner, others by ear clipping in their plane.

use glam::DVec3;

/// A corner that turns by more than this part of the longest edges counts as turning the wrong way.
const FLAT: f64 = 1e-9;

/// Numbers of the corners of triangles that cover the polygon, in its own sense of turning.
///
/// A polygon that crosses itself, or that has no area, becomes a fan.
pub(super) fn triangles(corners: &[DVec3], out: &mut Vec<[usize; 3]>) {
    out.clear();
    if corners.len() > 3 && !is_convex(corners) && clip(corners, out) {
        return;
    }
    out.clear();
    out.extend((2..corners.len()).map(|i| [0, i - 1, i]));
}

/// Twice the area along the normal (Newell's method), with coordinates relative to the first corner.
fn area(corners: &[DVec3]) -> DVec3 {
    let first = corners[0];
    corners.windows(2).map(|pair| (pair[0] - first).cross(pair[1] - first)).sum()
}

/// Whether no corner turns against the whole.
fn is_convex(corners: &[DVec3]) -> bool {
    let normal = area(corners);
    let count = corners.len();
    let edge = |i: usize| corners[(i + 1) % count] - corners[i % count];
    let limit = -FLAT * normal.length_squared();
    // A fan also needs that its triangles do not run backwards: a star turns one way and crosses itself.
    let turns = (0..count).all(|i| edge(i).cross(edge(i + 1)).dot(normal) >= limit);
    let first = corners[0];
    turns && corners[1..].windows(2).all(|pair| (pair[0] - first).cross(pair[1] - first).dot(normal) >= limit)
}

/// Clips ears; false if the result does not have the polygon's area.
fn clip(corners: &[DVec3], out: &mut Vec<[usize; 3]>) -> bool {
    let normal = area(corners).normalize_or_zero();
    if normal == DVec3::ZERO {
        return false;
    }
    let (right, up) = normal.any_orthonormal_pair();
    let flat = |corner: &DVec3| [(corner - corners[0]).dot(right), (corner - corners[0]).dot(up)];
    let coordinates: Vec<f64> = corners.iter().flat_map(flat).collect();
    let Ok(indices) = earcutr::earcut(&coordinates, &[], 2) else { return false };
    let mut covered = 0.0;
    for &[a, b, c] in indices.as_chunks::<3>().0 {
        let size = (corners[b] - corners[a]).cross(corners[c] - corners[a]).dot(normal);
        covered += size.abs();
        out.push(if size < 0.0 { [a, c, b] } else { [a, b, c] });
    }
    let whole = area(corners).length();
    (covered - whole).abs() <= 1e-6 * whole
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cover(corners: &[[f64; 2]]) -> Vec<[usize; 3]> {
        // In a tilted plane.
        let corners: Vec<DVec3> =
            corners.iter().map(|[x, y]| DVec3::new(*x, *y, 0.5 * x - 2.0 * y)).collect();
        let mut out = Vec::new();
        triangles(&corners, &mut out);
        let normal = area(&corners);
        let sizes = out.iter().map(|t| {
            let [a, b, c] = t.map(|i| corners[i]);
            (b - a).cross(c - a).dot(normal.normalize_or_zero())
        });
        let sizes: Vec<f64> = sizes.collect();
        assert!(sizes.iter().all(|size| *size >= -1e-9), "{corners:?} {out:?}");
        assert!((sizes.iter().sum::<f64>() - normal.length()).abs() < 1e-9, "{corners:?} {out:?}");
        out
    }

    #[test]
    fn convex_polygons_are_fans_and_others_are_covered_once() {
        assert_eq!(cover(&[[0., 0.], [1., 0.], [1., 1.], [0., 1.]]), [[0, 1, 2], [0, 2, 3]]);
        let arrow = [[0., 0.], [2., 1.], [0., 2.], [1., 1.]];
        let notch = [[-1., 1.], [1., 1.], [0., 0.], [1., -1.], [-1., -1.]];
        let comb = [
            [0., 0.],
            [5., 0.],
            [5., 3.],
            [4., 3.],
            [4., 1.],
            [3., 1.],
            [3., 3.],
            [2., 3.],
            [2., 1.],
            [0., 1.],
        ];
        for polygon in [&arrow[..], &notch, &comb] {
            for turn in 0..polygon.len() {
                let mut polygon = polygon.to_vec();
                polygon.rotate_left(turn);
                cover(&polygon);
                polygon.reverse();
                cover(&polygon);
            }
        }
    }

    #[test]
    fn whatever_the_polygon_there_are_triangles() {
        let mut out = Vec::new();
        let odd: [&[DVec3]; 3] = [
            &[DVec3::ZERO; 5],
            &[DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X + DVec3::Y],
            &[DVec3::ZERO, DVec3::splat(f64::NAN), DVec3::Y, DVec3::X],
        ];
        for polygon in odd {
            triangles(polygon, &mut out);
            assert_eq!(out.len(), polygon.len() - 2);
        }
    }
}
