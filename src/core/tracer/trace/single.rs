//! The walk of one ray: eight children, then the triangles of a leaf, at once.
//!
//! What remains of a packet when its rays have parted. The arithmetic of a lane is that of the packet's walk, so
//! that it does not matter for a hit which of the two found it.

use super::ray::{self, Hit, MISS, Prepared, Slopes};
use super::triangle::{self, Leaf};
use crate::tracer::scene::{Node8, STACK, Scene};
use wide::f32x8;

/// A subtree that waits: a node or, where `count` is not 0, a leaf's triangles; and where the ray enters its box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Waiting {
    near: f32,
    first: u32,
    count: u32,
}

/// Memory for the walk.
pub(super) type Stack = [Waiting; STACK];

/// An unused stack.
pub(super) const EMPTY: Stack = [Waiting { near: 0.0, first: 0, count: 0 }; STACK];

/// The box planes that a ray meets first and last, as rows of a node.
struct Planes {
    near: [usize; 3],
    far: [usize; 3],
}

impl Planes {
    #[inline(always)]
    fn new(slopes: &Slopes) -> Self {
        let negative = slopes.inverse.map(|v| v.as_array()[0] < 0.0);
        let row = |axis: usize, upper: bool| axis + if upper { 3 } else { 0 };
        Planes {
            near: [0, 1, 2].map(|axis| row(axis, negative[axis])),
            far: [0, 1, 2].map(|axis| row(axis, !negative[axis])),
        }
    }

    /// Where the ray enters each child's box, at least 0, and the children it meets before `t_max`, as bits.
    #[inline(always)]
    fn enter(&self, slopes: &Slopes, node: &Node8, t_max: f32) -> (f32x8, u32) {
        let rows: &[f32x8; 8] = bytemuck::cast_ref(node);
        let slope = |planes: &[usize; 3], axis: usize| {
            rows[planes[axis] & 7].mul_sub(slopes.inverse[axis], slopes.offset[axis])
        };
        let near = [0, 1, 2].map(|axis| slope(&self.near, axis));
        let far = [0, 1, 2].map(|axis| slope(&self.far, axis));
        let enter = near[0].fast_max(near[1]).fast_max(near[2].fast_max(f32x8::ZERO));
        let leave = far[0].fast_min(far[1]).fast_min(far[2].fast_min(f32x8::splat(t_max)));
        (enter, enter.simd_le(leave).to_bitmask())
    }
}

/// What ray number `lane` hits first, up to `t_max`.
pub(super) fn find_closest<const MOVING: bool>(
    scene: &Scene<'_>,
    stack: &mut Stack,
    rays: &Prepared,
    lane: usize,
    t_max: f32,
) -> Hit {
    let mut hit = Hit { t: t_max, u: 0.0, v: 0.0, triangle: MISS };
    let (mut first, mut count) = (0, 0);
    let data = scene.data();
    let (slopes, time) = (rays.slopes.lane(lane), ray::one(&rays.time, lane));
    let planes = Planes::new(&slopes);
    let mut top = 0;
    loop {
        if count > 0 {
            let leaf = Leaf { first, count };
            triangle::closest_of(&rays.frames.lane(lane), leaf.all::<MOVING>(data, time), leaf, &mut hit);
        } else {
            let node = &data.nodes[first as usize];
            let (near, mut met) = planes.enter(&slopes, node, hit.t);
            if met != 0 {
                let child = met.trailing_zeros() as usize & 7;
                met &= met - 1;
                (first, count) = (node.child[child], node.count[child]);
                if met != 0 {
                    let near = near.to_array();
                    let mut nearest = Waiting { near: near[child], first, count };
                    let bottom = top;
                    while met != 0 {
                        let child = met.trailing_zeros() as usize & 7;
                        met &= met - 1;
                        let mut entry =
                            Waiting { near: near[child], first: node.child[child], count: node.count[child] };
                        if entry.near < nearest.near {
                            core::mem::swap(&mut entry, &mut nearest);
                        }
                        insert(stack, bottom, top, entry);
                        top += 1;
                    }
                    (first, count) = (nearest.first, nearest.count);
                }
                continue;
            }
        }
        loop {
            if top == 0 {
                return hit;
            }
            top -= 1;
            if stack[top].near <= hit.t {
                break;
            }
        }
        (first, count) = (stack[top].first, stack[top].count);
    }
}

/// Puts `entry` among `stack[bottom..top]`, which is sorted so that the nearest comes last.
#[inline(always)]
fn insert(stack: &mut Stack, bottom: usize, top: usize, entry: Waiting) {
    let mut at = top;
    while at > bottom && stack[at - 1].near < entry.near {
        stack[at] = stack[at - 1];
        at -= 1;
    }
    stack[at] = entry;
}

/// Whether anything in the subtree below `node` lies between the ray's origin and `t_max`.
pub(super) fn find_any<const MOVING: bool>(
    scene: &Scene<'_>,
    stack: &mut Stack,
    rays: &Prepared,
    lane: usize,
    node: u32,
    t_max: f32,
) -> bool {
    let data = scene.data();
    let (slopes, time) = (rays.slopes.lane(lane), ray::one(&rays.time, lane));
    let planes = Planes::new(&slopes);
    stack[0].first = node;
    let mut top = 1;
    while top > 0 {
        top -= 1;
        let node = &data.nodes[stack[top].first as usize];
        let (_, mut met) = planes.enter(&slopes, node, t_max);
        while met != 0 {
            let child = met.trailing_zeros() as usize & 7;
            met &= met - 1;
            let (first, count) = (node.child[child], node.count[child]);
            if count == 0 {
                stack[top].first = first;
                top += 1;
                continue;
            }
            let leaf = Leaf { first, count };
            if triangle::any_blocks(&rays.frames.lane(lane), leaf.all::<MOVING>(data, time), leaf, t_max) {
                return true;
            }
        }
    }
    false
}
