//! Shadow rays, gathered until a packet is full.

use crate::maths::vec3::Vec3x8;
use crate::sampler::batch::Rgb8;
use crate::tracer::trace::Rays8;
use wide::{f32x8, u32x8};

/// Eight shadow rays and the radiance each delivers when nothing is in its way.
pub(super) struct ShadowRays {
    pub origin: Vec3x8,
    pub direction: Vec3x8,
    pub t_max: f32x8,
    pub time: f32x8,
    pub value: Vec3x8,
    /// Number of the sample in the stream.
    pub slot: u32x8,
}

impl ShadowRays {
    /// `a` where the mask's bits are set, `b` elsewhere. Both are of the same samples.
    #[inline(always)]
    pub fn select(mask: f32x8, a: &ShadowRays, b: &ShadowRays) -> ShadowRays {
        ShadowRays {
            origin: Vec3x8::select(mask, a.origin, b.origin),
            direction: Vec3x8::select(mask, a.direction, b.direction),
            t_max: mask.select(a.t_max, b.t_max),
            time: a.time,
            value: Vec3x8::select(mask, a.value, b.value),
            slot: a.slot,
        }
    }
}

const ROWS: usize = 12;

/// Shadow rays that wait: a packet, and up to seven that are the beginning of the next.
#[derive(Clone, Debug, Default)]
pub(super) struct Shadows {
    /// Eight numbers of the rays, three of what they carry, the bits of their samples' numbers.
    rows: [[f32; 16]; ROWS],
    waiting: u32,
}

impl Shadows {
    /// Rays of the packet, of which there are eight at most.
    pub fn lanes(&self) -> u32 {
        self.waiting.min(8)
    }

    /// Takes in the lanes of `rays` whose bit is set in `wanted`. There must not be a full packet.
    #[inline(always)]
    pub fn fill(&mut self, rays: &ShadowRays, wanted: u32) {
        let (o, d, v) = (rays.origin, rays.direction, rays.value);
        let slot = bytemuck::cast(rays.slot);
        let from = [o.x, o.y, o.z, d.x, d.y, d.z, rays.t_max, rays.time, v.x, v.y, v.z, slot];
        let order = u32x8::from(FRONT[wanted as usize & 255].map(u32::from));
        let at = self.waiting as usize & 7;
        for (row, from) in self.rows.iter_mut().zip(from) {
            row[at..at + 8].copy_from_slice(from.shuffle_wrapping(order).as_array());
        }
        self.waiting += wanted.count_ones();
    }

    /// Removes the packet.
    pub fn pass(&mut self) {
        for row in &mut self.rows {
            row.copy_within(8.., 0);
        }
        self.waiting -= self.lanes();
    }

    /// The lanes of the packet, as bits.
    pub fn used(&self) -> u32 {
        (1 << self.lanes()) - 1
    }

    #[inline(always)]
    fn row(&self, i: usize) -> f32x8 {
        f32x8::from(&self.rows[i][..8])
    }

    /// The packet as rays.
    #[inline(always)]
    pub fn rays(&self) -> Rays8 {
        let row = |i: usize| self.row(i);
        let used = super::queue::lane_mask(self.used());
        Rays8 {
            origin: Vec3x8::new(row(0), row(1), row(2)),
            direction: Vec3x8::new(row(3), row(4), row(5)),
            t_max: used.select(row(6), f32x8::splat(-1.0)),
            time: row(7),
        }
    }

    /// Dims what the rays carry to a part of it; returns the lanes in which anything is left, as bits.
    pub fn dim(&mut self, part: f32x8) -> u32 {
        for row in 8..11 {
            let dimmed = self.row(row) * part;
            self.rows[row][..8].copy_from_slice(dimmed.as_array());
        }
        part.simd_gt(f32x8::ZERO).to_bitmask()
    }

    /// Adds the values of the lanes in `free` to their samples.
    #[inline(always)]
    pub fn deliver(&self, free: u32, radiance: &mut [Rgb8]) {
        let value = Vec3x8::new(self.row(8), self.row(9), self.row(10));
        accumulate(radiance, bytemuck::cast(self.row(11)), value, free & self.used());
    }
}

/// For each set of lanes, as bits, these in turn, to be moved to the front.
const FRONT: [[u8; 8]; 256] = {
    let (mut all, mut set) = ([[0; 8]; 256], 0);
    while set < 256 {
        let (mut lane, mut at) = (0, 0);
        while lane < 8 {
            if set >> lane & 1 == 1 {
                all[set][at] = lane as u8;
                at += 1;
            }
            lane += 1;
        }
        set += 1;
    }
    all
};

/// Adds `value` to the samples `slot`, in the lanes whose bit is set.
#[inline(always)]
pub(super) fn accumulate(radiance: &mut [Rgb8], slot: u32x8, value: Vec3x8, mut lanes: u32) {
    let slot = slot.to_array();
    let value = [value.x.to_array(), value.y.to_array(), value.z.to_array()];
    while lanes != 0 {
        let lane = lanes.trailing_zeros() as usize & 7;
        lanes &= lanes - 1;
        let (batch, at) = (slot[lane] as usize / 8, slot[lane] as usize % 8);
        let out = &mut radiance[batch];
        out.r.as_mut_array()[at] += value[0][lane];
        out.g.as_mut_array()[at] += value[1][lane];
        out.b.as_mut_array()[at] += value[2][lane];
    }
}

#[cfg(test)]
mod tests;
