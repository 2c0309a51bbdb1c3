//! The search: samples, scores, refinement, and the conditions a result must meet.

use super::mapping::{Error, Pair};
use super::minimal::{Frame, outward, through};
use super::refine::{Noise, Refiner};
use super::score::{Block, Matrix8, Score, Test, fill};
use super::settings::{Fit, MAX_GAIN, Settings};
use crate::maths::matrix::{Matrix, determinant};
use crate::maths::sobol::hash;
use core::f64::consts::PI;

/// T of the score, in thresholds.
const REACH: f64 = 2.0;
/// Rounds of refinement of a best so far.
const LOCAL_ROUNDS: u32 = 4;
/// Rounds of refinement of the result.
const FINAL_ROUNDS: u32 = 20;
/// Smallest σ in normalised coordinates.
const MIN_SIGMA: f64 = 1e-6;
/// Triangles of samples are at least so large (normalised, twice): smaller ones magnify noise too much.
const MIN_SAMPLE_AREA: f64 = 1e-2;

/// Share of inliers that the first sequential tests are made for.
const FIRST_SHARE: f64 = 0.1;
/// Part of the good samples that survive the sequential test.
const KEPT: f64 = 0.99;
/// Distance of the pairs that are counted against chance, in σ: 96 % of the inliers.
const CHANCE_REACH: f64 = 2.5;
/// Leverage of a pair, by the number of inliers, from which on it decides alone: four times the mean, within bounds.
const DECIDES: f64 = 16.0;
/// Bounds of that leverage; 1 means that no other pair has a say.
const DECIDES_BOUNDS: [f64; 2] = [0.25, 0.999];

/// The best homography so far, in normalised coordinates.
#[derive(Clone, Copy)]
struct Best {
    matrix: Matrix,
    noise: Noise,
    score: Score,
}

/// A search over one set of pairs.
pub(super) struct Search<'a> {
    pairs: &'a [Pair],
    frames: [Frame; 2],
    settings: &'a Settings,
    refiner: Refiner<'a>,
    /// The threshold in normalised coordinates.
    threshold: f64,
}

impl<'a> Search<'a> {
    /// Normalises the pairs into the blocks.
    pub fn new(
        pairs: &'a [Pair],
        frames: [Frame; 2],
        settings: &'a Settings,
        blocks: &'a mut [Block],
    ) -> Self {
        fill(blocks, pairs, &frames);
        let threshold = settings.threshold * frames[1].scale;
        let (low, high) = bounds(pairs.iter().map(|pair| frames[1].inward(pair.to)));
        let area = ((high[0] - low[0]) * (high[1] - low[1])).max(MIN_SIGMA);
        let limits = [MIN_SIGMA, (REACH * threshold).max(MIN_SIGMA)];
        let refiner = Refiner { blocks, pairs: pairs.len() as f64, area, bounds: limits };
        Search { pairs, frames, settings, refiner, threshold }
    }

    /// Samples, refines and checks.
    pub fn run(&self) -> Result<Fit, Error> {
        let (best, iterations) = self.search();
        let best = best.ok_or(if self.pairs.len() > 4 { Error::NoConsensus } else { Error::Degenerate })?;
        let (matrix, noise) = self.refiner.refine(best.matrix, best.noise, FINAL_ROUNDS);
        let homography = outward(&matrix, &self.frames);
        let inliers = || self.pairs.iter().filter(|pair| homography.error(pair) <= self.settings.threshold);
        let count = inliers().count();
        let distance = (CHANCE_REACH * noise.sigma).clamp(0.5 * self.threshold, REACH * self.threshold);
        let near = |pair: &&Pair| homography.error(pair) * self.frames[1].scale <= distance;
        if !self.beats_chance(self.pairs.iter().filter(near).count(), distance) {
            return Err(Error::NoConsensus);
        }
        let area = corners(inliers().map(|pair| self.frames[0].inward(pair.from)));
        let keeps_orientation = determinant(&matrix) > 0.0;
        if !keeps_orientation || !self.determined(&matrix, &noise, count, area) {
            return Err(Error::Degenerate);
        }
        let sigma = noise.sigma / self.frames[1].scale;
        Ok(Fit { homography, inliers: count as u32, sigma, iterations })
    }

    /// Whether the inliers determine the homography at the corners of their area, also without the few that alone
    /// decide about some of its parameters: those could be outliers that happen to fit.
    fn determined(&self, matrix: &Matrix, noise: &Noise, inliers: usize, corners: [[f64; 2]; 4]) -> bool {
        let (equations, _) = self.refiner.expect(matrix, noise, |_, weights| weights);
        let Some(solver) = equations.solver() else { return false };
        let most = if inliers == 4 {
            f64::INFINITY
        } else {
            (DECIDES / inliers as f64).clamp(DECIDES_BOUNDS[0], DECIDES_BOUNDS[1])
        };
        let without = |block: &Block, weights: [f32; 8]| {
            core::array::from_fn(|lane| {
                let at = [block.double[0][lane], block.double[1][lane]];
                let weight = weights[lane];
                let decides = weight > 0.01 && f64::from(weight) * solver.variance(matrix, at) > most;
                if decides { 0.0 } else { weight }
            })
        };
        let (equations, _) = self.refiner.expect(matrix, noise, without);
        let in_front = |[x, y]: [f64; 2]| matrix[2][0] * x + matrix[2][1] * y + matrix[2][2] > 0.0;
        equations.solver().is_some_and(|solver| {
            let gain = |at| libm::sqrt(solver.variance(matrix, at));
            corners.into_iter().all(|at| !in_front(at) || gain(at) <= MAX_GAIN)
        })
    }

    /// The best homography and the number of samples.
    fn search(&self) -> (Option<Best>, u32) {
        let blocks = self.refiner.blocks;
        let mut best: Option<Best> = None;
        let mut test = Test::new(REACH * self.threshold, 0.0, FIRST_SHARE);
        let (mut needed, mut iteration) = (self.settings.max_iterations, 0);
        while iteration < needed {
            let sample = self.sample(iteration);
            iteration += 1;
            let [from, to] = sample;
            let Some(matrix) = through(&from, &to, MIN_SAMPLE_AREA) else { continue };
            let Some(score) = test.score(&Matrix8::new(&matrix), blocks) else { continue };
            let found = self.improve(matrix, score);
            test = Test::new(REACH * self.threshold, found.score.quality, self.share(&found));
            let samples = samples_needed(self.share(&found), self.settings.confidence);
            needed = samples.clamp(iteration, needed);
            best = Some(found);
        }
        (best, iteration)
    }

    /// Share of the pairs within reach.
    fn share(&self, best: &Best) -> f64 {
        f64::from(best.score.count) / self.refiner.pairs
    }

    /// Four different pairs by their places in the blocks, as points of both pictures.
    #[inline(always)]
    fn sample(&self, iteration: u32) -> [[[f64; 2]; 4]; 2] {
        let mut places = [0; 4];
        // A counter before the hash: it meets every number, so that no loop can be endless.
        let mut counter = hash(hash(self.settings.seed) ^ iteration);
        for i in 0..4 {
            loop {
                counter = counter.wrapping_add(0x9e37_79b9);
                places[i] = ((u64::from(hash(counter)) * self.pairs.len() as u64) >> 32) as usize;
                if !places[..i].contains(&places[i]) {
                    break;
                }
            }
        }
        let at = |place: usize, c: usize| self.refiner.blocks[place / 8].double[c][place % 8];
        [0, 2].map(|c| places.map(|place| [at(place, c), at(place, c + 1)]))
    }

    /// Refines a sample's homography as long as that raises its score.
    fn improve(&self, matrix: Matrix, score: Score) -> Best {
        let share = (f64::from(score.count) / self.refiner.pairs).clamp(0.02, 0.98);
        let noise = Noise { sigma: self.threshold, share };
        let (refined, noise_refined) = self.refiner.refine(matrix, noise, LOCAL_ROUNDS);
        let test = Test::new(REACH * self.threshold, score.quality, share);
        match test.score(&Matrix8::new(&refined), self.refiner.blocks) {
            Some(score) => Best { matrix: refined, noise: noise_refined, score },
            None => Best { matrix, noise, score },
        }
    }

    /// Whether so many inliers within a distance are unlikely for pairs that have nothing to do with each other.
    ///
    /// The expected number of homographies through four pairs with k inliers of n, each by chance p, is
    /// (n − 4)·C(n, k)·C(k, 4)·p^(k − 4); it must be below 1.
    fn beats_chance(&self, inliers: usize, distance: f64) -> bool {
        let (n, k) = (self.refiner.pairs, inliers as f64);
        if inliers == self.pairs.len() && inliers == 4 {
            return true;
        }
        let chance = (PI * distance * distance / self.refiner.area).min(1.0);
        let choose =
            |n: f64, k: f64| libm::lgamma(n + 1.0) - libm::lgamma(k + 1.0) - libm::lgamma(n - k + 1.0);
        let tests = libm::log(n - 4.0) + choose(n, k) + choose(k, 4.0);
        inliers > 4 && tests + (k - 4.0) * libm::log(chance) < 0.0
    }
}

/// Samples, at least 1, of which with probability `confidence` one is of inliers only and survives its test, where a part
/// `inliers` of the pairs are inliers: the least n with 1 − (1 − p)ⁿ above `confidence`, p the part of samples that do
/// (Fischler and Bolles 1981).
///
/// For tiny p 1 − p rounds to 1, whose logarithm would be 0: hence `log1p`.
fn samples_needed(inliers: f64, confidence: f64) -> u32 {
    let hit = KEPT * inliers * inliers * inliers * inliers;
    let samples = libm::log1p(-confidence) / libm::log1p(-hit);
    samples.min(f64::from(u32::MAX - 1)) as u32 + 1
}

/// Corners of the bounding box of some points, made at least half as wide as high and half as high as
/// wide: what is determined on a line is not on both sides of it.
fn corners(points: impl Iterator<Item = [f64; 2]>) -> [[f64; 2]; 4] {
    let (low, high) = bounds(points);
    let half = [0, 1].map(|i| 0.5 * (high[i] - low[i]));
    let half = [0, 1].map(|i| half[i].max(0.5 * half[1 - i]));
    let middle = [0, 1].map(|i| 0.5 * (low[i] + high[i]));
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        .map(|sign| [middle[0] + sign[0] * half[0], middle[1] + sign[1] * half[1]])
}

/// Lower and upper corner of the bounding box of some points.
fn bounds(points: impl Iterator<Item = [f64; 2]>) -> ([f64; 2], [f64; 2]) {
    points.fold(([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]), |(low, high), p| {
        ([low[0].min(p[0]), low[1].min(p[1])], [high[0].max(p[0]), high[1].max(p[1])])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether so many samples and no fewer reach the confidence, by the definition: powers of 1 − p by squaring, as
    /// numbers 1 − q, so that no tiny p is lost.
    fn is_least(samples: u32, hit: f64, confidence: f64) -> bool {
        let reached = |n: u32| {
            let both = |a: f64, b: f64| a + b - a * b;
            (0..32).rev().fold(0.0, |q, bit| {
                let twice = both(q, q);
                if n >> bit & 1 == 1 { both(twice, hit) } else { twice }
            })
        };
        // Rounding may move the border by one sample.
        reached(samples + 1) >= confidence && (samples < 3 || reached(samples - 2) <= confidence)
    }

    #[test]
    fn sample_counts_are_the_least_that_reach_the_confidence() {
        for inliers in [0.005, 0.01, 0.02, 0.1, 0.3, 0.5, 0.9, 0.999] {
            for confidence in [1e-9, 0.5, 0.995, 0.999_999] {
                let samples = samples_needed(inliers, confidence);
                let hit = KEPT * f64::powi(inliers, 4);
                let most = samples == u32::MAX;
                assert!(most || is_least(samples, hit, confidence), "{inliers} {confidence}: {samples}");
            }
        }
    }

    #[test]
    fn extreme_shares_give_usable_counts() {
        // Both tiny: 1 − (1 − p)ⁿ is np. 1 − p is 1 here, and by the plain logarithm the count was 1.
        for (inliers, confidence) in [(5e-5, 1e-12), (1e-5, 1e-16)] {
            let hit = KEPT * f64::powi(inliers, 4);
            assert_eq!(1.0 - hit, 1.0);
            let (samples, wanted) = (f64::from(samples_needed(inliers, confidence)), confidence / hit);
            assert!((samples - wanted).abs() <= 1.0 + 1e-9 * wanted, "{inliers}: {samples}, not {wanted}");
        }
        // Four pairs of 2^24, and none at all, need more samples than anybody draws.
        for inliers in [4.0 / f64::from(1 << 24), 1e-81, 0.0] {
            assert_eq!(samples_needed(inliers, 0.995), u32::MAX, "{inliers}");
        }
        assert_eq!(samples_needed(1.0, 0.995), 2);
        assert_eq!(samples_needed(0.3, 0.0), 1);
    }
}
