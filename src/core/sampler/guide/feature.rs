//! What a renderer knows of a pixel without noise, or with little.

/// What is seen through a pixel, averaged over it.
///
/// A surface seen in a mirror or through smooth glass is meant, not the glass. Where nothing is seen all is 0. Any caller
/// may fill these from what he has; numbers need not be exact, and what is not finite counts as 0.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Feature {
    /// Part of the light that the surface reflects, 1 where it shines itself.
    pub albedo: [f32; 3],
    /// Shading normal, of length 1 where all of the pixel has the same.
    pub normal: [f32; 3],
    /// Length of the way from the eye, in any unit.
    pub depth: f32,
}

/// Least albedo light is divided by.
const LEAST_ALBEDO: f32 = 0.02;
/// Largest number of a feature, so that no square overflows.
const LARGEST: f32 = 1e12;

impl Feature {
    /// Makes the mean of `number` samples that of one more: for hosts that see features sample by sample, with the sample's
    /// [index](crate::sampler::batch::Batch8::index) as `number`.
    pub fn add(&mut self, sample: &Feature, number: u32) {
        let part = 1.0 / (number as f32 + 1.0);
        let towards = |mean: f32, new: f32| mean + (new - mean) * part;
        let colour = |mean: [f32; 3], new: [f32; 3]| core::array::from_fn(|c| towards(mean[c], new[c]));
        let sample = sample.limited();
        *self = Feature {
            albedo: colour(self.albedo, sample.albedo),
            normal: colour(self.normal, sample.normal),
            depth: towards(self.depth, sample.depth),
        };
    }

    /// What radiance is divided by to be light.
    pub(super) fn divisor(&self) -> [f32; 3] {
        self.albedo.map(|a| a.max(LEAST_ALBEDO))
    }

    /// All numbers finite, and none too large to be squared.
    pub(super) fn limited(&self) -> Feature {
        let limit = |v: f32| if v.is_finite() { v.clamp(-LARGEST, LARGEST) } else { 0.0 };
        Feature { albedo: self.albedo.map(limit), normal: self.normal.map(limit), depth: limit(self.depth) }
    }
}
