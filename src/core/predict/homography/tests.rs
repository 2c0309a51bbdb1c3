use super::*;
use crate::maths::sobol::hash;
use proptest::prelude::*;

const MANY: usize = 200;

fn fit(pairs: &[Pair]) -> Result<Fit, Error> {
    let mut scratch = [Block::default(); required(MANY)];
    estimate(pairs, &Settings::default(), &mut scratch)
}

/// Number `i` of a sequence in [0, 1).
fn unit(seed: u32, i: usize) -> f64 {
    f64::from(hash(hash(seed) ^ i as u32)) / 4_294_967_296.0
}

/// Point number `i` of a sequence in a square.
fn point(seed: u32, i: usize, side: f64) -> [f64; 2] {
    [side * unit(seed, 2 * i), side * unit(seed, 2 * i + 1)]
}

/// A homography that moves every corner of a square by up to a quarter of its side.
fn random(seed: u32, side: f64) -> Homography {
    (0..)
        .find_map(|attempt| {
            let key = hash(seed) ^ attempt;
            let corners: [Pair; 4] = core::array::from_fn(|i| {
                let from = [[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]][i];
                let shift = point(key, i, 0.5 * side);
                Pair { from, to: [from[0] + shift[0] - 0.25 * side, from[1] + shift[1] - 0.25 * side] }
            });
            Homography::through(&corners).ok()
        })
        .expect("most squares stay convex")
}

/// Pairs of which the first `good` follow `truth`.
fn pairs(truth: &Homography, good: usize, side: f64, seed: u32) -> [Pair; MANY] {
    core::array::from_fn(|i| {
        let from = point(seed, i, side);
        let to = truth.apply(from).expect("in front of the horizon");
        Pair { from, to: if i < good { to } else { point(!seed, i, side) } }
    })
}

/// Largest distance between what two homographies make of a square's corners.
fn distance(a: &Homography, b: &Homography, side: f64) -> f64 {
    [[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]].iter().fold(0.0, |worst: f64, &corner| {
        let to = b.apply(corner).expect("in front of the horizon");
        worst.max(a.error(&Pair { from: corner, to }))
    })
}

#[test]
fn points_without_noise_are_met_exactly_at_any_size() {
    for side in [1.0, 64.0, 512.0, 16_384.0] {
        for seed in 0..50 {
            let truth = random(seed, side);
            for good in [60, 200] {
                let settings = Settings { threshold: 3.0 * side / 512.0, ..Settings::default() };
                let mut scratch = [Block::default(); required(MANY)];
                let fit = estimate(&pairs(&truth, good, side, seed), &settings, &mut scratch);
                let fit = fit.expect("a consensus");
                let error = distance(&fit.homography, &truth, side);
                assert!(error < 1e-4 && error < 1e-6 * side, "side {side}, seed {seed}: {error}");
                assert!(fit.inliers as usize >= good);
            }
        }
    }
}

#[test]
fn through_four_points_and_back() {
    for seed in 0..200 {
        let truth = random(seed, 16_384.0);
        let four: [Pair; 4] = core::array::from_fn(|i| pairs(&truth, MANY, 16_384.0, seed)[i]);
        let Ok(found) = Homography::through(&four) else { continue };
        assert!(four.iter().all(|pair| found.error(pair) < 1e-6), "seed {seed}");
        let back = found.inverse().expect("regular");
        let reverse = |pair: &Pair| Pair { from: pair.to, to: pair.from };
        assert!(four.iter().all(|pair| back.error(&reverse(pair)) < 1e-5), "seed {seed}");
    }
}

#[test]
fn four_pairs_are_taken_as_they_are_and_five_are_checked() {
    let truth = random(3, 512.0);
    let all = pairs(&truth, MANY, 512.0, 9);
    let square = [[0.0, 0.0], [512.0, 0.0], [512.0, 512.0], [0.0, 512.0], [100.0, 300.0]];
    let mut five = square.map(|from| Pair { from, to: truth.apply(from).expect("in front") });
    assert!(distance(&fit(&five[..4]).expect("four").homography, &truth, 512.0) < 1e-4);
    assert!(distance(&fit(&five).expect("five").homography, &truth, 512.0) < 1e-4);
    five[4].to = all[7].from;
    assert_eq!(fit(&five), Err(Error::NoConsensus));
}

#[test]
fn too_few_or_unusable_arguments_are_errors() {
    let good = pairs(&random(1, 512.0), MANY, 512.0, 1);
    assert_eq!(fit(&[]), Err(Error::Pairs));
    assert_eq!(fit(&good[..3]), Err(Error::Pairs));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 2e6] {
        let mut pairs = good;
        pairs[50].from[1] = bad;
        assert_eq!(fit(&pairs), Err(Error::Coordinate));
        (pairs[50].from[1], pairs[50].to[0]) = (0.0, bad);
        assert_eq!(fit(&pairs), Err(Error::Coordinate));
    }
    let mut scratch = [Block::default(); required(MANY)];
    for (threshold, confidence) in [(0.0, 0.9), (-1.0, 0.9), (f64::NAN, 0.9), (3.0, 1.0), (3.0, f64::NAN)] {
        let settings = Settings { threshold, confidence, ..Settings::default() };
        assert_eq!(estimate(&good, &settings, &mut scratch), Err(Error::Settings));
    }
    assert_eq!(estimate(&good, &Settings::default(), &mut scratch[1..]), Err(Error::Scratch));
}

#[test]
fn coincident_and_collinear_points_are_degenerate() {
    let truth = random(2, 512.0);
    let same = [Pair { from: [3.0, 4.0], to: [5.0, 6.0] }; MANY];
    assert_eq!(fit(&same), Err(Error::Degenerate));
    let mut three = pairs(&truth, MANY, 512.0, 2);
    (3..MANY).for_each(|i| three[i] = three[i % 3]);
    assert!(fit(&three).is_err());
    for (seed, direction) in [[1.0, 0.0], [0.0, 1.0], [0.7, 0.3], [0.5, -0.5]].into_iter().enumerate() {
        for noise in [0.0, 0.5, 2.0] {
            let line = |i: usize| {
                let t = 512.0 * unit(10, i);
                let wobble = [0, 1].map(|c| noise * (unit(11, 2 * i + c) - 0.5));
                [20.0 + direction[0] * t + wobble[0], 300.0 + direction[1] * t + wobble[1]]
            };
            for off_the_line in [0, 1, 2, 5, 20, 100] {
                let mut pairs = pairs(&truth, 0, 512.0, seed as u32);
                for (i, pair) in pairs.iter_mut().enumerate().skip(off_the_line) {
                    let from = line(i);
                    let to = truth.apply(from).expect("in front");
                    let noise = [0, 1].map(|c| noise * (unit(12, 2 * i + c) - 0.5));
                    *pair = Pair { from, to: [to[0] + noise[0], to[1] + noise[1]] };
                }
                let result = fit(&pairs);
                assert!(result.is_err(), "{direction:?}, noise {noise}, {off_the_line} off: {result:?}");
            }
        }
    }
}

/// 400 sets; were chance to fit one in 100 of them, some would fit with probability 1 − 0.99^400 = 0.98.
#[test]
fn pairs_without_a_homography_have_no_consensus() {
    for seed in 0..400 {
        let count = [5, 12, 40, 200][seed as usize % 4];
        let result = fit(&pairs(&random(seed, 512.0), 0, 512.0, seed)[..count]);
        assert!(matches!(result, Err(Error::NoConsensus)), "{count} pairs, seed {seed}: {result:?}");
    }
}

#[test]
fn mirrored_pairs_have_no_consensus() {
    let mut pairs = pairs(&random(4, 512.0), MANY, 512.0, 4);
    pairs.iter_mut().for_each(|pair| pair.to[0] *= -1.0);
    assert_eq!(fit(&pairs), Err(Error::NoConsensus));
}

#[test]
fn nothing_is_mapped_from_behind_the_horizon() {
    let tilted = Homography { matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.01, 0.0, 1.0]] };
    assert!(tilted.apply([99.0, 0.0]).is_some());
    assert_eq!((tilted.apply([100.0, 0.0]), tilted.apply([101.0, 0.0])), (None, None));
    assert_eq!(tilted.error(&Pair { from: [101.0, 0.0], to: [0.0, 0.0] }), f64::INFINITY);
    assert_eq!(Homography { matrix: [[1.0; 3]; 3] }.inverse(), None);
    // The first picture reaches behind the horizon of a plane seen at a grazing angle; those pairs are outliers.
    let all: [Pair; MANY] = core::array::from_fn(|i| {
        let from = point(7, i, 150.0);
        Pair { from, to: tilted.apply(from).filter(|_| from[0] < 90.0).unwrap_or(point(8, i, 500.0)) }
    });
    let found = fit(&all).expect("a consensus").homography;
    assert!(all.iter().filter(|p| p.from[0] < 90.0).all(|pair| found.error(pair) < 1e-3));
}

#[test]
fn the_same_call_gives_the_same_bits_and_the_seed_matters_little() {
    let truth = random(5, 512.0);
    let mut noisy = pairs(&truth, 80, 512.0, 5);
    for (i, pair) in noisy.iter_mut().enumerate() {
        pair.to[i % 2] += 3.0 * unit(9, i) - 1.5;
    }
    let mut scratch = [Block::default(); required(MANY)];
    let mut with = |seed| {
        let settings = Settings { seed, ..Settings::default() };
        estimate(&noisy, &settings, &mut scratch).expect("a consensus").homography
    };
    let first = with(0);
    assert_eq!(first, with(0));
    for seed in 1..20 {
        assert!(distance(&first, &with(seed), 512.0) < 0.05, "the refinement forgets where it started");
    }
}

/// Score and residuals of eight lanes against one pair at a time in double precision.
#[test]
fn packets_agree_with_scalars() {
    let truth = random(6, 512.0);
    let pairs = pairs(&truth, 120, 512.0, 6);
    let frames = minimal::frames(&pairs).expect("spread out");
    let mut blocks = [Block::default(); required(MANY)];
    score::fill(&mut blocks, &pairs, &frames);
    let (from, to) = ([0, 1, 2, 3].map(|i| pairs[i].from), [0, 1, 2, 3].map(|i| pairs[i].to));
    let (from, to) = (from.map(|p| frames[0].inward(p)), to.map(|p| frames[1].inward(p)));
    let Some(matrix) = minimal::through(&from, &to, 1e-6) else { panic!("a sample of inliers") };
    let reach = 6.0 * frames[1].scale;
    let test = score::Test::new(reach, 0.0, 0.5);
    let score = test.score(&score::Matrix8::new(&matrix), &blocks).expect("a good homography");
    let homography = minimal::outward(&matrix, &frames);
    let near = |pair: &Pair| (1.0 - (homography.error(pair) / 6.0).powi(2)).max(0.0).powi(2);
    let quality: f64 = pairs.iter().map(near).sum();
    assert!((f64::from(score.quality) - quality).abs() < 1e-3 * quality, "{score:?} {quality}");
    assert_eq!(score.count as usize, pairs.iter().filter(|pair| homography.error(pair) < 6.0).count());
}

proptest! {
    /// Whatever the pairs are, the answer is an error or fits as many pairs as it says.
    #[test]
    fn never_a_wild_matrix(
        raw in prop::collection::vec(prop::array::uniform4(-3i32..4), 4..40),
        scale in prop::sample::select(&[1e-3, 1.0, 1e4][..]),
    ) {
        let mut pairs = [Pair::default(); 40];
        for (pair, [x, y, u, v]) in pairs.iter_mut().zip(&raw) {
            let [x, y, u, v] = [x, y, u, v].map(|c| scale * f64::from(*c));
            *pair = Pair { from: [x, y], to: [u, v] };
        }
        if let Ok(fit) = fit(&pairs[..raw.len()]) {
            let matrix = fit.homography.matrix;
            prop_assert!(matrix.iter().flatten().all(|entry| entry.is_finite()));
            let fits = pairs[..raw.len()].iter().filter(|pair| fit.homography.error(pair) <= 3.0).count();
            prop_assert_eq!(fits, fit.inliers as usize);
        }
    }
}
