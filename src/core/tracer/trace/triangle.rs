//! Eight rays against one triangle, without cracks between neighbours.
//!
//! Corners are rotated into each ray's own frame, where the ray is the third axis, and the three edge functions
//! are evaluated in the remaining plane (the idea of Woop, Benthin and Wald, *Watertight Ray/Triangle
//! Intersection*, JCGT 2(1), 2013, with a rotation in place of the shear). A corner shared by two triangles gets
//! the same coordinates in both, and swapping an edge's ends negates its edge function exactly (the products are
//! not fused), so a ray that leaves one triangle across the edge enters the other.

use super::ray::{Frames, Hit, Hits8, MISS};
use crate::maths::vec3::Vec3x8;
use crate::tracer::scene::{LEAF, SceneData, between};
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

/// Replaces `hits` in the lanes where triangle `index` is nearer, or as near with a lower index.
#[inline(always)]
pub(super) fn closest(rays: &Frames, corners: [Vec3x8; 3], index: u32, hits: &mut Hits8) {
    let Some(candidate) = intersect(rays, corners, hits.t) else { return };
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
pub(super) fn blocks(rays: &Frames, corners: [Vec3x8; 3], t_max: f32x8) -> f32x8 {
    intersect(rays, corners, t_max).map_or(f32x8::ZERO, |candidate| candidate.valid)
}

/// One ray against all triangles of a leaf: replaces `hit` if one is nearer, or as near with a lower index.
#[inline(always)]
pub(super) fn closest_of(ray: &Frames, corners: [Vec3x8; 3], leaf: Leaf, hit: &mut Hit) {
    let Some(candidate) = intersect(ray, corners, f32x8::splat(hit.t)) else { return };
    let mut lanes = candidate.valid.to_bitmask() & leaf.lanes();
    if lanes == 0 {
        return;
    }
    let (t, u, v) = (candidate.t.to_array(), candidate.u.to_array(), candidate.v.to_array());
    while lanes != 0 {
        let lane = lanes.trailing_zeros() as usize & 7;
        lanes &= lanes - 1;
        let triangle = leaf.first + lane as u32;
        if t[lane] < hit.t || (t[lane] == hit.t && triangle < hit.triangle) {
            *hit = Hit { t: t[lane], u: u[lane], v: v[lane], triangle };
        }
    }
}

/// Whether one of a leaf's triangles lies between one ray's origin and `t_max`.
#[inline(always)]
pub(super) fn any_blocks(ray: &Frames, corners: [Vec3x8; 3], leaf: Leaf, t_max: f32) -> bool {
    intersect(ray, corners, f32x8::splat(t_max))
        .is_some_and(|candidate| candidate.valid.to_bitmask() & leaf.lanes() != 0)
}

/// The triangles of a leaf.
#[derive(Clone, Copy)]
pub(super) struct Leaf {
    /// Index of the first; the others follow.
    pub first: u32,
    /// How many, 1 to 8.
    pub count: u32,
}

impl Leaf {
    /// A lane for each triangle, as bits.
    #[inline(always)]
    fn lanes(self) -> u32 {
        0xff >> ((8 - self.count) & 7)
    }

    /// The corners of triangle number `slot`, in all lanes, each at its own `time` if anything is `MOVING`.
    #[inline(always)]
    pub fn one<const MOVING: bool>(self, data: &SceneData<'_>, slot: usize, time: f32x8) -> [Vec3x8; 3] {
        self.at::<MOVING>(data, time, |row| f32x8::splat(row[slot & 7]))
    }

    /// The corners of all triangles, one a lane, likewise. Lanes beyond them hold arbitrary values.
    #[inline(always)]
    pub fn all<const MOVING: bool>(self, data: &SceneData<'_>, time: f32x8) -> [Vec3x8; 3] {
        self.at::<MOVING>(data, time, |row| f32x8::from(row))
    }

    /// What is read of the rows, between their two places if anything is `MOVING`.
    #[inline(always)]
    fn at<const MOVING: bool>(
        self,
        data: &SceneData<'_>,
        time: f32x8,
        read: impl Fn(&[f32]) -> f32x8,
    ) -> [Vec3x8; 3] {
        let open = self.read(data.leaves, &read);
        match &data.motion {
            Some(motion) if MOVING => {
                let closing = self.read(motion.leaves, &read);
                [0, 1, 2].map(|corner| between(open[corner], closing[corner], time))
            }
            _ => open,
        }
    }

    /// What `read` makes of eight numbers from the beginning of each row on.
    #[inline(always)]
    fn read(self, leaves: &[f32], read: &impl Fn(&[f32]) -> f32x8) -> [Vec3x8; 3] {
        let start = 9 * self.first as usize;
        let rows: &[f32; LEAF] = leaves[start..].first_chunk().expect("leaves end with zeros");
        let row = |i: usize| {
            // At most 64: the mask only tells the compiler that no row can be out of bounds.
            let at = (i * self.count as usize) & (LEAF - 9);
            read(&rows[at..at + 8])
        };
        [0, 3, 6].map(|i| Vec3x8::new(row(i), row(i + 1), row(i + 2)))
    }
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
