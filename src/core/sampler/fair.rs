//! Fair samples: those that unbiased estimators are made of.
//!
//! A sequence of Sobol points that continues from iteration to iteration is well stratified, but its next points depend on
//! where the last ones were, hence on what these have seen, and so does the number of samples that is drawn of them. Whoever
//! averages all samples, or weighs them by expected numbers, is biased by that.
//!
//! The first samples of a pixel are not touched by it, if their number is fixed before the frame and every pixel gets as
//! many: they are the samples of a uniform renderer. Adaptive sampling only decides when they are drawn. Most pixels have
//! them soon; the others are promised a part of every iteration, and get what is missing, whatever their weight.
//!
//! Pixel i (in storage order) is promised ⌊T + φ_i⌋ samples after T a pixel, φ_i = i/Φ mod 1 (Φ the golden ratio): what is
//! due is spread evenly over the picture and over time.

/// Fractional bits of a number of samples a pixel.
const FRACTION_BITS: u32 = 32;
/// 2^32/Φ.
const GOLDEN: u32 = 0x9e37_79b9;

/// What is promised to every pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Fair {
    /// Fair samples of a pixel.
    count: u32,
    /// Promised so far, [`FRACTION_BITS`] of them fractional.
    promised: u64,
}

impl Fair {
    /// After a first iteration that gave every pixel `given` samples: `count` in all, at least these and one.
    pub fn new(count: u32, given: u32) -> Fair {
        Fair { count: count.max(given).max(1), promised: u64::from(given) << FRACTION_BITS }
    }

    /// Both numbers, and back: fair samples of a pixel and how many are promised.
    pub fn parts(self) -> (u32, u64) {
        (self.count, self.promised)
    }

    /// See [`parts`](Self::parts).
    pub fn of(count: u32, promised: u64) -> Fair {
        Fair { count, promised }
    }

    /// Fair samples of a pixel that has that many.
    pub fn count(self) -> u32 {
        self.count
    }

    /// That of two films together.
    pub fn and(self, other: Fair) -> Fair {
        let count = self.count.saturating_add(other.count);
        Fair {
            count,
            promised: self.promised.saturating_add(other.promised).min(u64::from(count) << FRACTION_BITS),
        }
    }

    /// Promises `more` samples a pixel.
    pub fn promise(self, more: f64) -> Fair {
        // Rounded up, so that parts of a whole number make it up.
        let more = libm::ceil(more * (1u64 << FRACTION_BITS) as f64) as u64;
        let most = u64::from(self.count) << FRACTION_BITS;
        Fair { promised: self.promised.saturating_add(more).min(most), ..self }
    }

    /// How many samples pixel `i` lacks that has `drawn`.
    #[inline(always)]
    pub fn missing(self, i: usize, drawn: u32) -> u32 {
        // ⌊promised + phase⌋ by halves of 32 bits, which fit into vectors as they are.
        let phase = (i as u32).wrapping_mul(GOLDEN);
        let (whole, fraction) = ((self.promised >> FRACTION_BITS) as u32, self.promised as u32);
        let due = whole.saturating_add(u32::from(fraction.overflowing_add(phase).1));
        due.min(self.count).saturating_sub(drawn)
    }

    /// How many samples pixels from the `first` on lack together that have `drawn`.
    pub fn total(self, first: usize, drawn: &[u32]) -> u64 {
        drawn.iter().enumerate().map(|(k, drawn)| u64::from(self.missing(first + k, *drawn))).sum()
    }

    /// How many of `planned` samples are fair, after `drawn` others.
    #[inline(always)]
    pub fn among(self, planned: u32, drawn: u32) -> u32 {
        self.count.saturating_sub(drawn).min(planned)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use std::vec;

    #[test]
    fn promises_are_kept_evenly_and_end() {
        for pixels in [1, 7, 256, 5000] {
            let mut drawn = vec![2; pixels];
            let mut fair = Fair::new(5, 2);
            for (k, more) in [0.5, 0.25, 0.0, 1.5, 3.0].into_iter().enumerate() {
                fair = fair.promise(more);
                let before = drawn.clone();
                drawn.iter_mut().enumerate().for_each(|(i, n)| *n += fair.missing(i, *n));
                let given: u32 = drawn.iter().sum::<u32>() - before.iter().sum::<u32>();
                assert_eq!(u64::from(given), fair.total(0, &before));
                // Golden ratio points: discrepancy below 4 samples at this many pixels.
                let expected = more.min(5.0 - 2.0 - [0.0, 0.5, 0.75, 0.75, 2.25][k]) * pixels as f64;
                assert!((f64::from(given) - expected).abs() < 4.0, "{given}, not {expected}");
                assert!(drawn.iter().max().unwrap() - drawn.iter().min().unwrap() <= 1);
            }
            assert!(drawn.iter().all(|n| *n == 5));
        }
    }

    #[test]
    fn halves_make_the_sum() {
        for promised in [0, 1, u64::MAX, u64::MAX - 5, 7 << 32, (7 << 32) - 1, (3 << 32) + (1 << 31)] {
            for (count, i, drawn) in [(9, 0, 0), (9, 1, 2), (u32::MAX, 5, 3), (2, 77, 0), (9, 123_456, 4)] {
                let phase = u64::from((i as u32).wrapping_mul(GOLDEN));
                let due = (promised.saturating_add(phase) >> 32u32).min(u64::from(count)) as u32;
                assert_eq!(Fair::of(count, promised).missing(i, drawn), due.saturating_sub(drawn));
            }
        }
    }

    #[test]
    fn the_first_samples_are_the_fair_ones() {
        let fair = Fair::new(5, 2);
        assert_eq!([fair.among(2, 0), fair.among(9, 2), fair.among(2, 4), fair.among(3, 7)], [2, 3, 1, 0]);
        assert_eq!(Fair::new(0, 4).among(8, 0), 4);
        assert_eq!(Fair::new(u32::MAX, 4).promise(1e18).missing(3, 9), u32::MAX - 9);
    }
}
