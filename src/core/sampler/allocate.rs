//! Deterministic mixture sampling: how many samples every pixel gets, exactly.
//!
//! From weights w_p the kernel α_p = ε/|P| + (1−ε)·w_p/Σw and from it the expected counts
//! n'_p = m + (N − m|P|)·α_p, with a floor of m samples a pixel. Then systematic sampling (one random offset
//! along the storage order; Madow, *On the theory of systematic sampling*, 1949) turns them into whole counts
//! n_p ∈ {⌊n'_p⌋, ⌈n'_p⌉} with E\[n_p\] = n'_p over the offset, and Σ n_p = N exactly.
//!
//! Expected counts are integers in units of 2^-32 sample (of N·2^-52 where that is more), and so is their cumulative
//! sum, whose last term is N by construction: nothing can drift. Where a run of 64 pixels ends in the
//! cumulative sum follows from the sum of all weights so far; inside a run each pixel's share is rounded by
//! itself, eight at a time, and the last one takes what remains: about 32 units more or less at worst.
//!
//! Limits: at most 2^28 pixels and 2^32 − 1 samples an allocation.

use crate::maths::eight::{read8, write8};
use wide::f32x8;

pub(crate) mod open;
pub(crate) mod words;

/// Most fractional bits of an expected count, and bits of the offset.
pub const FRACTION_BITS: u32 = 32;
/// Most pixels of an allocation.
pub const MAX_PIXELS: usize = 1 << 28;
/// Most samples of an allocation.
pub const MAX_SAMPLES: u64 = u32::MAX as u64;

/// Pixels whose shares are rounded together.
const RUN: usize = 64;
/// Bits of a floating-point number that hold a number of units after it was added to [`ROUND`].
const MANTISSA_BITS: u32 = f64::MANTISSA_DIGITS - 1;
const MANTISSA: u64 = (1 << MANTISSA_BITS) - 1;
const ROUND: f64 = (MANTISSA + 1) as f64;

/// What can be wrong with an allocation.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// The slices are empty, of different lengths, or longer than [`MAX_PIXELS`].
    Pixels,
    /// More samples than [`MAX_SAMPLES`].
    Samples,
    /// The floor is negative or not a number.
    Floor,
    /// The uniform part is not in 0 … 1.
    Epsilon,
}

impl core::fmt::Display for Error {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Error::Pixels => "allocation needs weights and counts of equal length, 1 to 2^28 pixels",
            Error::Samples => {
                "more than 2^32 - 1 samples in one allocation: divide them over more iterations"
            }
            Error::Floor => "the floor of samples a pixel must be 0 or more",
            Error::Epsilon => "epsilon must be between 0 and 1",
        })
    }
}

impl core::error::Error for Error {}

/// How samples are divided over pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mixture {
    /// N, samples to give out.
    pub samples: u64,
    /// m, expected samples every pixel gets at least. Where N < m|P|, every pixel expects N/|P|.
    pub floor: f32,
    /// ε, the part of the rest that is given out uniformly; 1 ignores the weights.
    pub epsilon: f32,
}

/// Divides samples over pixels: weights in `target` become expected counts, `planned` the whole counts.
///
/// A weight that is negative or not finite is unknown: it counts as the mean of the known ones. If no weight is
/// known and positive, or their sum is not finite, the division is uniform. `offset` chooses among the
/// allocations with these expectations; it should be uniformly random.
///
/// # Errors
/// If the lengths differ or a limit of this module is exceeded; then nothing has been written.
pub fn allocate(target: &mut [f32], planned: &mut [u32], mix: Mixture, offset: u32) -> Result<(), Error> {
    if target.len() != planned.len() {
        return Err(Error::Pixels);
    }
    check(target.len(), &mix)?;
    let mut known = Known::default();
    known.add(target);
    Shares::new(&mix, target.len(), &known, offset).divide(Before::default(), target, planned);
    Ok(())
}

/// The conditions under which an allocation over so many pixels cannot overflow.
pub(crate) fn check(pixels: usize, mix: &Mixture) -> Result<(), Error> {
    if !(1..=MAX_PIXELS).contains(&pixels) {
        return Err(Error::Pixels);
    }
    if mix.samples > MAX_SAMPLES {
        return Err(Error::Samples);
    }
    if mix.floor.is_nan() || mix.floor < 0.0 {
        return Err(Error::Floor);
    }
    if !(0.0..=1.0).contains(&mix.epsilon) {
        return Err(Error::Epsilon);
    }
    Ok(())
}

/// Sum and number of the known weights.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Known {
    sums: [f64; 8],
    number: u32,
}

impl Known {
    /// Adds weights. Eight partial sums, so that it runs in parallel lanes.
    #[inline(always)]
    pub fn add(&mut self, weights: &[f32]) {
        let (chunks, rest) = weights.as_chunks::<8>();
        for chunk in chunks {
            self.add8(f32x8::from(*chunk));
        }
        if !rest.is_empty() {
            let mut last = [f32::NAN; 8];
            last[..rest.len()].copy_from_slice(rest);
            self.add8(f32x8::from(last));
        }
    }

    #[inline(always)]
    fn add8(&mut self, weights: f32x8) {
        let known = is_known(weights);
        let lanes = (known & weights).to_array();
        (0..8).for_each(|lane| self.sums[lane] += f64::from(lanes[lane]));
        self.number += known.to_bitmask().count_ones();
    }

    fn sum(&self) -> f64 {
        self.sums.iter().sum()
    }

    fn number(&self) -> f64 {
        f64::from(self.number)
    }
}

/// A mask of the lanes that are neither negative nor infinite nor not a number.
#[inline(always)]
fn is_known(weights: f32x8) -> f32x8 {
    weights.simd_ge(f32x8::ZERO) & weights.simd_le(f32x8::splat(f32::MAX))
}

/// The pixels before a part of them: how many there are, and the sum of their weights in the order of an allocation.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Before {
    pixels: f64,
    weights: f64,
}

impl Before {
    /// With the pixels of some whole runs, in whose words [`Shares::sum_runs`] has kept the sums.
    pub fn and_runs(self, kept: &[u32]) -> Before {
        kept.chunks(RUN).fold(self, |Before { pixels, weights }, run| Before {
            pixels: pixels + run.len() as f64,
            weights: weights + f64::from_bits(words::kept(run)),
        })
    }
}

/// What a pixel is given: `uniform + factor · weight`, in units of 2^-`bits` sample.
///
/// Where a part of the pixels begins in the cumulative sum follows from what is [`Before`] it, so that parts can be divided in
/// any order: these sums never fall, hence are what the part before would have ended with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shares {
    /// Number of pixels that are given something.
    pixels: f64,
    uniform: f64,
    factor: f64,
    /// The weight of a pixel without a known one.
    unknown: f32,
    bits: u32,
    /// A unit in samples.
    samples: f32,
    /// N in units.
    total: u64,
    /// Chooses among the allocations with these expectations.
    offset: u32,
}

impl Shares {
    pub fn new(mix: &Mixture, pixels: usize, known: &Known, offset: u32) -> Shares {
        // All samples in units stay below 2^52: the integers that floating point can hold.
        let bits = (MANTISSA_BITS - (u64::BITS - mix.samples.leading_zeros())).min(FRACTION_BITS);
        let (pixels, total) = (pixels as f64, mix.samples << bits);
        let part = uniform_part(mix, pixels) * (1u64 << bits) as f64;
        let unknown = (known.sum() / known.number()) as f32;
        let all = known.sum() + f64::from(unknown) * (pixels - known.number());
        let steers = all > 0.0 && unknown.is_finite() && part < total as f64;
        let (part, factor) = if steers { (part, (total as f64 - part) / all) } else { (total as f64, 0.0) };
        let unknown = if steers { unknown } else { 0.0 };
        let samples = 1.0 / (1u64 << bits) as f32;
        Shares { pixels, uniform: part / pixels, factor, unknown, bits, samples, total, offset }
    }

    /// Turns the weights of some runs of pixels, of all or of those after some [`Before`], into expected and whole counts.
    pub fn divide(&self, mut before: Before, target: &mut [f32], planned: &mut [u32]) {
        let mut steps = self.steps(before);
        for (target, planned) in target.chunks_mut(RUN).zip(planned.chunks_mut(RUN)) {
            let mut units = [0; RUN];
            before.weights += match target.first_chunk_mut::<RUN>() {
                Some(whole) => self.units(whole, &mut units),
                None => self.units(target, &mut units),
            };
            before.pixels += target.len() as f64;
            let rest = steps.run(&units[..target.len()], planned, self.end(before));
            target[target.len() - 1] = rest as f32 * self.samples;
        }
    }

    /// Keeps the sum of each run's weights in its first two words of `planned`, for [`Before::and_runs`]: in the order of
    /// [`divide`](Self::divide), which ends a last run that is shorter without it.
    pub fn sum_runs(&self, target: &[f32], planned: &mut [u32]) {
        for (target, planned) in target.chunks(RUN).zip(planned.chunks_mut(RUN)) {
            let mut sums = [0.0; 8];
            for weights in target.chunks(8) {
                let weights = self.weights(read8(weights)).to_array();
                (0..8).for_each(|lane| sums[lane] += f64::from(weights[lane]));
            }
            words::keep(planned, sums.iter().sum::<f64>().to_bits());
        }
    }

    /// The cumulative sum at the beginning of what comes after `before`.
    fn steps(&self, before: Before) -> Steps {
        Steps::new(self.bits, self.offset, self.cumulative(before))
    }

    /// A pixel's weight, or that of a pixel without a known one.
    fn weight(&self, weight: f32) -> f32 {
        if (0.0..=f32::MAX).contains(&weight) { weight } else { self.unknown }
    }

    /// [`weight`](Self::weight) of eight pixels.
    #[inline(always)]
    fn weights(&self, weights: f32x8) -> f32x8 {
        is_known(weights).select(weights, f32x8::splat(self.unknown))
    }

    /// Turns up to a run of weights into expected counts, writes these in units too, and returns the sum of the weights.
    #[inline(always)]
    fn units(&self, target: &mut [f32], units: &mut [u64; RUN]) -> f64 {
        let mut sums = [0.0; 8];
        let (units, _) = units.as_chunks_mut::<8>();
        for (target, units) in target.chunks_mut(8).zip(units) {
            let (weights, mut expected) = (self.weights(read8(target)).to_array(), [0.0; 8]);
            for lane in 0..8 {
                let weight = f64::from(weights[lane]);
                sums[lane] += weight;
                // Added to 2^52, a number is rounded to an integer that can be read off its bits.
                let rounded = ROUND + (self.uniform + self.factor * weight);
                units[lane] = rounded.to_bits() & MANTISSA;
                expected[lane] = (rounded - ROUND) as f32;
            }
            write8(target, f32x8::from(expected) * f32x8::splat(self.samples));
        }
        sums.iter().sum()
    }

    /// Units of the first pixels; at most all.
    fn cumulative(&self, first: Before) -> u64 {
        ((self.uniform * first.pixels + self.factor * first.weights) as u64).min(self.total)
    }

    /// Where the last of the first pixels ends: where all do, if it is the last of all.
    #[inline(always)]
    fn end(&self, first: Before) -> u64 {
        if first.pixels == self.pixels { self.total } else { self.cumulative(first) }
    }
}

/// Samples given out uniformly, floor included; at most all of them.
fn uniform_part(mix: &Mixture, pixels: f64) -> f64 {
    let samples = mix.samples as f64;
    let floor = (f64::from(mix.floor) * pixels).min(samples);
    floor + f64::from(mix.epsilon) * (samples - floor)
}

/// The cumulative sum of the expected counts, in units, and how many whole samples lie below it.
struct Steps {
    cumulative: u64,
    whole: u64,
    offset: u64,
    bits: u32,
}

impl Steps {
    fn new(bits: u32, offset: u32, cumulative: u64) -> Steps {
        let offset = u64::from(offset >> (FRACTION_BITS - bits));
        Steps { cumulative, whole: (cumulative + offset) >> bits, offset, bits }
    }

    /// Writes the whole counts of a run of pixels that expect `units`, the last of which takes what remains up to
    /// `end`. Returns how much that is.
    #[inline(always)]
    fn run(&mut self, units: &[u64], planned: &mut [u32], end: u64) -> u64 {
        let end = end.max(self.cumulative);
        let (offset, mut sum, mut whole) = (self.offset, self.cumulative, self.whole);
        let last = units.len() - 1;
        for (units, planned) in units[..last].iter().zip(&mut planned[..last]) {
            sum += units;
            let next = (sum.min(end) + offset) >> self.bits;
            *planned = (next - whole) as u32;
            whole = next;
        }
        self.whole = (end + offset) >> self.bits;
        planned[last] = (self.whole - whole) as u32;
        self.cumulative = end;
        end - sum.min(end)
    }
}

#[cfg(test)]
mod tests;
