//! Scheduled samples: those whose place in their pixel's sequence is known before the frame begins.
//!
//! A sequence of Sobol points that continues from iteration to iteration is well stratified, but its next points depend
//! on where the last ones were, hence on what these have seen, and so does the number of samples that is drawn of them.
//! Whoever averages all samples, with whatever weights, is biased by that.
//!
//! So every iteration has `count` points of the sequence that are its own, the same ones in every pixel, and a pixel's first
//! samples of the iteration take these. All others take what is left of the sequence, in order. That a scheduled sample is
//! drawn at all has a known probability given the past; where its point is does not depend on the past. Weighted by one
//! over that probability it is unbiased, however the points hang together.
//!
//! Points: blocks of 32, eight points of each for the scheduled samples and 24 for the others, so that the two kinds
//! complete each other in most pixels, and each is well stratified by itself.

/// Points of a block, and the scheduled ones among them.
const BLOCK: u32 = 32;
const PART: u32 = 8;

/// The scheduled samples of an iteration, and which points samples take.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Scheduled {
    /// Scheduled samples of a pixel in earlier iterations, if it drew all of them.
    pub before: u32,
    /// Scheduled samples of a pixel in the iteration.
    pub count: u32,
    /// Points from the first on that are all scheduled; blocks follow.
    lead: u32,
}

impl Scheduled {
    /// The first iteration, of `spp` whole samples a pixel.
    pub fn first(spp: u32) -> Scheduled {
        let count = spp.max(1);
        Scheduled { before: 0, count, lead: count.next_multiple_of(PART) }
    }

    /// The same where nothing is adapted: there are hardly any other samples than scheduled ones.
    pub fn always(spp: u32) -> Scheduled {
        Scheduled { lead: 1 << 31, ..Scheduled::first(spp) }
    }

    /// The iteration that follows, in which every pixel expects at least `floor` samples.
    pub fn then(self, floor: f32) -> Scheduled {
        // With a floor below 1 a pixel may draw none; without any, nothing can be weighted.
        let count = if floor > 0.0 { (floor as u32).max(1) } else { 0 };
        Scheduled { before: self.before.saturating_add(self.count), count, lead: self.lead }
    }

    /// The point of scheduled sample `number` of the iteration.
    #[inline(always)]
    pub fn point(&self, number: u32) -> u32 {
        let number = self.before.wrapping_add(number);
        if number < self.lead {
            return number;
        }
        let k = number - self.lead;
        self.lead.wrapping_add((k / PART).wrapping_mul(BLOCK) + (BLOCK - PART) + k % PART)
    }

    /// The point of a pixel's other sample `number`, counted over all iterations.
    #[inline(always)]
    pub fn other_point(&self, number: u32) -> u32 {
        const OTHERS: u32 = BLOCK - PART;
        self.lead.wrapping_add((number / OTHERS).wrapping_mul(BLOCK) + number % OTHERS)
    }

    /// How much scheduled samples that were drawn count where `expected` samples were: one over the probability.
    #[inline(always)]
    pub fn weight(&self, expected: f32) -> f32 {
        1.0 / expected.min(1.0)
    }

    /// The part of the iteration in all scheduled samples so far.
    pub fn share(&self) -> f32 {
        let all = f64::from(self.before) + f64::from(self.count);
        if self.count > 0 { (f64::from(self.count) / all) as f32 } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use std::vec::Vec;

    #[test]
    fn points_are_those_of_a_sequence_each_once() {
        for spp in [0, 1, 2, 8, 9, 16] {
            let first = Scheduled::first(spp);
            // As many of each kind as fill whole blocks.
            let scheduled = (0..first.lead + 9 * PART).map(|k| first.point(k));
            let others = (0..9 * (BLOCK - PART)).map(|k| first.other_point(k));
            let mut all: Vec<u32> = scheduled.chain(others).collect();
            all.sort_unstable();
            assert!(all.into_iter().eq(0..first.lead + 9 * BLOCK), "first iteration of {spp}");
        }
    }

    #[test]
    fn iterations_follow_each_other() {
        let first = Scheduled::first(2);
        let second = first.then(0.5);
        let third = second.then(3.7).then(0.0);
        assert_eq!([first.point(0), first.point(1), second.point(0)], [0, 1, 2]);
        assert_eq!((third.before, third.count, third.share()), (6, 0, 0.0));
        assert_eq!((second.share(), second.weight(0.5), second.weight(7.0)), (1.0 / 3.0, 2.0, 1.0));
        assert_eq!(Scheduled::always(4).then(4.0).point(3), 7);
    }
}
