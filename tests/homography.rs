//! Homographies among noise and outliers, against what OpenCV finds on the same points.

use measure::pairs::{self, PAIRS, Problem, Problems};
use pmcip_core::predict::homography::{self, Block, Error, Homography, Pair, Settings};

/// Corner errors of all problems at a threshold.
fn errors(problems: &[Problem], threshold: f64) -> Vec<f64> {
    let settings = Settings { threshold, ..Settings::default() };
    let mut scratch = [Block::default(); homography::required(PAIRS)];
    let mut error = |problem: &Problem| {
        let fit = homography::estimate(&problem.pairs, &settings, &mut scratch);
        pairs::corner_error(&problem.truth, fit.as_ref().ok().map(|fit| &fit.homography))
    };
    problems.iter().map(&mut error).collect()
}

/// OpenCV 5.0.0 (`findHomography`, defaults but for method and threshold, one thread) on the same 200 problems:
/// `USAC_MAGSAC` and `RANSAC`, mean corner error in pixels and area under the curve of corner errors up to 5 pixels.
/// The points come from `cargo run --release -p measure -- homography 200 1 3 FILE`.
const OPENCV: [(f64, [(f64, f64); 2]); 2] =
    [(3.0, [(0.6472, 0.8706), (1.2649, 0.7507)]), (1.5, [(0.6485, 0.8703), (2.1000, 0.6078)])];

#[test]
fn corners_are_met_at_least_as_well_as_by_opencv() {
    let problems: Vec<Problem> = Problems::new(1).take(200).collect();
    for (threshold, opencv) in OPENCV {
        let errors = errors(&problems, threshold);
        let (mean, area) = (pairs::mean(&errors), pairs::area(&errors));
        println!("threshold {threshold}: mean corner error {mean:.4} px, area {area:.4}");
        for (their_mean, their_area) in opencv {
            assert!(mean <= their_mean && area >= their_area, "{threshold}: {mean} {area}, {opencv:?}");
        }
    }
}

/// Points and images of each other: nothing fits more of them than chance.
#[test]
fn outliers_alone_are_an_error() {
    let mut scratch = [Block::default(); homography::required(PAIRS)];
    for mut problem in Problems::new(2).take(100) {
        let to: Vec<[f64; 2]> = problem.pairs.iter().map(|pair| pair.to).collect();
        problem.pairs.iter_mut().zip(to.iter().cycle().skip(77)).for_each(|(pair, to)| pair.to = *to);
        let result = homography::estimate(&problem.pairs, &Settings::default(), &mut scratch);
        assert_eq!(result.err(), Some(Error::NoConsensus));
    }
}

/// Two planes: the one with more pairs is found, and the other one among the rest.
#[test]
fn what_one_homography_leaves_another_explains() {
    let mut scratch = [Block::default(); homography::required(PAIRS)];
    let truths: Vec<Homography> = Problems::new(3).take(2).map(|problem| problem.truth).collect();
    let mut points = Problems::new(4).take(1).flat_map(|problem| problem.pairs).map(|pair| pair.from);
    let to = |truth: &Homography, from: [f64; 2]| truth.apply(from).expect("in front of the horizon");
    let all: Vec<Pair> = (0..PAIRS)
        .map(|i| {
            let from = points.next().expect("as many points");
            Pair { from, to: to(&truths[usize::from(i % 3 == 0)], from) }
        })
        .collect();
    let settings = Settings::default();
    let first = homography::estimate(&all, &settings, &mut scratch).expect("a consensus").homography;
    let rest: Vec<Pair> = all.into_iter().filter(|pair| first.error(pair) > settings.threshold).collect();
    let second = homography::estimate(&rest, &settings, &mut scratch).expect("a consensus").homography;
    assert!(pairs::corner_error(&truths[0], Some(&first)) < 1e-6);
    assert!(pairs::corner_error(&truths[1], Some(&second)) < 1e-6);
}
