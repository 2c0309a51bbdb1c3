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

const ROWS: usize = 11;

/// The open packet of shadow rays.
#[derive(Clone, Debug, Default)]
pub(super) struct Shadows {
    rows: [[f32; 8]; ROWS],
    slot: [u32; 8],
    lanes: u32,
}

impl Shadows {
    /// Rays waiting.
    pub fn lanes(&self) -> u32 {
        self.lanes
    }

    /// Takes in the lanes of `rays` whose bit is set in `wanted` while there is room; returns those left over.
    #[inline]
    pub fn fill(&mut self, rays: &ShadowRays, mut wanted: u32) -> u32 {
        let (o, d, v) = (rays.origin, rays.direction, rays.value);
        let from = [o.x, o.y, o.z, d.x, d.y, d.z, rays.t_max, rays.time, v.x, v.y, v.z].map(f32x8::to_array);
        let slot = rays.slot.to_array();
        while wanted != 0 && self.lanes < 8 {
            let lane = wanted.trailing_zeros() as usize & 7;
            wanted &= wanted - 1;
            let to = self.lanes as usize & 7;
            for (row, source) in self.rows.iter_mut().zip(&from) {
                row[to] = source[lane];
            }
            self.slot[to] = slot[lane];
            self.lanes += 1;
        }
        wanted
    }

    /// Empties the packet; returns the lanes that were in use, as bits.
    pub fn take(&mut self) -> u32 {
        (1 << core::mem::take(&mut self.lanes)) - 1
    }

    /// The packet as rays.
    #[inline(always)]
    pub fn rays(&self) -> Rays8 {
        let row = |i: usize| f32x8::from(self.rows[i]);
        let used = super::queue::lane_mask((1 << self.lanes) - 1);
        Rays8 {
            origin: Vec3x8::new(row(0), row(1), row(2)),
            direction: Vec3x8::new(row(3), row(4), row(5)),
            t_max: used.select(row(6), f32x8::splat(-1.0)),
            time: row(7),
        }
    }

    /// Dims what the rays carry to a part of it; returns the lanes in which anything is left, as bits.
    pub fn dim(&mut self, part: f32x8) -> u32 {
        for row in &mut self.rows[8..] {
            *row = (f32x8::from(*row) * part).to_array();
        }
        part.simd_gt(f32x8::ZERO).to_bitmask()
    }

    /// Adds the values of the lanes in `free` to their samples.
    #[inline(always)]
    pub fn deliver(&self, free: u32, radiance: &mut [Rgb8]) {
        let row = |i: usize| f32x8::from(self.rows[i]);
        accumulate(radiance, self.slot.into(), Vec3x8::new(row(8), row(9), row(10)), free);
    }
}

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
