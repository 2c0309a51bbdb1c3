//! Deterministic mixture sampling: how many samples every pixel gets, exactly.
//!
//! From weights w_p the kernel α_p = ε/|P| + (1−ε)·w_p/Σw and from it the expected counts
//! n'_p = m + (N − m|P|)·α_p, with a floor of m samples a pixel. Then systematic sampling (one random offset
//! along the storage order; Madow, *On the theory of systematic sampling*, 1949) turns them into whole counts
//! n_p ∈ {⌊n'_p⌋, ⌈n'_p⌉} with E\[n_p\] = n'_p over the offset, and Σ n_p = N exactly.
//!
//! All sums are integers with [`FRACTION_BITS`] fractional bits, so that nothing can drift: expected counts are
//! differences of a cumulative sum whose last term is N by construction. Weights become integers of
//! 2^-62 of their sum: with 2^28 pixels an average weight still has 2^34 units, far more than the 2^-24 samples
//! to which an expected count is resolved, and the sum fits into 64 bits.
//!
//! Limits: at most 2^28 pixels and 2^32 − 1 samples an allocation.

/// Fractional bits of an expected count.
pub const FRACTION_BITS: u32 = 24;
/// Most pixels of an allocation.
pub const MAX_PIXELS: usize = 1 << 28;
/// Most samples of an allocation.
pub const MAX_SAMPLES: u64 = u32::MAX as u64;

const ONE: u64 = 1 << FRACTION_BITS;

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
/// allocations with these expectations; its lower 24 bits count, and should be uniformly random.
///
/// # Errors
/// If the lengths differ or a limit of this module is exceeded; then nothing has been written.
pub fn allocate(target: &mut [f32], planned: &mut [u32], mix: Mixture, offset: u32) -> Result<(), Error> {
    check(target, planned, &mix)?;
    let mut uniform = Uniform::new(uniform_part(&mix, target.len()), target.len());
    let weights = Weights::new(target, (mix.samples << FRACTION_BITS) - uniform.part);
    if weights.is_none() {
        uniform = Uniform::new(mix.samples << FRACTION_BITS, target.len());
    }
    let mut adaptive = 0;
    let mut last = Step { cumulative: 0, whole: 0, offset: u64::from(offset) % ONE };
    let end = target.len() - 1;
    for (i, (target, planned)) in target.iter_mut().zip(planned).enumerate() {
        let mut cumulative = uniform.next();
        if let Some(weights) = &weights {
            adaptive += weights.integer(*target);
            cumulative += weights.share(adaptive);
        }
        if i == end {
            cumulative = mix.samples << FRACTION_BITS;
        }
        (*target, *planned) = last.advance(cumulative);
    }
    Ok(())
}

/// The conditions under which [`allocate`] cannot overflow.
fn check(target: &[f32], planned: &[u32], mix: &Mixture) -> Result<(), Error> {
    if target.len() != planned.len() || !(1..=MAX_PIXELS).contains(&target.len()) {
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

/// Samples given out uniformly, floor included, in fixed point; at most all of them.
fn uniform_part(mix: &Mixture, pixels: usize) -> u64 {
    let samples = mix.samples as f64;
    let floor = (f64::from(mix.floor) * pixels as f64).min(samples);
    let part = floor + f64::from(mix.epsilon) * (samples - floor);
    ((part * ONE as f64) as u64).min(mix.samples << FRACTION_BITS)
}

/// The cumulative sum of equal parts: ⌊(p + 1)·part/pixels⌋ for p = 0, 1, … without a division each.
struct Uniform {
    part: u64,
    pixels: u64,
    sum: u64,
    remainder: u64,
}

impl Uniform {
    fn new(part: u64, pixels: usize) -> Self {
        Uniform { part, pixels: pixels as u64, sum: 0, remainder: 0 }
    }

    #[inline(always)]
    fn next(&mut self) -> u64 {
        // The quotient is loop-invariant: the compiler hoists it.
        self.sum += self.part / self.pixels;
        self.remainder += self.part % self.pixels;
        let carry = u64::from(self.remainder >= self.pixels);
        self.remainder -= carry * self.pixels;
        self.sum += carry;
        self.sum
    }
}

/// Weights as integers, and the factor from their cumulative sum to samples in fixed point.
struct Weights {
    scale: f64,
    unknown: f64,
    factor: u64,
}

impl Weights {
    /// Nothing if `part`, the samples to be given out by weight, is 0 or the weights cannot steer them.
    fn new(weights: &[f32], part: u64) -> Option<Weights> {
        let (sum, known) = sum(weights);
        if part == 0 || !(sum > 0.0 && sum < f64::INFINITY) {
            return None;
        }
        let unknown = sum / known as f64;
        let all = sum + unknown * (weights.len() - known) as f64;
        let mut this = Weights { scale: (1u64 << 62) as f64 / all, unknown, factor: 0 };
        let total: u64 = weights.iter().map(|w| this.integer(*w)).sum();
        // part < 2^56 and total ≈ 2^62, so the quotient fits; rounding down keeps every share ≤ part.
        this.factor = ((u128::from(part) << 64) / u128::from(total.max(1))) as u64;
        Some(this)
    }

    #[inline(always)]
    fn integer(&self, weight: f32) -> u64 {
        let weight = if is_known(weight) { f64::from(weight) } else { self.unknown };
        (weight * self.scale) as i64 as u64
    }

    #[inline(always)]
    fn share(&self, cumulative: u64) -> u64 {
        ((u128::from(cumulative) * u128::from(self.factor)) >> 64) as u64
    }
}

#[inline(always)]
fn is_known(weight: f32) -> bool {
    (0.0..=f32::MAX).contains(&weight)
}

/// Sum and number of the known weights. Eight partial sums, so that it runs in parallel lanes.
fn sum(weights: &[f32]) -> (f64, usize) {
    let (mut sums, mut known) = ([0.0; 8], [0u32; 8]);
    let mut add = |lane: usize, weight: f32| {
        sums[lane] += if is_known(weight) { f64::from(weight) } else { 0.0 };
        known[lane] += u32::from(is_known(weight));
    };
    let (chunks, rest) = weights.as_chunks::<8>();
    chunks.iter().for_each(|chunk| (0..8).for_each(|lane| add(lane, chunk[lane])));
    rest.iter().enumerate().for_each(|(lane, weight)| add(lane, *weight));
    (sums.iter().sum(), known.iter().map(|k| *k as usize).sum())
}

/// The last point of the cumulative sum, and how many whole samples lie below it.
struct Step {
    cumulative: u64,
    whole: u64,
    offset: u64,
}

impl Step {
    /// Expected and whole count between the last point and `cumulative`.
    #[inline(always)]
    fn advance(&mut self, cumulative: u64) -> (f32, u32) {
        let whole = (cumulative + self.offset) >> FRACTION_BITS;
        let expected = (cumulative - self.cumulative) as i64 as f32 * (1.0 / ONE as f32);
        let count = (whole - self.whole) as u32;
        (self.cumulative, self.whole) = (cumulative, whole);
        (expected, count)
    }
}

#[cfg(test)]
mod tests;
