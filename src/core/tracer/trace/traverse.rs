//! The walk through the eight-wide hierarchy.

use super::ray::{Hits8, Prepared, Rays8, Slopes};
use super::single;
use super::triangle::{self, Leaf};
use crate::maths::vec3::Vec3x8;
use crate::tracer::scene::{Node8, STACK, Scene, between};
use wide::{f32x4, f32x8};

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
    /// The walk's stack for shadow rays: nodes, and the rays that meet them, as bits.
    shadow_stack: [(u32, u32); STACK],
    single: single::Stack,
}

/// Rays that lie in a cone of this cosine around the first are walked as a packet.
const COHERENT: f32 = 0.95;

/// In a hierarchy of up to this many nodes rays meet the same ones wherever they go: they stay together.
const SMALL: usize = 64;

/// When no more than this many shadow rays of a packet meet a node, each goes on alone.
const FEW: u32 = 4;

impl<'a> Tracer<'a> {
    /// A tracer for `scene`.
    pub fn new(scene: Scene<'a>) -> Self {
        Tracer { scene, stack: [ROOT; STACK], shadow_stack: [(0, 0); STACK], single: single::EMPTY }
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
        match self.scene.data().motion {
            None => self.closest_of::<false>(rays),
            Some(_) => self.closest_moving(rays),
        }
    }

    // Kept out of the loops that call it, as `occluded_moving`: they are for scenes that stand still.
    #[inline(never)]
    fn closest_moving(&mut self, rays: &Rays8) -> Hits8 {
        self.closest_of::<true>(rays)
    }

    #[inline(always)]
    fn closest_of<const MOVING: bool>(&mut self, rays: &Rays8) -> Hits8 {
        let prepared = Prepared::new(rays);
        let mut hits = Hits8::none(rays.t_max);
        let active = rays.active();
        if self.scene.data().nodes.is_empty() || active == 0 {
            return hits;
        }
        if self.scene.data().nodes.len() > SMALL && !is_coherent(rays.direction, active) {
            self.find_each::<MOVING>(&prepared, active, &mut hits);
            return hits;
        }
        match prepared.slopes.common_signs(active) {
            Some(signs) => self.find_closest::<MOVING, _>(&prepared, Signed(signs), &mut hits),
            None => self.find_closest::<MOVING, _>(&prepared, Mixed, &mut hits),
        }
        hits
    }

    /// The nearest hit of each ray by itself.
    fn find_each<const MOVING: bool>(&mut self, rays: &Prepared, mut lanes: u32, hits: &mut Hits8) {
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & 7;
            lanes &= lanes - 1;
            let t_max = hits.t.as_array()[lane];
            let hit = single::find_closest::<MOVING>(&self.scene, &mut self.single, rays, lane, t_max);
            hits.set_lane(lane, hit);
        }
    }

    /// As [`closest`](Self::closest), but only triangles that emit are seen. For few of them this is far quicker.
    pub(crate) fn closest_light(&self, rays: &Rays8) -> Hits8 {
        let prepared = Prepared::new(rays);
        let mut hits = Hits8::none(rays.t_max);
        let data = self.scene.data();
        for light in data.lights {
            let open = data.triangles[light.triangle as usize].corners.map(Vec3x8::splat);
            let corners = match data.motion {
                None => open,
                Some(motion) => {
                    let closing = motion.triangles[light.triangle as usize].corners.map(Vec3x8::splat);
                    [0, 1, 2].map(|corner| between(open[corner], closing[corner], rays.time))
                }
            };
            triangle::closest(&prepared.frames, corners, light.triangle, &mut hits);
        }
        hits
    }

    /// The lanes, as bits, in which something lies between the origin and `t_max`. Idle lanes are not occluded.
    pub fn occluded(&mut self, rays: &Rays8) -> u32 {
        match self.scene.data().motion {
            None => self.occluded_of::<false>(rays),
            Some(_) => self.occluded_moving(rays),
        }
    }

    #[inline(never)]
    fn occluded_moving(&mut self, rays: &Rays8) -> u32 {
        self.occluded_of::<true>(rays)
    }

    #[inline(always)]
    fn occluded_of<const MOVING: bool>(&mut self, rays: &Rays8) -> u32 {
        let prepared = Prepared::new(rays);
        let active = rays.active();
        if self.scene.data().nodes.is_empty() || active == 0 {
            return 0;
        }
        match prepared.slopes.common_signs(active) {
            Some(signs) => self.find_any::<MOVING, _>(&prepared, Signed(signs), rays.t_max, active),
            None => self.find_any::<MOVING, _>(&prepared, Mixed, rays.t_max, active),
        }
    }

    fn find_closest<const MOVING: bool, S: Slabs>(&mut self, rays: &Prepared, slabs: S, hits: &mut Hits8) {
        let (data, stack) = (self.scene.data(), &mut self.stack);
        stack[0] = ROOT;
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let entry = stack[top];
            if !entry.near.simd_le(hits.t).any() {
                continue;
            }
            if entry.count > 0 {
                let leaf = Leaf { first: entry.first, count: entry.count };
                for slot in 0..entry.count {
                    let corners = leaf.one::<MOVING>(data, slot as usize, rays.time);
                    triangle::closest(&rays.frames, corners, leaf.first + slot, hits);
                }
                continue;
            }
            let node = &data.nodes[entry.first as usize];
            let bottom = top;
            for child in 0..8 {
                if !node.is_used(child) {
                    break;
                }
                let near = slabs.enter(&rays.slopes, node, child, hits.t);
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

    fn find_any<const MOVING: bool, S: Slabs>(
        &mut self,
        rays: &Prepared,
        slabs: S,
        mut t_max: f32x8,
        active: u32,
    ) -> u32 {
        self.shadow_stack[0] = (0, active);
        let mut top = 1;
        let mut blocked = 0;
        while top > 0 {
            top -= 1;
            let (index, met) = self.shadow_stack[top];
            let left = met & !blocked;
            if left.count_ones() <= FEW {
                blocked |= self.find_any_each::<MOVING>(rays, left, index, &mut t_max);
                if blocked == active {
                    return blocked;
                }
                continue;
            }
            let data = self.scene.data();
            let node = &data.nodes[index as usize];
            for child in 0..8 {
                if !node.is_used(child) {
                    break;
                }
                let met = slabs.enter(&rays.slopes, node, child, t_max).simd_ge(f32x8::ZERO).to_bitmask();
                if met == 0 {
                    continue;
                }
                let (first, count) = (node.child[child], node.count[child]);
                if count == 0 {
                    self.shadow_stack[top] = (first, met);
                    top += 1;
                    continue;
                }
                for slot in 0..count {
                    let corners = Leaf { first, count }.one::<MOVING>(data, slot as usize, rays.time);
                    let hit = triangle::blocks(&rays.frames, corners, t_max);
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

    /// The rays among `lanes` for which the subtree below `node` is in the way; their `t_max` becomes negative.
    fn find_any_each<const MOVING: bool>(
        &mut self,
        rays: &Prepared,
        mut lanes: u32,
        node: u32,
        t_max: &mut f32x8,
    ) -> u32 {
        let mut blocked = 0;
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & 7;
            lanes &= lanes - 1;
            let t = &mut t_max.as_mut_array()[lane];
            if single::find_any::<MOVING>(&self.scene, &mut self.single, rays, lane, node, *t) {
                blocked |= 1 << lane;
                *t = -1.0;
            }
        }
        blocked
    }
}

/// Whether all active directions lie in a narrow cone.
#[inline(always)]
fn is_coherent(direction: Vec3x8, active: u32) -> bool {
    let first = active.trailing_zeros() as usize & 7;
    let one = |v: f32x8| f32x8::splat(v.as_array()[first]);
    let axis = Vec3x8::new(one(direction.x), one(direction.y), one(direction.z));
    let near = direction.dot(axis).simd_ge(f32x8::splat(COHERENT)).to_bitmask();
    active & !near == 0
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
    let [low, high]: [f32x4; 2] = bytemuck::cast(near);
    let [a, b, c, d] = low.fast_min(high).to_array();
    lesser(lesser(a, b), lesser(c, d))
}

/// How the packet enters a child's box.
trait Slabs {
    /// The distance, at least 0, at which each ray enters the box; negative where it misses.
    fn enter(&self, slopes: &Slopes, node: &Node8, child: usize, t_max: f32x8) -> f32x8;
}

/// All rays point into the same octant: which plane comes first is known.
struct Signed([bool; 3]);

impl Slabs for Signed {
    #[inline(always)]
    fn enter(&self, slopes: &Slopes, node: &Node8, child: usize, t_max: f32x8) -> f32x8 {
        let plane = |axis: usize, upper: bool| {
            let bounds = if upper { &node.upper } else { &node.lower };
            slope(slopes, axis, bounds[axis][child])
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
    fn enter(&self, slopes: &Slopes, node: &Node8, child: usize, t_max: f32x8) -> f32x8 {
        let lower = [0, 1, 2].map(|axis| slope(slopes, axis, node.lower[axis][child]));
        let upper = [0, 1, 2].map(|axis| slope(slopes, axis, node.upper[axis][child]));
        let near = [0, 1, 2].map(|axis| lower[axis].fast_min(upper[axis]));
        let far = [0, 1, 2].map(|axis| lower[axis].fast_max(upper[axis]));
        overlap(near, far, t_max)
    }
}

/// The distance at which each ray meets the plane.
#[inline(always)]
fn slope(slopes: &Slopes, axis: usize, plane: f32) -> f32x8 {
    f32x8::splat(plane).mul_sub(slopes.inverse[axis], slopes.offset[axis])
}

#[inline(always)]
fn overlap(near: [f32x8; 3], far: [f32x8; 3], t_max: f32x8) -> f32x8 {
    let enter = near[0].fast_max(near[1]).fast_max(near[2].fast_max(f32x8::ZERO));
    let leave = far[0].fast_min(far[1]).fast_min(far[2].fast_min(t_max));
    enter.simd_le(leave).select(enter, f32x8::splat(-1.0))
}
