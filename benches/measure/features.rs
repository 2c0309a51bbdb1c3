//! How many features of a coarse frame are found again in an earlier, finer frame, and how long it takes.
//!
//! `cargo run --release -p measure -- features [SPP [FOLDER]]` renders the scenes at 512×512 with SPP (64) samples a
//! pixel, and from the same place, turned, with 4; the true motion is then a homography. It prints the matches (ratio
//! 0.8), those within 3 pixels of the truth, the mean error of the homography fitted to them at the corners of the
//! picture's middle half, and the time of detection in both frames, matching and fitting on one thread. To FOLDER it
//! writes the pictures that features were looked for in, 8-bit, median filtered, and the true homographies (coarse to
//! fine), row by row, so that other detectors can be run on them.

use crate::turned::{SIDE, TURNS, coded, motion};
use pmcip::scene::{self, View};
use pmcip_core::predict::features::{self, Feature, Picture};
use pmcip_core::predict::homography::{self, Block, Fit, Homography, Pair};
use std::path::Path;
use std::time::Instant;

/// Prints the table.
pub fn run(arguments: &[String]) -> std::io::Result<()> {
    let spp = arguments.first().map_or(64, |spp| spp.parse().expect("a number of samples"));
    let folder = arguments.get(1);
    println!("| frame | features | matches | within 3 px | homography, corner error | ms |");
    println!("| --- | --- | --- | --- | --- | --- |");
    for name in ["cornell", "caustic"] {
        let path = crate::scene_file(name);
        let scene = scene::load(&path).expect("a scene of this project loads");
        let fine = coded(&scene, scene.view, spp, 1);
        for (turn, at, up) in TURNS {
            let view = View { at, up, ..scene.view };
            let coarse = coded(&scene, view, 4, 2);
            let truth = motion(&view, &scene.view);
            if let Some(folder) = &folder {
                write(Path::new(folder), &format!("{name}_{turn}"), &coarse, &fine, &truth)?;
            }
            measure(&format!("{name}, {turn}"), &coarse, &fine, &truth);
        }
    }
    Ok(())
}

fn write(folder: &Path, name: &str, coarse: &[f32], fine: &[f32], truth: &Homography) -> std::io::Result<()> {
    for (kind, values) in [("coarse", coarse), ("fine", fine)] {
        let mut file = format!("P5 {SIDE} {SIDE} 255\n").into_bytes();
        file.extend(values.iter().map(|value| (255.0 * value).round() as u8));
        std::fs::write(folder.join(format!("{name}_{kind}.pgm")), file)?;
    }
    std::fs::write(folder.join(format!("{name}.txt")), format!("{:?}", truth.matrix.as_flattened()))
}

fn measure(name: &str, coarse: &[f32], fine: &[f32], truth: &Homography) {
    let mut scratch = vec![0.0; features::required(SIDE, SIDE)];
    let mut found = [vec![Feature::default(); 2_000], vec![Feature::default(); 2_000]];
    let mut pairs = Vec::with_capacity(2_000);
    let mut blocks = vec![Block::default(); homography::required(2_000)];
    let mut times = Vec::new();
    let mut result = ([0; 2], Err(homography::Error::Pairs));
    for _ in 0..5 {
        let start = Instant::now();
        let mut counts = [0; 2];
        for ((picture, found), count) in [coarse, fine].into_iter().zip(&mut found).zip(&mut counts) {
            let picture = Picture::new(picture, SIDE, SIDE).expect("a picture of that size");
            let settings = features::Settings::default();
            *count = features::detect(picture, &settings, &mut scratch, found).expect("scratch as required");
        }
        let (from, to) = (&found[0][..counts[0]], &found[1][..counts[1]]);
        pairs.clear();
        pairs.extend(features::matches(from, to, 0.8).map(|m| m.pair(from, to)));
        let fit = homography::estimate(&pairs, &homography::Settings::default(), &mut blocks);
        times.push(start.elapsed().as_secs_f64());
        result = (counts, fit);
    }
    times.sort_by(f64::total_cmp);
    let (counts, fit) = result;
    let correct = pairs.iter().filter(|pair| truth.error(pair) < 3.0).count();
    let (matches, ms, error) = (pairs.len(), 1e3 * times[2], corner_error(&fit, truth));
    println!("| {name} | {} + {} | {matches} | {correct} | {error} | {ms:.1} |", counts[0], counts[1]);
}

/// Mean error of a fit at the corners of the middle half of the coarse frame.
fn corner_error(fit: &Result<Fit, homography::Error>, truth: &Homography) -> String {
    let fit = match fit {
        Ok(fit) => fit,
        Err(error) => return error.to_string(),
    };
    let (low, high) = (0.25 * SIDE as f64, 0.75 * SIDE as f64);
    let corners = [[low, low], [high, low], [high, high], [low, high]];
    let error = |from: [f64; 2]| {
        truth.apply(from).map_or(f64::INFINITY, |to| fit.homography.error(&Pair { from, to }))
    };
    format!("{:.2} px, {} inliers", corners.into_iter().map(error).sum::<f64>() / 4.0, fit.inliers)
}
