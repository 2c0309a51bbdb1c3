//! The walk through the eight-wide hierarchy.

use super::ray::Prepared;
use super::{Hits8, Rays8, triangle};
use crate::scene::{Node8, STACK, Scene};
use wide::f32x8;

/// A subtree that waits: a node or, where `count` is not 0, a leaf's triangles; and when each ray enters its box.
#[derive(Clone, Copy, Debug)]
struct Entry {
    near: f32x8,
    /// The least of `near`: in this order they are visited.
    nearest: f32,
    first: u32,
    count: u32,
}

const ROOT: Entry = Entry { near: f32x8::ZERO, nearest: 0.0, first: 0, count: 0 };

/// Traces packets through a scene. Keeps the walk's stack, so that it is not cleared for every packet.
#[derive(Clone, Debug)]
pub struct Tracer<'a> {
    scene: Scene<'a>,
    stack: [Entry; STACK],
}

impl<'a> Tracer<'a> {
    /// A tracer for `scene`.
    pub fn new(scene: Scene<'a>) -> Self {
        Tracer { scene, stack: [ROOT; STACK] }
    }

    /// The scene that is traced.
    #[inline(always)]
    pub fn scene(&self) -> &Scene<'a> {
        &self.scene
    }

    /// The nearest triangle along each ray, at distances from 0 to `t_max`.
    ///
    /// A triangle is hit from both sides. Idle lanes (negative `t_max`) miss.
    pub fn closest(&mut self, rays: &Rays8) -> Hits8 {
        let prepared = Prepared::new(rays);
        let mut hits = Hits8::none(rays.t_max);
        let active = rays.active();
        if self.scene.data().nodes.is_empty() || active == 0 {
            return hits;
        }
        match prepared.common_signs(active) {
            Some(signs) => find_closest(&self.scene, &mut self.stack, &prepared, Signed(signs), &mut hits),
            None => find_closest(&self.scene, &mut self.stack, &prepared, Mixed, &mut hits),
        }
        hits
    }

    /// As [`closest`](Self::closest), but only triangles that emit are seen. For few of them this is far quicker.
    pub(crate) fn closest_light(&self, rays: &Rays8) -> Hits8 {
        let prepared = Prepared::new(rays);
        let mut hits = Hits8::none(rays.t_max);
        let data = self.scene.data();
        for light in data.lights {
            triangle::closest(&prepared, &data.triangles[light.triangle as usize], light.triangle, &mut hits);
        }
        hits
    }

    /// The lanes, as bits, in which something lies between the origin and `t_max`. Idle lanes are not occluded.
    pub fn occluded(&mut self, rays: &Rays8) -> u32 {
        let prepared = Prepared::new(rays);
        let active = rays.active();
        if self.scene.data().nodes.is_empty() || active == 0 {
            return 0;
        }
        match prepared.common_signs(active) {
            Some(signs) => find_any(&self.scene, &prepared, Signed(signs), rays.t_max, active),
            None => find_any(&self.scene, &prepared, Mixed, rays.t_max, active),
        }
    }
}

fn find_closest(
    scene: &Scene<'_>,
    stack: &mut [Entry; STACK],
    rays: &Prepared,
    slabs: impl Slabs,
    hits: &mut Hits8,
) {
    let data = scene.data();
    stack[0] = ROOT;
    let mut top = 1;
    while top > 0 {
        top -= 1;
        let entry = stack[top];
        if !entry.near.simd_le(hits.t).any() {
            continue;
        }
        if entry.count > 0 {
            let first = entry.first as usize;
            let leaf = &data.triangles[first..first + entry.count as usize];
            for (index, triangle) in (entry.first..).zip(leaf) {
                triangle::closest(rays, triangle, index, hits);
            }
            continue;
        }
        let node = &data.nodes[entry.first as usize];
        let bottom = top;
        for child in 0..8 {
            if !node.is_used(child) {
                break;
            }
            let near = slabs.enter(rays, node, child, hits.t);
            let inside = near.simd_ge(f32x8::ZERO);
            if inside.any() {
                let near = inside.select(near, f32x8::splat(f32::INFINITY));
                let (first, count) = (node.child[child], node.count[child]);
                insert(stack, bottom, top, Entry { near, nearest: least(near), first, count });
                top += 1;
            }
        }
    }
}

/// Puts `entry` among `stack[bottom..top]`, which is sorted so that the nearest comes last.
#[inline(always)]
fn insert(stack: &mut [Entry; STACK], bottom: usize, top: usize, entry: Entry) {
    let mut at = top;
    while at > bottom && stack[at - 1].nearest < entry.nearest {
        stack[at] = stack[at - 1];
        at -= 1;
    }
    stack[at] = entry;
}

#[inline(always)]
fn least(near: f32x8) -> f32 {
    let lesser = |a: f32, b: f32| if a < b { a } else { b };
    let [a, b, c, d, e, f, g, h] = near.to_array();
    lesser(lesser(lesser(a, b), lesser(c, d)), lesser(lesser(e, f), lesser(g, h)))
}

fn find_any(scene: &Scene<'_>, rays: &Prepared, slabs: impl Slabs, mut t_max: f32x8, active: u32) -> u32 {
    let data = scene.data();
    let mut stack = [0u32; STACK];
    let mut top = 1;
    let mut blocked = 0;
    while top > 0 {
        top -= 1;
        let node = &data.nodes[stack[top] as usize];
        for child in 0..8 {
            if !node.is_used(child) {
                break;
            }
            if !slabs.enter(rays, node, child, t_max).simd_ge(f32x8::ZERO).any() {
                continue;
            }
            let (first, count) = (node.child[child], node.count[child] as usize);
            if count == 0 {
                stack[top] = first;
                top += 1;
                continue;
            }
            for triangle in &data.triangles[first as usize..first as usize + count] {
                let hit = triangle::blocks(rays, triangle, t_max);
                t_max = hit.select(f32x8::splat(-1.0), t_max);
                blocked |= hit.to_bitmask();
            }
            if blocked == active {
                return blocked;
            }
        }
    }
    blocked
}

/// How the packet enters a child's box.
trait Slabs {
    /// The distance, at least 0, at which each ray enters the box; negative where it misses.
    fn enter(&self, rays: &Prepared, node: &Node8, child: usize, t_max: f32x8) -> f32x8;
}

/// All rays point into the same octant: which plane comes first is known.
struct Signed([bool; 3]);

impl Slabs for Signed {
    #[inline(always)]
    fn enter(&self, rays: &Prepared, node: &Node8, child: usize, t_max: f32x8) -> f32x8 {
        let plane = |axis: usize, upper: bool| {
            let bounds = if upper { &node.upper } else { &node.lower };
            slope(rays, axis, bounds[axis][child])
        };
        let near = [0, 1, 2].map(|axis| plane(axis, self.0[axis]));
        let far = [0, 1, 2].map(|axis| plane(axis, !self.0[axis]));
        overlap(near, far, t_max)
    }
}

/// Rays of different octants.
struct Mixed;

impl Slabs for Mixed {
    #[inline(always)]
    fn enter(&self, rays: &Prepared, node: &Node8, child: usize, t_max: f32x8) -> f32x8 {
        let lower = [0, 1, 2].map(|axis| slope(rays, axis, node.lower[axis][child]));
        let upper = [0, 1, 2].map(|axis| slope(rays, axis, node.upper[axis][child]));
        let near = [0, 1, 2].map(|axis| lower[axis].fast_min(upper[axis]));
        let far = [0, 1, 2].map(|axis| lower[axis].fast_max(upper[axis]));
        overlap(near, far, t_max)
    }
}

/// The distance at which each ray meets the plane.
#[inline(always)]
fn slope(rays: &Prepared, axis: usize, plane: f32) -> f32x8 {
    f32x8::splat(plane).mul_sub(rays.inverse[axis], rays.offset[axis])
}

#[inline(always)]
fn overlap(near: [f32x8; 3], far: [f32x8; 3], t_max: f32x8) -> f32x8 {
    let enter = near[0].fast_max(near[1]).fast_max(near[2].fast_max(f32x8::ZERO));
    let leave = far[0].fast_min(far[1]).fast_min(far[2].fast_min(t_max));
    enter.simd_le(leave).select(enter, f32x8::splat(-1.0))
}
