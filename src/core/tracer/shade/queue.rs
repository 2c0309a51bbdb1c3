//! Paths under way, packed into full packets whatever lane they come from.
//!
//! Paths that survive a bounce are sorted by where they are and whither they go. So lanes stay full while paths end, and
//! the rays of a packet meet the same boxes, most of them in a common order of slabs.

use super::cutout::Chance;
use crate::maths::vec3::Vec3x8;
use crate::tracer::scene::{Node8, Scene};
use crate::tracer::trace::Rays8;
use bytemuck::{Pod, Zeroable};
use wide::{f32x8, u32x8};

/// What is known of eight paths. Opaque: the memory a [`PathTracer`](super::path::PathTracer) is lent.
///
/// A path is a cache line, so that moving it to another packet is two loads and two stores. Integers are stored by their
/// bits. The last number of the first path is that of the lanes in use; while paths are sorted, that of each is its kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Packet {
    paths: [Path; 8],
}

/// What is known of a path.
type Path = [f32; 16];

/// Index of its last number.
const LAST: usize = 15;

/// Eight paths, unpacked.
#[derive(Clone, Copy)]
pub(super) struct Paths {
    pub origin: Vec3x8,
    pub direction: Vec3x8,
    pub throughput: Vec3x8,
    /// Density with which `direction` was sampled; infinite where it could not have been otherwise.
    pub density: f32x8,
    /// Squared index ratio that the throughput contains.
    pub compression: f32x8,
    /// Unit shading normal where `direction` was sampled, packed; of use to find out how the light tree would have
    /// picked what the path hits.
    pub normal: u32x8,
    pub index: u32x8,
    pub key: u32x8,
    /// Number of the sample in the stream.
    pub slot: u32x8,
    /// Lanes in use.
    pub lanes: u32,
}

impl Packet {
    #[inline(always)]
    pub(super) fn pack(p: &Paths) -> Self {
        let bits = |v: u32x8| bytemuck::cast::<_, f32x8>(v);
        let (o, d, t) = (p.origin, p.direction, p.throughput);
        let [index, key, slot, normal, lanes] =
            [p.index, p.key, p.slot, p.normal, u32x8::splat(p.lanes)].map(bits);
        let first = f32x8::transpose([o.x, o.y, o.z, d.x, d.y, d.z, t.x, t.y]);
        let last = f32x8::transpose([t.z, p.density, p.compression, index, key, slot, normal, lanes]);
        let path = |i: usize| bytemuck::cast([first[i], last[i]]);
        Packet { paths: core::array::from_fn(path) }
    }

    #[inline(always)]
    pub(super) fn unpack(&self) -> Paths {
        let integer = |v: f32x8| bytemuck::cast::<_, u32x8>(v);
        let half =
            |i: usize| f32x8::transpose(self.paths.each_ref().map(|path| f32x8::from(&path[8 * i..][..8])));
        let [ox, oy, oz, dx, dy, dz, tx, ty] = half(0);
        let [tz, density, compression, index, key, slot, normal, _] = half(1);
        Paths {
            origin: Vec3x8::new(ox, oy, oz),
            direction: Vec3x8::new(dx, dy, dz),
            throughput: Vec3x8::new(tx, ty, tz),
            density,
            compression,
            index: integer(index),
            key: integer(key),
            slot: integer(slot),
            normal: integer(normal),
            lanes: self.lanes(),
        }
    }

    #[inline(always)]
    fn lanes(&self) -> u32 {
        self.paths[0][LAST].to_bits()
    }

    #[inline(always)]
    fn set_lanes(&mut self, lanes: u32) {
        self.paths[0][LAST] = f32::from_bits(lanes);
    }
}

impl Paths {
    /// What decides at segment number `depth` whether cut-outs are met.
    #[inline(always)]
    pub fn chance(&self, depth: u32) -> Chance {
        Chance { index: self.index, key: self.key, depth }
    }

    /// The paths' rays, endless.
    #[inline(always)]
    pub fn rays(&self, scene: &Scene<'_>) -> Rays8 {
        let used = lane_mask((1 << self.lanes) - 1);
        let t_max = used.select(f32x8::splat(f32::INFINITY), f32x8::splat(-1.0));
        self.rays_to(t_max, scene)
    }

    /// The paths' rays up to a distance; negative where there is none.
    #[inline(always)]
    pub fn rays_to(&self, t_max: f32x8, scene: &Scene<'_>) -> Rays8 {
        let time = scene.time(self.index, self.key);
        Rays8 { origin: self.origin, direction: self.direction, t_max, time }
    }
}

/// The lanes whose bit is set, all bits set.
#[inline(always)]
pub(super) fn lane_mask(bits: u32) -> f32x8 {
    let lanes = u32x8::new([1, 2, 4, 8, 16, 32, 64, 128]);
    bytemuck::cast((u32x8::splat(bits) & lanes).simd_eq(lanes))
}

/// Packets that are being filled, one for each octant of directions, and how many lanes of each are.
#[derive(Clone, Debug, Default)]
pub(super) struct Open {
    packets: [Packet; 8],
    lanes: [u32; 8],
}

impl Open {
    /// Adds the lanes of `paths` whose bit is set in `alive`; hands packets that fill up to `full`.
    #[inline]
    pub fn push(&mut self, paths: &Paths, mut alive: u32, mut full: impl FnMut(&Packet)) {
        let from = Packet::pack(paths);
        let octant = octants(paths.direction);
        while alive != 0 {
            let lane = alive.trailing_zeros() as usize & 7;
            alive &= alive - 1;
            let octant = octant[lane] as usize & 7;
            let (open, to) = (&mut self.packets[octant], self.lanes[octant] as usize & 7);
            open.paths[to] = from.paths[lane];
            self.lanes[octant] = (to as u32 + 1) & 7;
            if to == 7 {
                open.set_lanes(8);
                full(open);
            }
        }
    }

    /// Hands what is left to `part`, packet by packet.
    pub fn drain(&mut self, mut part: impl FnMut(&Packet)) {
        for (open, lanes) in self.packets.iter_mut().zip(&mut self.lanes).filter(|(_, lanes)| **lanes > 0) {
            open.set_lanes(core::mem::take(lanes));
            part(open);
        }
    }
}

/// Paths of one bounce, packet by packet, and those of the next, as they come. When the bounce is over these are sorted by
/// their [kinds](kinds): neighbours then meet the same parts of the scene, from the same sides.
///
/// Each has half of the memory: as many may come as there are, since none is pushed twice in a bounce.
pub(super) struct Queue<'a> {
    current: &'a mut [Packet],
    next: &'a mut [Packet],
    /// Packets of the current bounce.
    len: usize,
    /// Paths of the next, ...
    written: usize,
    /// ... and how many there are of each kind.
    counts: [u32; KINDS],
    /// Of the scene.
    centre: Vec3x8,
}

/// How many kinds of paths there are.
const KINDS: usize = 64;

impl<'a> Queue<'a> {
    /// Packets of memory needed for `paths` paths at once.
    pub const fn required(paths: usize) -> usize {
        2 * paths.div_ceil(8)
    }

    pub fn new(packets: &'a mut [Packet], scene: &Scene<'_>) -> Self {
        let half = packets.len() / 2;
        let (current, next) = packets.split_at_mut(half);
        let (lower, upper) = scene.data().nodes.first().map_or_else(Default::default, Node8::hull);
        let centre = Vec3x8::splat([0, 1, 2].map(|axis| 0.5 * (lower[axis] + upper[axis])));
        Queue { current, next, len: 0, written: 0, counts: [0; KINDS], centre }
    }

    /// How many packets may start.
    pub fn capacity(&self) -> usize {
        self.next.len().min(self.current.len())
    }

    pub fn len(&self) -> usize {
        self.len
    }

    pub fn packet(&self, i: usize) -> Paths {
        self.current[i].unpack()
    }

    /// Adds a packet to the current bounce, as it is.
    pub fn start(&mut self, paths: &Paths) {
        self.current[self.len] = Packet::pack(paths);
        self.len += 1;
    }

    /// Adds the lanes of `paths` whose bit is set in `alive` to the next bounce.
    #[inline]
    pub fn push(&mut self, paths: &Paths, mut alive: u32) {
        let from = Packet::pack(paths);
        let kinds = kinds(paths, self.centre);
        let next: &mut [Path] = bytemuck::cast_slice_mut(self.next);
        while alive != 0 {
            let lane = alive.trailing_zeros() as usize & 7;
            alive &= alive - 1;
            next[self.written] = from.paths[lane];
            next[self.written][LAST] = f32::from_bits(kinds[lane]);
            self.counts[kinds[lane] as usize % KINDS] += 1;
            self.written += 1;
        }
    }

    /// Closes the bounce: what was pushed becomes current.
    pub fn turn(&mut self) {
        let mut places = self.counts_before();
        let next: &[Path] = bytemuck::cast_slice(self.next);
        let current: &mut [Path] = bytemuck::cast_slice_mut(self.current);
        for path in &next[..self.written] {
            let place = &mut places[path[LAST].to_bits() as usize % KINDS];
            current[*place as usize] = *path;
            *place += 1;
        }
        self.len = self.written.div_ceil(8);
        for (i, packet) in self.current[..self.len].iter_mut().enumerate() {
            packet.set_lanes((self.written - 8 * i).min(8) as u32);
        }
        self.forget_next();
    }

    /// How many paths are of kinds before each.
    fn counts_before(&self) -> [u32; KINDS] {
        let (mut all, mut before) = (0, [0; KINDS]);
        for (before, count) in before.iter_mut().zip(self.counts) {
            (*before, all) = (all, all + count);
        }
        before
    }

    fn forget_next(&mut self) {
        (self.written, self.counts) = (0, [0; KINDS]);
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.len = 0;
        self.forget_next();
    }
}

/// Kinds of paths, below [`KINDS`]: the octant of the direction, then that of the origin seen from the scene's centre.
#[inline(always)]
fn kinds(paths: &Paths, centre: Vec3x8) -> [u32; 8] {
    let (direction, origin) = (octants(paths.direction), octants(paths.origin - centre));
    [0, 1, 2, 3, 4, 5, 6, 7].map(|lane| 8 * direction[lane] + origin[lane])
}

/// The octant of each vector, 0 to 7.
#[inline(always)]
fn octants(d: Vec3x8) -> [u32; 8] {
    let negative =
        |v: f32x8, bit: u32| bytemuck::cast::<_, u32x8>(v.simd_lt(f32x8::ZERO)) & u32x8::splat(bit);
    (negative(d.x, 1) | negative(d.y, 2) | negative(d.z, 4)).to_array()
}

#[cfg(test)]
mod tests;
