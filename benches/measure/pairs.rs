//! Point pairs under a known homography, with noise and outliers: the data that robust estimators are judged by.

use pmcip_core::predict::homography::{Homography, Pair};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

/// Side of the square pictures, in pixels.
pub const SIDE: f64 = 512.0;
/// Pairs of a problem.
pub const PAIRS: usize = 200;
/// Corners of the pictures.
pub const CORNERS: [[f64; 2]; 4] = [[0.0, 0.0], [SIDE, 0.0], [SIDE, SIDE], [0.0, SIDE]];

/// One problem.
pub struct Problem {
    /// The homography.
    pub truth: Homography,
    /// Its points, with noise and outliers.
    pub pairs: Vec<Pair>,
}

/// Problems of a fixed seed, one after the other.
pub struct Problems(Xoshiro256PlusPlus);

impl Problems {
    /// The same problems for the same seed.
    pub fn new(seed: u64) -> Self {
        Problems(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn point(&mut self, low: f64, high: f64) -> [f64; 2] {
        [self.uniform(low, high), self.uniform(low, high)]
    }

    /// Two normal deviates (Box and Muller).
    fn normal(&mut self) -> [f64; 2] {
        let radius = (-2.0 * (1.0 - self.uniform(0.0, 1.0)).ln()).sqrt();
        let angle = self.uniform(0.0, std::f64::consts::TAU);
        [radius * angle.cos(), radius * angle.sin()]
    }

    /// Every corner of the picture moved by up to a quarter of its side, each way.
    fn homography(&mut self) -> Homography {
        loop {
            let corners = CORNERS.map(|from| {
                let shift = self.point(-0.25 * SIDE, 0.25 * SIDE);
                Pair { from, to: [from[0] + shift[0], from[1] + shift[1]] }
            });
            if let Ok(homography) = Homography::through(&corners) {
                return homography;
            }
        }
    }
}

impl Iterator for Problems {
    type Item = Problem;

    /// Noise of 0.5 to 2 pixels each way on the moved points, 20 to 80 % of them replaced by random ones.
    fn next(&mut self) -> Option<Problem> {
        let truth = self.homography();
        let (sigma, outliers) = (self.uniform(0.5, 2.0), self.uniform(0.2, 0.8));
        let good = PAIRS - (outliers * PAIRS as f64).round() as usize;
        let mut pairs: Vec<Pair> = (0..PAIRS)
            .map(|i| {
                let (from, noise, anywhere) = (self.point(0.0, SIDE), self.normal(), self.point(0.0, SIDE));
                let to = truth.apply(from).expect("the picture lies in front of the horizon");
                let noisy = [to[0] + sigma * noise[0], to[1] + sigma * noise[1]];
                Pair { from, to: if i < good { noisy } else { anywhere } }
            })
            .collect();
        for i in (1..PAIRS).rev() {
            pairs.swap(i, self.uniform(0.0, (i + 1) as f64) as usize);
        }
        Some(Problem { truth, pairs })
    }
}

/// Mean distance between where `found` and the truth put the picture's corners; the side if nothing was found.
pub fn corner_error(truth: &Homography, found: Option<&Homography>) -> f64 {
    let distance = |corner: [f64; 2]| {
        let (a, b) = (truth.apply(corner)?, found?.apply(corner)?);
        Some((a[0] - b[0]).hypot(a[1] - b[1]))
    };
    CORNERS.iter().map(|&corner| distance(corner).unwrap_or(SIDE).min(SIDE)).sum::<f64>() / 4.0
}

/// Area under the share of problems solved within e pixels, e from 0 to 5, over 5.
pub fn area(errors: &[f64]) -> f64 {
    errors.iter().map(|e| (1.0 - e / 5.0).max(0.0)).sum::<f64>() / errors.len() as f64
}

/// Mean of the corner errors.
pub fn mean(errors: &[f64]) -> f64 {
    errors.iter().sum::<f64>() / errors.len() as f64
}
