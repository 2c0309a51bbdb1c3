//! Scores of homographies, eight pairs at a time.

use super::mapping::Pair;
use super::minimal::Frame;
use crate::maths::matrix::Matrix;
use wide::f32x8;

/// Least w of a pair to count, where it is 1 at the centroid of all: nearer to the horizon nothing is certain.
pub(super) const MIN_W: f32 = 0.01;
/// Where lanes without a pair lie in the second picture: nowhere near anything.
const NOWHERE: f64 = 1e4;

/// Eight pairs in normalised coordinates: scratch of [`estimate`](super::estimate).
#[derive(Clone, Copy, Debug, Default)]
pub struct Block {
    /// x, y, x', y'.
    pub(super) double: [[f64; 8]; 4],
    /// The same in single precision.
    pub(super) single: [f32x8; 4],
}

impl Block {
    /// Up to eight pairs.
    fn new(pairs: impl Iterator<Item = Pair>, frames: &[Frame; 2]) -> Block {
        let mut double = [[0.0; 8], [0.0; 8], [NOWHERE; 8], [NOWHERE; 8]];
        for (lane, pair) in pairs.enumerate() {
            let ([x, y], [u, v]) = (frames[0].inward(pair.from), frames[1].inward(pair.to));
            [x, y, u, v].iter().zip(&mut double).for_each(|(value, lanes)| lanes[lane] = *value);
        }
        Block { double, single: double.map(|lanes| f32x8::from(lanes.map(|value| value as f32))) }
    }
}

/// Fills the blocks with pairs in an order that a sequential test can take for random: steps of about the golden
/// section through all of them.
pub(super) fn fill(blocks: &mut [Block], pairs: &[Pair], frames: &[Frame; 2]) {
    let step = stride(pairs.len());
    let mut order = (0..pairs.len()).scan(0, |at, _| {
        let index = *at;
        *at = (*at + step) % pairs.len();
        Some(pairs[index])
    });
    for block in blocks {
        *block = Block::new(order.by_ref().take(8), frames);
    }
}

/// A number near 0.618·n without a common divisor with n.
fn stride(n: usize) -> usize {
    let divisor = |mut a: usize, mut b: usize| {
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    (n * 618 / 1000 + 1..=n).find(|step| divisor(n, *step) == 1).unwrap_or(1)
}

/// A homography, ready for eight pairs.
pub(super) struct Matrix8([f32x8; 8]);

impl Matrix8 {
    /// Of a matrix with 1 in its last place.
    #[inline(always)]
    pub fn new(m: &Matrix) -> Self {
        let [[a, b, c], [d, e, f], [g, h, _]] = *m;
        Matrix8([a, b, c, d, e, f, g, h].map(|entry| f32x8::splat(entry as f32)))
    }

    /// Squared distances in the second picture, and the mask of pairs in front of the horizon.
    #[inline(always)]
    pub fn residuals(&self, block: &Block) -> (f32x8, f32x8) {
        let ([a, b, c, d, e, f, g, h], [x, y, u, v]) = (&self.0, &block.single);
        let w = g * x + h * y + f32x8::ONE;
        let share = f32x8::ONE / w;
        let p = u - (a * x + b * y + c) * share;
        let q = v - (d * x + e * y + f) * share;
        (p * p + q * q, w.simd_gt(f32x8::splat(MIN_W)))
    }
}

/// What a homography is worth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Score {
    /// Σ max(0, 1 − r²/T²)².
    pub quality: f32,
    /// Pairs with r < T.
    pub count: u32,
}

/// When to give a homography up, by Wald's sequential probability ratio test.
#[derive(Clone, Copy, Debug)]
pub(super) struct Test {
    /// 1/T².
    pub per_square: f32,
    /// Quality to exceed.
    pub beat: f32,
    /// What a pair beyond T adds to the log of the likelihood ratio bad : good.
    pub miss: f32,
    /// What a pair within T takes from it.
    pub hit: f32,
}

/// Logarithm of the likelihood ratio at which a homography is given up: one good one in 100 is lost.
const GIVE_UP: f32 = 4.605;
/// Share of the pairs that a bad homography meets by chance.
const CHANCE: f64 = 0.02;

impl Test {
    /// The test for good homographies with a share of `inliers`.
    pub fn new(limit: f64, beat: f32, inliers: f64) -> Test {
        let share = inliers.clamp(2.0 * CHANCE, 0.99);
        Test {
            per_square: (1.0 / (limit * limit)) as f32,
            beat,
            miss: libm::log((1.0 - CHANCE) / (1.0 - share)) as f32,
            hit: libm::log(share / CHANCE) as f32,
        }
    }

    /// The score of a homography; nothing as soon as it is unlikely or impossible that it exceeds `beat`.
    #[inline]
    pub fn score(&self, matrix: &Matrix8, blocks: &[Block]) -> Option<Score> {
        let mut score = Score::default();
        let mut seen = 0;
        for some in blocks.chunks(2) {
            let mut quality = f32x8::ZERO;
            for block in some {
                let (square, front) = matrix.residuals(block);
                let near = f32x8::ONE - square * f32x8::splat(self.per_square);
                let good = front & f32x8::ZERO.simd_lt(near);
                score.count += good.to_bitmask().count_ones();
                quality += (near * near) & good;
            }
            score.quality += quality.to_array().iter().sum::<f32>();
            seen += 8 * some.len();
            let ratio = (seen as f32 - score.count as f32) * self.miss - score.count as f32 * self.hit;
            let rest = (8 * blocks.len() - seen) as f32;
            if ratio > GIVE_UP || score.quality + rest <= self.beat {
                return None;
            }
        }
        Some(score)
    }
}
