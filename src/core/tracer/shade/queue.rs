//! Paths under way, packed into full packets whatever lane they come from.
//!
//! A path that survives a bounce is copied into the open packet of its direction's octant; a packet that is full
//! joins the queue. So lanes stay full while paths end, and the rays of a packet keep a common order of slabs.

use super::cutout::Chance;
use crate::maths::vec3::Vec3x8;
use crate::tracer::scene::Scene;
use crate::tracer::trace::Rays8;
use wide::{f32x8, u32x8};

/// What is known of eight paths. Opaque: the memory a [`PathTracer`](super::path::PathTracer) is lent.
///
/// Stored as rows so that moving a lane is one loop; integers are stored by their bits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(32))]
pub struct Packet {
    rows: [[f32; 8]; ROWS],
    lanes: u32,
}

const ROWS: usize = 15;

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
        let [index, key, slot, normal] = [p.index, p.key, p.slot, p.normal].map(bits);
        let rows =
            [o.x, o.y, o.z, d.x, d.y, d.z, t.x, t.y, t.z, p.density, p.compression, index, key, slot, normal];
        Packet { rows: rows.map(f32x8::to_array), lanes: p.lanes }
    }

    #[inline(always)]
    pub(super) fn unpack(&self) -> Paths {
        let row = |i: usize| f32x8::from(self.rows[i]);
        let vector = |i: usize| Vec3x8::new(row(i), row(i + 1), row(i + 2));
        let integer = |i: usize| bytemuck::cast::<_, u32x8>(row(i));
        Paths {
            origin: vector(0),
            direction: vector(3),
            throughput: vector(6),
            density: row(9),
            compression: row(10),
            index: integer(11),
            key: integer(12),
            slot: integer(13),
            normal: integer(14),
            lanes: self.lanes,
        }
    }

    #[inline(always)]
    fn take_lane(&mut self, to: usize, from: &Packet, lane: usize) {
        for (row, source) in self.rows.iter_mut().zip(&from.rows) {
            row[to] = source[lane];
        }
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

/// Packets of one bounce, read from the front while those of the next are written behind.
///
/// Reading and writing share the memory: what is written never overtakes what was read, but for the up to eight
/// open packets that close a bounce.
pub(super) struct Queue<'a> {
    packets: &'a mut [Packet],
    /// Packets of the current bounce.
    len: usize,
    /// Full packets of the next.
    written: usize,
    open: Open,
}

/// Packets that are being filled, one for each octant of directions.
#[derive(Clone, Debug, Default)]
pub(super) struct Open {
    packets: [Packet; 8],
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
            let open = &mut self.packets[octant[lane] as usize & 7];
            open.take_lane(open.lanes as usize & 7, &from, lane);
            open.lanes += 1;
            if open.lanes == 8 {
                full(open);
                open.lanes = 0;
            }
        }
    }

    /// Hands what is left to `part`, packet by packet.
    pub fn drain(&mut self, mut part: impl FnMut(&Packet)) {
        for open in self.packets.iter_mut().filter(|open| open.lanes > 0) {
            part(open);
            open.lanes = 0;
        }
    }
}

/// Packets the queue needs beyond those that start: the open ones.
pub(super) const SLACK: usize = 8;

impl<'a> Queue<'a> {
    pub fn new(packets: &'a mut [Packet]) -> Self {
        Queue { packets, len: 0, written: 0, open: Open::default() }
    }

    /// How many packets may start.
    pub fn capacity(&self) -> usize {
        self.packets.len().saturating_sub(SLACK)
    }

    pub fn len(&self) -> usize {
        self.len
    }

    pub fn packet(&self, i: usize) -> Paths {
        self.packets[i].unpack()
    }

    /// Adds a packet to the current bounce, as it is.
    pub fn start(&mut self, paths: &Paths) {
        self.packets[self.len] = Packet::pack(paths);
        self.len += 1;
    }

    /// Adds the lanes of `paths` whose bit is set in `alive` to the next bounce.
    #[inline]
    pub fn push(&mut self, paths: &Paths, alive: u32) {
        let Queue { packets, written, open, .. } = self;
        open.push(paths, alive, |packet| {
            packets[*written] = *packet;
            *written += 1;
        });
    }

    /// Closes the bounce: what was pushed becomes current.
    pub fn turn(&mut self) {
        let Queue { packets, written, open, .. } = self;
        open.drain(|packet| {
            packets[*written] = *packet;
            *written += 1;
        });
        self.len = core::mem::take(written);
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.len = 0;
        self.written = 0;
        self.open.drain(|_| ());
    }
}

/// The octant of each direction, 0 to 7.
#[inline(always)]
fn octants(d: Vec3x8) -> [u32; 8] {
    let negative =
        |v: f32x8, bit: u32| bytemuck::cast::<_, u32x8>(v.simd_lt(f32x8::ZERO)) & u32x8::splat(bit);
    (negative(d.x, 1) | negative(d.y, 2) | negative(d.z, 4)).to_array()
}

#[cfg(test)]
mod tests;
