//! Refinement: expectation and maximisation of a mixture of Gaussian inliers and uniform outliers.

use super::normal::{Equations, Sums};
use super::score::{Block, Matrix8};
use crate::maths::functions::exp2;
use crate::maths::matrix::Matrix;
use wide::f32x8;

/// The model of the residuals, in normalised coordinates of the second picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noise {
    /// Standard deviation of an inlier's coordinate.
    pub sigma: f64,
    /// Share of inliers.
    pub share: f64,
}

/// What stays the same while one set of pairs is refined.
#[derive(Clone, Copy, Debug)]
pub(super) struct Refiner<'a> {
    /// The pairs.
    pub blocks: &'a [Block],
    /// How many they are.
    pub pairs: f64,
    /// Area over which outliers are spread.
    pub area: f64,
    /// Smallest and largest σ.
    pub bounds: [f64; 2],
}

impl Refiner<'_> {
    /// Alternates up to `rounds` times; stops when a step no longer moves anything.
    pub fn refine(&self, matrix: Matrix, noise: Noise, rounds: u32) -> (Matrix, Noise) {
        let (mut matrix, mut noise) = (matrix, noise);
        for _ in 0..rounds {
            let (equations, next) = self.expect(&matrix, &noise, |_, weights| weights);
            let Some(moved) = equations.step(&matrix) else { break };
            let entries = || moved.as_flattened().iter().zip(matrix.as_flattened());
            let change = entries().map(|(new, old)| (new - old).abs()).fold(0.0, f64::max);
            let settled = change < 1e-3 * next.sigma && next.sigma > 0.99 * noise.sigma;
            (matrix, noise) = (moved, next);
            if settled || change.is_nan() {
                break;
            }
        }
        (matrix, noise)
    }

    /// Normal equations with every pair weighted by the probability that it is an inlier, and the noise that
    /// these probabilities say. `revise` may change the weights of a block.
    pub fn expect(
        &self,
        matrix: &Matrix,
        noise: &Noise,
        revise: impl Fn(&Block, [f32; 8]) -> [f32; 8],
    ) -> (Equations, Noise) {
        let matrix8 = Matrix8::new(matrix);
        let two_variances = 2.0 * noise.sigma * noise.sigma;
        let odds = (1.0 - noise.share) / noise.share * core::f64::consts::PI * two_variances / self.area;
        let rate = f32x8::splat((core::f64::consts::LOG2_E / two_variances) as f32);
        let odds = f32x8::splat(odds as f32);
        let mut sums = Sums::new();
        for block in self.blocks {
            let (square, front) = matrix8.residuals(block);
            let weights = (f32x8::ONE / (f32x8::ONE + odds * exp2(square * rate))) & front;
            sums.add(matrix, block, revise(block, weights.to_array()));
        }
        let (equations, weight, squares) = sums.finish();
        // Eight of the residuals' degrees of freedom are the homography's.
        let sigma = libm::sqrt(squares / (2.0 * weight - 8.0).max(weight));
        let share = (weight / self.pairs).clamp(0.01, 0.98);
        (equations, Noise { sigma: sigma.clamp(self.bounds[0], self.bounds[1]), share })
    }
}
