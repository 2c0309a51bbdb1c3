//! Numbers of any bits.

use pmcip_core::sampler::batch::{Batch8, Integrand, Rgb8};
use wide::f32x8;

/// Numbers in turn from a list of any bits, 1 if it is empty.
pub struct Any<'a> {
    bits: &'a [u32],
    next: usize,
}

impl<'a> Any<'a> {
    pub fn new(bits: &'a [u32]) -> Self {
        Any { bits, next: 0 }
    }

    pub fn one(&mut self) -> f32 {
        self.next += 1;
        self.bits.get(self.next % self.bits.len().max(1)).map_or(1.0, |bits| f32::from_bits(*bits))
    }

    pub fn eight(&mut self) -> f32x8 {
        f32x8::from(std::array::from_fn(|_| self.one()))
    }
}

impl Integrand for Any<'_> {
    fn radiance(&mut self, _: &Batch8) -> Rgb8 {
        Rgb8 { r: self.eight(), g: self.eight(), b: self.eight() }
    }
}
