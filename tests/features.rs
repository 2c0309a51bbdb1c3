//! Features of coarse frames, against what OpenCV finds in the same pictures.

use measure::turned::{SIDE, TURNS, coded, motion};
use pmcip::scene;
use pmcip_core::predict::features::{self, Feature, Picture, Settings};
use pmcip_core::predict::homography::{self, Block, Pair};
use std::path::Path;

/// Features of a picture of `SIDE` × `SIDE`.
fn found(values: &[f32]) -> Vec<Feature> {
    let mut scratch = vec![0.0; features::required(SIDE, SIDE)];
    let mut found = vec![Feature::default(); 2_000];
    let picture = Picture::new(values, SIDE, SIDE).expect("a picture of that size");
    let count = features::detect(picture, &Settings::default(), &mut scratch, &mut found);
    found.truncate(count.expect("scratch as required"));
    found
}

/// OpenCV 5.0.0: `SIFT_create()`, brute-force matcher, ratio 0.8, correct within 3 pixels, on the same 8-bit pictures of
/// `caustic`, as `cargo run --release -p measure -- features 16 FOLDER` writes them; by the turns of the camera.
const OPENCV: [usize; 3] = [11, 11, 6];

#[test]
fn coarse_frames_have_at_least_as_many_correct_matches_as_with_opencv() {
    let scene = scene::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/caustic.toml")).unwrap();
    let fine = found(&coded(&scene, scene.view, 16, 1));
    for ((turn, at, up), opencv) in TURNS.into_iter().zip(OPENCV) {
        let view = scene::View { at, up, ..scene.view };
        let coarse = found(&coded(&scene, view, 4, 2));
        let truth = motion(&view, &scene.view);
        let pairs: Vec<Pair> =
            features::matches(&coarse, &fine, 0.8).map(|found| found.pair(&coarse, &fine)).collect();
        let correct = pairs.iter().filter(|pair| truth.error(pair) < 3.0).count();
        let mut scratch = vec![Block::default(); homography::required(pairs.len())];
        let fit = homography::estimate(&pairs, &homography::Settings::default(), &mut scratch).unwrap();
        println!("{turn}: {correct} of {} matches are correct, OpenCV {opencv}", pairs.len());
        assert!(correct >= opencv, "{turn}: {correct} of {} matches, OpenCV {opencv}", pairs.len());
        let middle = [SIDE as f64 / 2.0; 2];
        let to = truth.apply(middle).expect("in front of the camera");
        assert!(fit.homography.error(&Pair { from: middle, to }) < 4.0, "{turn}: {fit:?}");
    }
}
