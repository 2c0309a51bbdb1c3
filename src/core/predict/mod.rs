//! What earlier frames of an animation tell about the next one: the start-up kernel.
//!
//! Lai, Chenney, Liu, Niu, Fan, *Animation rendering with Population Monte Carlo image-plane sampler*, The Visual
//! Computer 2010, section 3.2, carry the kernel α along the motion of the picture. Here a [`Belief`] is carried
//! instead: variance and luminance of a pixel's samples, and how many degrees of freedom that knowledge is worth. A
//! frame then adds to what earlier ones knew. From frame to frame:
//!
//! 1. [`carry`] moves the beliefs along a correspondence, from motion vectors or from
//!    homographies ([`tracks`]).
//! 2. [`Sampler::begin_predicted`](crate::sampler::Sampler::begin_predicted) takes them where the frame itself knows
//!    too little.
//! 3. [`Sampler::beliefs`](crate::sampler::Sampler::beliefs) says what the frame has seen, and [`Filter::update`]
//!    merges both: a scalar Kalman filter for every pixel (Kalman, *A new approach to linear filtering and prediction
//!    problems*, 1960) whose process noise is what the prediction was off by more than chance explains.
//!
//! What was carried stems from other frames, and is independent of the samples whose number it decides: no bias.
//!
//! Positions are in pixels from the upper left corner; the centre of the first pixel is (0.5, 0.5). Planes are rows from
//! the top. Everything is lent by the caller, and the same input gives the same bits.
//!
//! ```
//! use pmcip_core::predict::{Belief, Filter, carry};
//!
//! let old = [1.0, 2.0, 3.0, 4.0].map(|variance| Belief { variance, light: 1.0, freedom: 10.0 });
//! let from_the_right = [[1.5, 0.5], [2.5, 0.5], [3.5, 0.5], [f32::NAN; 2]];
//! let mut beliefs = [Belief::NONE; 4];
//! carry(&old, 4, 1, &from_the_right, Belief::NONE, &mut beliefs)?;
//! assert_eq!(beliefs.map(|b| b.variance), [2.0, 3.0, 4.0, 0.0]);
//!
//! let seen = [Belief { variance: 3.0, light: 1.0, freedom: 10.0 }; 4];
//! Filter::new(100.0).update(4, &mut beliefs, &seen)?;
//! assert!(beliefs[0].variance > 2.4 && beliefs[0].variance < 2.6 && beliefs[0].freedom > 15.0);
//! assert_eq!(beliefs[3], seen[3]);
//! # Ok::<(), pmcip_core::predict::Error>(())
//! ```

pub mod features;
pub mod homography;
pub mod tracks;

use crate::maths::tvi::tvi;
use wide::f32x8;

/// Side of the blocks over which the filter judges a prediction.
const BLOCK: usize = 16;

/// What is believed of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Belief {
    /// Variance of a sample's luminance, scene units squared.
    pub variance: f32,
    /// Mean luminance, scene units.
    pub light: f32,
    /// Degrees of freedom of the variance: of how many samples more than one it could be. 0: nothing is known.
    pub freedom: f32,
}

impl Belief {
    /// Nothing is known.
    pub const NONE: Belief = Belief { variance: 0.0, light: 0.0, freedom: 0.0 };

    /// Itself if it can be used: finite, and of positive freedom.
    #[inline]
    pub fn usable(&self) -> Option<Belief> {
        let fine = (0.0..f32::MAX).contains(&self.variance) && self.light.is_finite();
        (fine && self.freedom > 0.0 && self.freedom < f32::MAX).then_some(*self)
    }
}

/// What a frame starts from.
#[derive(Clone, Copy, Debug)]
pub enum Prior<'a> {
    /// One belief a pixel; they fill in where the frame itself knows too little, in any iteration.
    Beliefs(&'a [Belief]),
    /// A kernel, as published: it takes the place of the frame's own. What is not a number is taken for the mean.
    Alpha(&'a [f32]),
}

/// Why there is no prediction.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// A plane has not as many entries as the picture has pixels, or the picture has no columns.
    Size,
    /// Lent memory is shorter than asked for.
    Scratch,
}

impl core::fmt::Display for Error {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Error::Size => "all planes of a prediction must have one entry a pixel",
            Error::Scratch => "lent memory is too short for a prediction",
        })
    }
}

impl core::error::Error for Error {}

/// Moves a plane: every pixel takes what the pixel at its position in `positions` had `before`.
///
/// `nothing` where the position is outside of the picture or not a number. The nearest pixel is taken as it is:
/// blending would blur a plane that is carried through many frames.
///
/// # Errors
/// [`Error::Size`] if a slice has not `width · height` entries.
pub fn carry<T: Copy>(
    before: &[T],
    width: usize,
    height: usize,
    positions: &[[f32; 2]],
    nothing: T,
    out: &mut [T],
) -> Result<(), Error> {
    let pixels = width.checked_mul(height).ok_or(Error::Size)?;
    if [before.len(), positions.len(), out.len()] != [pixels; 3] {
        return Err(Error::Size);
    }
    for (out, position) in out.iter_mut().zip(positions) {
        *out = pixel_at(*position, width, height).map_or(nothing, |i| before[i]);
    }
    Ok(())
}

/// Index of the pixel at a position.
#[inline]
fn pixel_at([x, y]: [f32; 2], width: usize, height: usize) -> Option<usize> {
    let inside = x >= 0.0 && y >= 0.0 && x < width as f32 && y < height as f32;
    inside.then(|| (y as usize).min(height - 1) * width + (x as usize).min(width - 1))
}

/// Merges what was predicted with what was seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filter {
    /// Luminance in cd/m² of radiance 1.
    pub cd_per_unit: f32,
    /// Squared relative error of a variance times its degrees of freedom; 2 for normal samples, more if bright samples
    /// are rare.
    pub spread: f32,
    /// Squared relative change of a pixel's variance from frame to frame that is always reckoned with.
    pub drift: f32,
}

/// How well a frame was predicted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outlook {
    /// How far predicted and seen variances v and s were apart: Σ|s − v|/tvi over Σ max(s, v)/tvi. Small where samples
    /// are tame and the motion is known; large where rare bright samples make the noise, where details are smaller than
    /// a pixel, or after a cut; 1 if nothing was predicted. From 0 to 1.
    pub miss: f32,
    /// The part of the pixels of which anything had been predicted, 0 to 1.
    pub known: f32,
}

impl Filter {
    /// The defaults: spread 8, drift 0.05.
    pub fn new(cd_per_unit: f32) -> Filter {
        Filter { cd_per_unit, spread: 8.0, drift: 0.05 }
    }

    /// Makes the predictions in `beliefs`, rows of `width` pixels, what is known after having `seen` the frame.
    ///
    /// The process noise is common to blocks of 16 × 16 pixels, so that a single bright sample does not make its
    /// pixel forget.
    ///
    /// # Errors
    /// [`Error::Size`] if the planes differ in length or are not whole rows.
    pub fn update(&self, width: usize, beliefs: &mut [Belief], seen: &[Belief]) -> Result<Outlook, Error> {
        if width == 0 || beliefs.len() != seen.len() || !seen.len().is_multiple_of(width) {
            return Err(Error::Size);
        }
        let outlook = self.outlook(beliefs, seen);
        let strip = BLOCK * width;
        for (beliefs, seen) in beliefs.chunks_mut(strip).zip(seen.chunks(strip)) {
            for x in (0..width).step_by(BLOCK) {
                let columns = x..width.min(x + BLOCK);
                let noise = self.process_noise(width, columns.clone(), beliefs, seen);
                for (beliefs, seen) in beliefs.chunks_mut(width).zip(seen.chunks(width)) {
                    let pairs = beliefs[columns.clone()].iter_mut().zip(&seen[columns.clone()]);
                    pairs.for_each(|(belief, seen)| *belief = self.merge(belief, seen, noise));
                }
            }
        }
        Ok(outlook)
    }

    /// Squared relative change of the variance in a block beyond what chance explains.
    fn process_noise(
        &self,
        width: usize,
        columns: core::ops::Range<usize>,
        beliefs: &[Belief],
        seen: &[Belief],
    ) -> f32 {
        let (mut excess, mut pixels) = (0.0, 0.0);
        for (beliefs, seen) in beliefs.chunks(width).zip(seen.chunks(width)) {
            for (belief, seen) in beliefs[columns.clone()].iter().zip(&seen[columns.clone()]) {
                let (Some(belief), Some(seen)) = (belief.usable(), seen.usable()) else { continue };
                let largest = belief.variance.max(seen.variance);
                if largest > 0.0 {
                    let residual = (seen.variance - belief.variance) / largest;
                    let chance = self.spread * (1.0 / belief.freedom + 1.0 / seen.freedom);
                    excess += residual * residual - chance.min(1.0);
                    pixels += 1.0;
                }
            }
        }
        if pixels > 0.0 { self.drift + (excess / pixels).max(0.0) } else { self.drift }
    }

    /// One step of the filter: the prediction's variance is spread/freedom, to which the process noise adds.
    #[inline]
    fn merge(&self, belief: &Belief, seen: &Belief, noise: f32) -> Belief {
        let Some(old) = belief.usable() else { return seen.usable().unwrap_or(Belief::NONE) };
        let freedom = 1.0 / (1.0 / old.freedom + noise / self.spread);
        let Some(seen) = seen.usable() else { return Belief { freedom, ..old } };
        let gain = seen.freedom / (seen.freedom + freedom);
        Belief {
            variance: old.variance + gain * (seen.variance - old.variance),
            light: old.light + gain * (seen.light - old.light),
            freedom: freedom + seen.freedom,
        }
    }

    /// Compares predictions with what was seen.
    fn outlook(&self, beliefs: &[Belief], seen: &[Belief]) -> Outlook {
        let (mut miss, mut all, mut known) = (0.0, 0.0, 0usize);
        for (beliefs, seen) in beliefs.chunks(8).zip(seen.chunks(8)) {
            let lanes = |of: &dyn Fn(usize) -> f32| {
                f32x8::from(core::array::from_fn(|k| if k < seen.len() { of(k) } else { 0.0 }))
            };
            let usable = |k: usize| beliefs[k].usable().zip(seen[k].usable());
            known += beliefs.iter().filter(|belief| belief.usable().is_some()).count();
            let variance = lanes(&|k| usable(k).map_or(0.0, |(_, seen)| seen.variance));
            let expected = lanes(&|k| usable(k).map_or(0.0, |(belief, _)| belief.variance));
            let brighter = |(belief, seen): (Belief, Belief)| belief.light.max(seen.light);
            let light = lanes(&|k| usable(k).map_or(0.0, brighter)) * f32x8::splat(self.cd_per_unit);
            let acuity = f32x8::ONE / tvi(light);
            let sum = |x: f32x8| (x * acuity).to_array().iter().map(|x| f64::from(*x)).sum::<f64>();
            miss += sum((variance - expected).abs());
            all += sum(variance.fast_max(expected));
        }
        let part = |a: f64, b: f64| if b > 0.0 { (a / b) as f32 } else { 0.0 };
        let miss = if known == 0 { 1.0 } else { part(miss, all) };
        Outlook { miss, known: part(known as f64, beliefs.len() as f64) }
    }
}

#[cfg(test)]
mod tests;
