//! How many features of a coarse frame are found again in an earlier, finer frame, and how long it takes.
//!
//! `cargo run --release --example features -- [FOLDER]` renders the scenes at 512×512 with 64 samples a pixel, and from
//! the same place, turned, with 4; the true motion is then a homography. It prints the matches (ratio 0.8), those
//! within 3 pixels of the truth, the error of the homography fitted to them at the picture's corners that both frames
//! see, and the time of detection in both frames, matching and fitting on one thread. To FOLDER it writes the pictures
//! that features were looked for in, 8-bit, median filtered, and the true homographies (coarse to fine), row by row.

use pmcip::render;
use pmcip::scene::{self, View};
use pmcip::settings::{Method, Settings};
use pmcip_core::features::{self, Feature, Picture};
use pmcip_core::homography::{self, Block, Fit, Homography, Pair};
use std::path::Path;
use std::time::Instant;

const SIDE: usize = 512;
/// Where the camera looks, what is up, and by how many pixels at most the picture moves.
const TURNS: [(&str, [f32; 3], [f32; 3]); 3] = [
    ("small", [290.0, 268.0, 0.0], [0.0, 1.0, 0.0]),
    ("large", [218.0, 303.0, 0.0], [0.1, 1.0, 0.0]),
    ("rolled", [120.0, 373.0, 0.0], [0.4, 1.0, 0.0]),
];

fn main() -> std::io::Result<()> {
    let folder = std::env::args().nth(1);
    println!("| frame | features | matches | within 3 px | homography, corner error | ms |");
    println!("| --- | --- | --- | --- | --- | --- |");
    for name in ["cornell", "caustic"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{name}.toml"));
        let scene = scene::load(&path).expect("a scene of this project loads");
        let fine = coded(&scene, scene.view, 64, 1);
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

/// A frame in steps of 1/255 of white, median filtered.
fn coded(scene: &scene::LoadedScene, view: View, spp: u32, seed: u32) -> Vec<f32> {
    let side = SIDE as u32;
    let mut settings = Settings::new(scene, Method::Uniform, Some(spp), Some((side, side)));
    (settings.view, settings.sampler.seed) = (view, seed);
    let frame = render::render(scene, &settings, None, &|_| ()).expect("a frame renders");
    let code = |rgb: &[f32; 3]| {
        let luminance = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
        (255.0 * luminance.clamp(0.0, 1.0).powf(1.0 / 2.2)).round() / 255.0
    };
    let coded: Vec<f32> = frame.picture(&settings, scene).rgb.iter().map(code).collect();
    let mut filtered = vec![0.0; coded.len()];
    let picture = Picture::new(&coded, SIDE, SIDE).expect("a picture of that size");
    features::median3(picture, &mut filtered).expect("as many values");
    filtered
}

/// The homography from one view to another from the same place.
fn motion(from: &View, to: &View) -> Homography {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| {
        let from_pixel = [x * SIDE as f64, y * SIDE as f64];
        let (a, b) = (axes(from), axes(to));
        let half = (f64::from(from.fov) / 2.0).to_radians().tan();
        let (u, v) = (half * (2.0 * x - 1.0), half * (2.0 * y - 1.0));
        let direction = [0, 1, 2].map(|i| u * a[0][i] + v * a[1][i] + a[2][i]);
        let [r, d, f] = b.map(|axis| (0..3).map(|i| axis[i] * direction[i]).sum::<f64>());
        let pixel = |t: f64| (t / f / half + 1.0) / 2.0 * SIDE as f64;
        Pair { from: from_pixel, to: [pixel(r), pixel(d)] }
    });
    Homography::through(&corners).expect("the views overlap")
}

/// A view's right, down and forward.
fn axes(view: &View) -> [[f64; 3]; 3] {
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [0, 1, 2].map(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            a[j] * b[k] - a[k] * b[j]
        })
    };
    let unit = |a: [f64; 3]| {
        let length = a.iter().map(|c| c * c).sum::<f64>().sqrt();
        a.map(|c| c / length)
    };
    let forward = unit([0, 1, 2].map(|i| f64::from(view.at[i]) - f64::from(view.from[i])));
    let right = unit(cross(forward, view.up.map(f64::from)));
    [right, cross(forward, right), forward]
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
