//! Allocation over some of the pixels.
//!
//! Pixel by pixel, the cumulative sum in double precision: within some hundred units of 2^-32 sample.

use super::{Before, Shares};

/// The weight of a pixel that gets nothing, not even of what all get alike.
pub(crate) const CLOSED: f32 = f32::NEG_INFINITY;

impl Before {
    /// With those of some pixels that are not [`CLOSED`], by the weights that `shares` gives them.
    pub fn and_open(self, shares: &Shares, target: &[f32]) -> Before {
        let open = target.iter().filter(|weight| **weight != CLOSED);
        open.fold(self, |before, weight| before.and_pixel(shares.weight(*weight)))
    }

    #[inline(always)]
    fn and_pixel(self, weight: f32) -> Before {
        Before { pixels: self.pixels + 1.0, weights: self.weights + f64::from(weight) }
    }
}

impl Shares {
    /// [`divide`](Self::divide) over the pixels that are not [`CLOSED`], which stay so.
    pub fn divide_open(&self, mut before: Before, target: &mut [f32], planned: &mut [u32]) {
        let mut steps = self.steps(before);
        planned.fill(0);
        for (target, planned) in target.iter_mut().zip(planned).filter(|(target, _)| **target != CLOSED) {
            before = before.and_pixel(self.weight(*target));
            let units = steps.run(&[0], core::slice::from_mut(planned), self.end(before));
            *target = units as f32 * self.samples;
        }
    }
}
