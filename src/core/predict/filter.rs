//! Merges what was predicted with what was seen: a scalar Kalman filter for every pixel.

use super::belief::{Belief, Error};
use crate::maths::tvi::tvi;
use wide::f32x8;

/// Side of the blocks over which the filter judges a prediction.
const BLOCK: usize = 16;

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
            // A variance near the end of all numbers over a threshold below 1 is beyond it.
            let sum =
                |x: f32x8| (x * acuity).to_array().iter().map(|x| f64::from(x.min(f32::MAX))).sum::<f64>();
            miss += sum((variance - expected).abs());
            all += sum(variance.fast_max(expected));
        }
        let part = |a: f64, b: f64| if b > 0.0 { (a / b) as f32 } else { 0.0 };
        let miss = if known == 0 { 1.0 } else { part(miss, all) };
        Outlook { miss, known: part(known as f64, beliefs.len() as f64) }
    }
}
