//! Eight rays against one triangle, without cracks between neighbours.
//!
//! Corners are rotated into each ray's own frame, where the ray is the third axis, and the three edge functions
//! are evaluated in the remaining plane (the idea of Woop, Benthin and Wald, *Watertight Ray/Triangle
//! Intersection*, JCGT 2(1), 2013, with a rotation in place of the shear). A corner shared by two triangles gets
//! the same coordinates in both, and swapping an edge's ends negates its edge function exactly (the products are
//! not fused), so a ray that leaves one triangle across the edge enters the other.

use super::ray::{Frames, Hit, Hits8, MISS};
use crate::maths::vec3::Vec3x8;
use crate::tracer::scene::{Leaf8, SceneData, between};
use wide::{f32x8, u32x8};

/// A candidate intersection; `valid` has all bits set in lanes that hit between origin and `t_max`.
struct Candidate {
    valid: f32x8,
    t: f32x8,
    u: f32x8,
    v: f32x8,
}

/// The intersection, or none if no lane passes through its triangle.
///
/// A lane is a ray, its triangle, or both: what is the same in all lanes is splatted by the caller.
#[inline(always)]
fn intersect(rays: &Frames, corners: [Vec3x8; 3], t_max: f32x8) -> Option<Candidate> {
    let corner = corners.map(|c| [coordinate(rays, 0, c), coordinate(rays, 1, c)]);
    let edge = |a: usize, b: usize| corner[a][0] * corner[b][1] - corner[a][1] * corner[b][0];
    let w = [edge(1, 2), edge(2, 0), edge(0, 1)];
    let zero = f32x8::ZERO;
    let low = w[0].fast_min(w[1]).fast_min(w[2]);
    let high = w[0].fast_max(w[1]).fast_max(w[2]);
    let inside = low.simd_ge(zero) | high.simd_le(zero);
    if !inside.any() {
        return None;
    }
    let distance = corners.map(|c| coordinate(rays, 2, c));
    let sum = w[0] + w[1] + w[2];
    let inverse = f32x8::ONE / sum;
    let (u, v) = (w[1] * inverse, w[2] * inverse);
    let t = distance[0] + u * (distance[1] - distance[0]) + v * (distance[2] - distance[0]);
    let valid = inside & sum.simd_ne(zero) & t.simd_ge(zero) & t.simd_le(t_max);
    Some(Candidate { valid, t, u, v })
}

/// Coordinate `k` of a corner in the rays' frames, relative to their origins.
#[inline(always)]
fn coordinate(rays: &Frames, k: usize, corner: Vec3x8) -> f32x8 {
    super::ray::dot(rays.axes[k], corner) - rays.origin[k]
}

/// Replaces `hits` in the lanes where triangle `index` is nearer, or as near with a lower index. The index is asked
/// for only where a ray passes through the triangle: it lies in another cache line than the corners.
#[inline(always)]
pub(super) fn closest(rays: &Frames, corners: [Vec3x8; 3], index: impl FnOnce() -> u32, hits: &mut Hits8) {
    let Some(candidate) = intersect(rays, corners, hits.t) else { return };
    let index = u32x8::splat(index());
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
pub(super) fn blocks(rays: &Frames, corners: [Vec3x8; 3], t_max: f32x8) -> f32x8 {
    intersect(rays, corners, t_max).map_or(f32x8::ZERO, |candidate| candidate.valid)
}

/// One ray against all triangles of a leaf, of which the first has index `first`: replaces `hit` if one is nearer, or as near
/// with a lower index.
#[inline(always)]
pub(super) fn closest_of(ray: &Frames, corners: [Vec3x8; 3], first: u32, hit: &mut Hit) {
    let Some(candidate) = intersect(ray, corners, f32x8::splat(hit.t)) else { return };
    let mut lanes = candidate.valid.to_bitmask();
    if lanes == 0 {
        return;
    }
    let (t, u, v) = (candidate.t.to_array(), candidate.u.to_array(), candidate.v.to_array());
    while lanes != 0 {
        let lane = lanes.trailing_zeros() as usize & 7;
        lanes &= lanes - 1;
        let triangle = first + lane as u32;
        if t[lane] < hit.t || (t[lane] == hit.t && triangle < hit.triangle) {
            *hit = Hit { t: t[lane], u: u[lane], v: v[lane], triangle };
        }
    }
}

/// Whether one of a leaf's triangles lies between one ray's origin and `t_max`.
#[inline(always)]
pub(super) fn any_blocks(ray: &Frames, corners: [Vec3x8; 3], t_max: f32) -> bool {
    intersect(ray, corners, f32x8::splat(t_max)).is_some_and(|candidate| candidate.valid.any())
}

/// The corners of triangle number `slot` of leaf number `leaf`, in all lanes, each at its own `time` if anything is `MOVING`.
#[inline(always)]
pub(super) fn one<const MOVING: bool>(
    data: &SceneData<'_>,
    leaf: u32,
    slot: usize,
    time: f32x8,
) -> [Vec3x8; 3] {
    at::<MOVING>(data, leaf, time, |leaf| splat(leaf, slot))
}

/// The corners of all triangles of a leaf, one a lane, likewise.
#[inline(always)]
pub(super) fn all<const MOVING: bool>(data: &SceneData<'_>, leaf: u32, time: f32x8) -> [Vec3x8; 3] {
    at::<MOVING>(data, leaf, time, lanes)
}

/// What is read of a leaf, between its two places if anything is `MOVING`.
#[inline(always)]
fn at<const MOVING: bool>(
    data: &SceneData<'_>,
    leaf: u32,
    time: f32x8,
    read: impl Fn(&Leaf8) -> [Vec3x8; 3],
) -> [Vec3x8; 3] {
    let open = read(&data.leaves[leaf as usize]);
    match &data.motion {
        Some(motion) if MOVING => {
            let closing = read(&motion.leaves[leaf as usize]);
            [0, 1, 2].map(|corner| between(open[corner], closing[corner], time))
        }
        _ => open,
    }
}

#[inline(always)]
fn splat(leaf: &Leaf8, slot: usize) -> [Vec3x8; 3] {
    leaf.corners.each_ref().map(|c| Vec3x8::splat([0, 1, 2].map(|axis| c[axis][slot & 7])))
}

#[inline(always)]
fn lanes(leaf: &Leaf8) -> [Vec3x8; 3] {
    leaf.corners.each_ref().map(|[x, y, z]| Vec3x8::new((*x).into(), (*y).into(), (*z).into()))
}

impl Hits8 {
    /// The lanes that hit something, all bits set.
    #[inline(always)]
    pub(crate) fn lanes(&self) -> f32x8 {
        bytemuck::cast(self.triangle.simd_ne(u32x8::splat(MISS)))
    }

    /// Whether any lane hit something.
    #[inline(always)]
    pub(crate) fn any(&self) -> bool {
        self.triangle.simd_ne(u32x8::splat(MISS)).any()
    }

    /// Replaces what the ray of one lane hit.
    #[inline(always)]
    pub(super) fn set_lane(&mut self, lane: usize, hit: Hit) {
        self.t.as_mut_array()[lane & 7] = hit.t;
        self.u.as_mut_array()[lane & 7] = hit.u;
        self.v.as_mut_array()[lane & 7] = hit.v;
        self.triangle.as_mut_array()[lane & 7] = hit.triangle;
    }

    /// Nothing hit up to `t_max`.
    #[inline(always)]
    pub(crate) fn none(t_max: f32x8) -> Self {
        Hits8 { t: t_max, u: f32x8::ZERO, v: f32x8::ZERO, triangle: u32x8::splat(MISS) }
    }
}
