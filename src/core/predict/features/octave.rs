//! The blurred pictures of one octave of scale.

use super::blur;
use super::picture::Picture;

/// Steps of scale an octave is divided into.
pub(super) const STEPS: usize = 3;
/// Blurred pictures of an octave: two more than differences, which are two more than steps.
pub(super) const LEVELS: usize = STEPS + 3;
/// Blur that a picture is taken to have, in pixels.
const CAMERA_BLUR: f32 = 0.5;

/// The blurred pictures of one octave.
pub(super) struct Octave<'a> {
    pub planes: &'a [f32],
    pub width: usize,
    pub height: usize,
}

impl Octave<'_> {
    /// One of the blurred pictures.
    pub fn level(&self, level: usize) -> &[f32] {
        let pixels = self.width * self.height;
        &self.planes[level * pixels..][..pixels]
    }
}

/// The picture, clamped and blurred, as the first level.
pub(super) fn start(picture: &Picture<'_>, blur: f32, planes: &mut [f32], row: &mut [f32]) {
    let size = (picture.width, picture.height);
    let (target, rest) = planes.split_at_mut(picture.values.len());
    let source = &mut rest[..picture.values.len()];
    for (clamped, value) in source.iter_mut().zip(picture.values) {
        *clamped = if *value > 0.0 { value.min(1.0) } else { 0.0 };
    }
    let by = libm::sqrtf(blur * blur - CAMERA_BLUR * CAMERA_BLUR);
    blur::blur(source, target, size, by, row);
}

/// Every level from the one below it.
pub(super) fn blur_levels(planes: &mut [f32], size: (usize, usize), first: f32, row: &mut [f32]) {
    let pixels = size.0 * size.1;
    for level in 1..LEVELS {
        let (done, rest) = planes.split_at_mut(level * pixels);
        let (old, new) = (level_blur(first, level as f32 - 1.0), level_blur(first, level as f32));
        let by = libm::sqrtf(new * new - old * old);
        blur::blur(&done[(level - 1) * pixels..], &mut rest[..pixels], size, by, row);
    }
}

/// Blur of a level in pixels of its octave.
pub(super) fn level_blur(first: f32, level: f32) -> f32 {
    first * libm::exp2f(level / STEPS as f32)
}

/// Every second pixel of the level of twice the first one's blur becomes the first level of the next octave.
pub(super) fn halve(planes: &mut [f32], width: usize, height: usize) -> (usize, usize) {
    let (target, source) = planes.split_at_mut(STEPS * width * height);
    let (half_width, half_height) = (width / 2, height / 2);
    for (target, source) in
        target.chunks_exact_mut(half_width).take(half_height).zip(source.chunks_exact(2 * width))
    {
        target.iter_mut().zip(source.iter().step_by(2)).for_each(|(to, from)| *to = *from);
    }
    (half_width, half_height)
}
