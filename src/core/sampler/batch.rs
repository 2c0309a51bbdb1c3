//! What the sampler and a renderer exchange: eight image-plane samples in, eight radiances out.
//!
//! The sampler fills [`Batch8`]s, an [`Integrand`] answers each with an [`Rgb8`]. Nothing else crosses the
//! border, so a path tracer, a lightmap baker and an analytic test function are all the same to the core.

use crate::maths::eight::write8;
use crate::maths::sobol;
use wide::{f32x8, u32x8};

/// Radiances beyond this are rejected like those that are not finite: their squares would overflow.
pub const MAX_RADIANCE: f32 = 1e15;

/// Eight image-plane samples, structure of arrays. Lanes may belong to different pixels.
#[derive(Clone, Copy, Debug, Default)]
pub struct Batch8 {
    /// Number of lanes that carry a sample, 1 to 8. The others repeat the last one; their radiance is ignored.
    pub lanes: u32,
    /// Horizontal film position in pixels, `0 ≤ x < width`, growing to the right.
    pub x: f32x8,
    /// Vertical film position in pixels, `0 ≤ y < height`, growing downwards.
    pub y: f32x8,
    /// Number of the sample in its pixel's sequence.
    pub index: u32x8,
    /// Scrambling key of the pixel's sequence.
    pub key: u32x8,
}

impl Batch8 {
    /// The samples' points in the padded two-dimensional set `set`, both coordinates in `[0, 1)`.
    ///
    /// Set 0 has placed the sample inside its pixel already; an integrand starts from set 1.
    #[inline]
    pub fn point(&self, set: u32) -> (f32x8, f32x8) {
        sobol::point(self.index, self.key, set)
    }
}

/// Eight linear RGB radiances, structure of arrays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rgb8 {
    /// Red.
    pub r: f32x8,
    /// Green.
    pub g: f32x8,
    /// Blue.
    pub b: f32x8,
}

/// A renderer, seen from the sampler: a function of image-plane samples. A closure `FnMut(&Batch8) -> Rgb8` is one.
///
/// Implement [`radiance`](Self::radiance); override [`stream`](Self::stream) where many samples at once can
/// be worked on better than eight (a path tracer that refills its lanes, for example).
pub trait Integrand {
    /// The radiance seen through each of eight samples.
    fn radiance(&mut self, batch: &Batch8) -> Rgb8;

    /// The radiance seen through each sample of `batches`, written to the same place of `radiance`.
    ///
    /// The slices have equal lengths.
    fn stream(&mut self, batches: &[Batch8], radiance: &mut [Rgb8]) {
        for (batch, out) in batches.iter().zip(radiance) {
            *out = self.radiance(batch);
        }
    }
}

impl<F: FnMut(&Batch8) -> Rgb8 + ?Sized> Integrand for F {
    fn radiance(&mut self, batch: &Batch8) -> Rgb8 {
        self(batch)
    }
}

/// Arrays lent for samples; the shortest says how many.
#[derive(Debug)]
pub struct Wave<'w> {
    /// Horizontal film positions in pixels, growing to the right.
    pub x: &'w mut [f32],
    /// Vertical film positions in pixels, growing downwards.
    pub y: &'w mut [f32],
    /// Numbers of the samples in their pixels' sequences.
    pub index: &'w mut [u32],
    /// Keys of the pixels' sequences.
    pub key: &'w mut [u32],
}

impl Wave<'_> {
    pub(super) fn len(&self) -> usize {
        self.x.len().min(self.y.len()).min(self.index.len()).min(self.key.len())
    }
}

/// Writes the points of set `set` of the samples named by `index` and `key`, coordinates in `[0, 1)`, as many as the shortest
/// slice has.
pub fn points(set: u32, index: &[u32], key: &[u32], u: &mut [f32], v: &mut [f32]) {
    let eight = |from: &[u32]| {
        let mut lanes = [0; 8];
        lanes.iter_mut().zip(from).for_each(|(lane, value)| *lane = *value);
        u32x8::from(lanes)
    };
    let names = index.chunks(8).zip(key.chunks(8));
    for ((index, key), (u, v)) in names.zip(u.chunks_mut(8).zip(v.chunks_mut(8))) {
        let length = index.len().min(key.len());
        let (x, y) = sobol::point(eight(index), eight(key), set);
        let (across, down) = (u.len().min(length), v.len().min(length));
        write8(&mut u[..across], x);
        write8(&mut v[..down], y);
    }
}
