//! Triangles that move while the shutter is open: where they are as it closes.
//!
//! Corners go straight and evenly from where they are as the shutter opens to where they are as it closes, and normals with
//! them: what turns goes along the chord of its way, as with every renderer of two positions a frame. Scenes that stand still
//! pay nothing for it.

use super::surface::Triangle;
use crate::maths::vec3::{self, Vec3x8};
use wide::f32x8;

/// A scene as the shutter closes; as it opens it is [`SceneData`](super::SceneData)'s own triangles, leaves and normals.
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a> {
    /// One for each triangle. The boxes of the hierarchy and of the light tree hold them, too.
    pub triangles: &'a [Triangle],
    /// The coordinates of the triangles above, leaf by leaf, as [`fill_leaves`](super::fill_leaves) arranges them.
    pub leaves: &'a [f32],
    /// Unit shading normals at the corners of each triangle, on the front side; zero where it is flat.
    pub normals: &'a [[[f32; 3]; 3]],
}

/// On the straight way from one place to another: at `time` 0 the former, at 1 the latter.
#[inline(always)]
pub(crate) fn between(open: Vec3x8, closing: Vec3x8, time: f32x8) -> Vec3x8 {
    open + (closing - open) * time
}

/// Unit normals of a triangle on its straight way, between which all others lie: as it opens, as it closes, and where both
/// mix; none where there is no area, which adds nothing to those in between.
///
/// The cross product of edges that grow evenly is (1 − t)² the first of them, t² the second, and t (1 − t) the third.
pub(super) fn normals(open: &Triangle, closing: &Triangle) -> [Option<[f32; 3]>; 3] {
    let edges = |triangle: &Triangle| {
        let [a, b, c] = triangle.corners;
        [vec3::sub(b, a), vec3::sub(c, a)]
    };
    let ([u, v], [x, y]) = (edges(open), edges(closing));
    let (ux, vy) = (vec3::cross(u, y), vec3::cross(x, v));
    let mixed = [0, 1, 2].map(|axis| ux[axis] + vy[axis]);
    [vec3::cross(u, v), vec3::cross(x, y), mixed].map(vec3::normalized)
}
