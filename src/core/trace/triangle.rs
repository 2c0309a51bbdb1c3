//! Eight rays against one triangle, without cracks between neighbours.
//!
//! Corners are rotated into each ray's own frame, where the ray is the third axis, and the three edge functions
//! are evaluated in the remaining plane (the idea of Woop, Benthin and Wald, *Watertight Ray/Triangle
//! Intersection*, JCGT 2(1), 2013, with a rotation in place of the shear). A corner shared by two triangles gets
//! the same coordinates in both, and swapping an edge's ends negates its edge function exactly (the products are
//! not fused), so a ray that leaves one triangle across the edge enters the other.

use super::ray::Prepared;
use super::{Hits8, MISS};
use crate::scene::Triangle;
use crate::vec3::Vec3x8;
use wide::{f32x8, u32x8};

/// A candidate intersection; `valid` has all bits set in lanes that hit between origin and `t_max`.
struct Candidate {
    valid: f32x8,
    t: f32x8,
    u: f32x8,
    v: f32x8,
}

/// The intersection, or none if no lane passes through the triangle.
#[inline(always)]
fn intersect(rays: &Prepared, triangle: &Triangle, t_max: f32x8) -> Option<Candidate> {
    let corner = triangle.corners.map(|c| {
        let c = Vec3x8::splat(c);
        [coordinate(rays, 0, c), coordinate(rays, 1, c)]
    });
    let edge = |a: usize, b: usize| corner[a][0] * corner[b][1] - corner[a][1] * corner[b][0];
    let w = [edge(1, 2), edge(2, 0), edge(0, 1)];
    let zero = f32x8::ZERO;
    let low = w[0].fast_min(w[1]).fast_min(w[2]);
    let high = w[0].fast_max(w[1]).fast_max(w[2]);
    let inside = low.simd_ge(zero) | high.simd_le(zero);
    if !inside.any() {
        return None;
    }
    let distance = triangle.corners.map(|c| coordinate(rays, 2, Vec3x8::splat(c)));
    let sum = w[0] + w[1] + w[2];
    let inverse = f32x8::ONE / sum;
    let (u, v) = (w[1] * inverse, w[2] * inverse);
    let t = distance[0] + u * (distance[1] - distance[0]) + v * (distance[2] - distance[0]);
    let valid = inside & sum.simd_ne(zero) & t.simd_ge(zero) & t.simd_le(t_max);
    Some(Candidate { valid, t, u, v })
}

/// Coordinate `k` of a corner in the rays' frames, relative to their origins.
#[inline(always)]
fn coordinate(rays: &Prepared, k: usize, corner: Vec3x8) -> f32x8 {
    super::ray::dot(rays.frame[k], corner) - rays.origin[k]
}

/// Replaces `hits` in the lanes where triangle `index` is nearer, or as near with a lower index.
#[inline(always)]
pub(super) fn closest(rays: &Prepared, triangle: &Triangle, index: u32, hits: &mut Hits8) {
    let Some(candidate) = intersect(rays, triangle, hits.t) else { return };
    let index = u32x8::splat(index);
    let tie = candidate.t.simd_eq(hits.t);
    let lower: f32x8 = bytemuck::cast(index.simd_lt(hits.triangle));
    let nearer = candidate.t.simd_lt(hits.t) | (tie & lower);
    let take = candidate.valid & nearer;
    hits.t = take.select(candidate.t, hits.t);
    hits.u = take.select(candidate.u, hits.u);
    hits.v = take.select(candidate.v, hits.v);
    hits.triangle = take.select(index, hits.triangle);
}

/// Lanes in which the triangle lies between origin and `t_max`.
#[inline(always)]
pub(super) fn blocks(rays: &Prepared, triangle: &Triangle, t_max: f32x8) -> f32x8 {
    intersect(rays, triangle, t_max).map_or(f32x8::ZERO, |candidate| candidate.valid)
}

impl Hits8 {
    /// Whether any lane hit something.
    #[inline(always)]
    pub(crate) fn any(&self) -> bool {
        self.triangle.simd_ne(u32x8::splat(MISS)).any()
    }

    /// Nothing hit up to `t_max`.
    #[inline(always)]
    pub(super) fn none(t_max: f32x8) -> Self {
        Hits8 { t: t_max, u: f32x8::ZERO, v: f32x8::ZERO, triangle: u32x8::splat(MISS) }
    }
}
