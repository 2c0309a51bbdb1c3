//! `guide`: pictures of any origin get the energy of the frame's unbiased layer.

mod program;

use pmcip::frame::restore::{Restored, Source, restore};
use pmcip::picture::frame_io::{Picture, read_exr, write_exr};
use program::{failure, success};
use proptest::prelude::*;
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::sync::LazyLock;
use tempfile::TempDir;

const SIZE: (u32, u32) = (53, 38);

/// The glass ball and its caustic by an estimator, with everything that is needed; in `folder`.
fn render(folder: &Path, estimator: &str) {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/caustic.toml");
    let arguments = format!(
        "render {} --spp 8 --size {}x{} --quiet --estimator {estimator} --layers unbiased,balanced,variance -o {estimator}.exr",
        scene.display(),
        SIZE.0,
        SIZE.1
    );
    success(folder, &arguments);
}

fn frame(estimator: &str) -> (TempDir, Picture) {
    let folder = tempfile::tempdir().unwrap();
    render(folder.path(), estimator);
    let picture = read_exr(&folder.path().join(estimator).with_extension("exr")).unwrap();
    (folder, picture)
}

static BALANCED: LazyLock<Picture> = LazyLock::new(|| frame("balanced").1);

fn layer(picture: &Picture, name: &str) -> Vec<[f32; 3]> {
    let [r, g, b] = ["R", "G", "B"].map(|c| &picture.planes[&format!("{name}.{c}")]);
    r.iter().zip(g).zip(b).map(|((r, g), b)| [*r, *g, *b]).collect()
}

fn plain(rgb: Vec<[f32; 3]>) -> Picture {
    Picture { width: SIZE.0, height: SIZE.1, rgb, ..Picture::default() }
}

fn restored(frame: &Picture, rgb: Vec<[f32; 3]>) -> Restored {
    let (path, denoised) = (Path::new("a.exr"), plain(rgb));
    restore(Source { path, picture: frame }, Source { path, picture: &denoised }).unwrap()
}

/// That every colour has the energy of the unbiased layer, to the rounding of what was added and taken.
fn check_energy(frame: &Picture, denoised: &[[f32; 3]], restored: &[[f32; 3]]) {
    let unbiased = layer(frame, "unbiased");
    for c in 0..3 {
        let sum = |rgb: &[[f32; 3]]| rgb.iter().map(|rgb| f64::from(rgb[c])).sum::<f64>();
        let size = |rgb: &[[f32; 3]]| rgb.iter().map(|rgb| f64::from(rgb[c].abs())).sum::<f64>();
        let off = sum(restored) - sum(&unbiased);
        let scale = size(restored) + size(&unbiased) + size(denoised);
        assert!(off.abs() <= 1e-5 * scale, "energy is off by {off} of {scale}");
    }
}

#[test]
fn zero_negative_huge_and_other_pictures_get_the_energy() {
    let pixels = (SIZE.0 * SIZE.1) as usize;
    let ramp = (0..pixels).map(|i| [i as f32, (pixels - i) as f32, 0.5]).collect::<Vec<_>>();
    for rgb in [
        vec![[0.0; 3]; pixels],
        vec![[-1.0; 3]; pixels],
        vec![[1e15; 3]; pixels],
        vec![[f32::MAX, 0.0, f32::MIN]; pixels],
        ramp,
        layer(&BALANCED, "unbiased"),
    ] {
        let out = restored(&BALANCED, rgb.clone()).rgb;
        assert!(out.as_flattened().iter().all(|v| v.is_finite()));
        // What is beyond all radiance is replaced, so its size does not count.
        let usable: Vec<[f32; 3]> =
            rgb.into_iter().filter(|rgb| rgb.iter().all(|v| v.abs() <= 1e15)).collect();
        check_energy(&BALANCED, &usable, &out);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn any_noise_gets_the_energy(seed in any::<u32>(), scale in -10f32..8.0) {
        let value = |i: u32| {
            let x = (i ^ seed).wrapping_mul(0x9e37_79b9);
            let x = (x ^ x >> 15).wrapping_mul(0x2c1b_3c6d);
            ((x ^ x >> 12) as f32 / u32::MAX as f32 - 0.3) * 10f32.powf(scale)
        };
        let rgb: Vec<[f32; 3]> = (0..SIZE.0 * SIZE.1).map(|i| [0, 1, 2].map(|c| value(3 * i + c))).collect();
        check_energy(&BALANCED, &rgb, &restored(&BALANCED, rgb.clone()).rgb);
    }
}

fn difference(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let square = |(a, b): (&f32, &f32)| f64::from(a - b).powi(2);
    let squares: f64 = a.as_flattened().iter().zip(b.as_flattened()).map(square).sum();
    let scale: f64 = b.as_flattened().iter().map(|v| f64::from(*v).powi(2)).sum();
    (squares / scale).sqrt()
}

#[test]
fn a_frames_own_picture_stays_what_it_is() {
    for estimator in ["balanced", "guided"] {
        let (_folder, picture) = frame(estimator);
        let out = restored(&picture, picture.rgb.clone());
        assert!(out.bias_before.abs() < 1e-5 && out.bias_after.abs() < 1e-5, "{out:?}");
        let off = difference(&out.rgb, &picture.rgb);
        assert!(off < 1e-4, "{estimator} is off by {off}");
        // A darker one is not, so the measure sees what it should.
        let darker: Vec<[f32; 3]> = picture.rgb.iter().map(|rgb| rgb.map(|v| 0.9 * v)).collect();
        let out = restored(&picture, darker.clone());
        assert!((out.bias_before + 0.1).abs() < 1e-5 && out.bias_after.abs() < 1e-5);
        assert!(difference(&out.rgb, &picture.rgb) > 0.01);
    }
}

#[test]
fn the_command_writes_a_frame_that_says_who_guided_it() {
    let (folder, picture) = frame("guided");
    let path = folder.path();
    let dim: Vec<[f32; 3]> = picture.rgb.iter().map(|rgb| rgb.map(|v| 0.5 * v)).collect();
    write_exr(&path.join("dim.exr"), &plain(dim.clone())).unwrap();
    let said = success(path, "guide guided.exr --with dim.exr -o out.exr --json");
    let report: Value = serde_json::from_str(&said).unwrap();
    assert!((report["energy_bias_before"].as_f64().unwrap() + 0.5).abs() < 1e-5, "{report}");
    assert!(report["energy_bias_after"].as_f64().unwrap().abs() < 1e-5, "{report}");
    assert_eq!(report["files"], serde_json::json!(["out.exr", "out.png"]));
    let out = read_exr(&path.join("out.exr")).unwrap();
    assert_eq!(out.rgb, restored(&picture, dim).rgb);
    assert_eq!(out.planes, picture.planes);
    let mut wanted = picture.attributes.clone();
    wanted.insert("guided_by".into(), "dim.exr".into());
    assert_eq!(out.attributes, wanted);
    let png = fs::read(path.join("out.png")).unwrap();
    let said = success(path, "guide guided.exr --with dim.exr -o out.exr --exposure -2");
    assert!(
        said.contains("dim.exr had -50.0000 %, has") && said.contains("wrote out.exr and out.png"),
        "{said}"
    );
    assert!(png != fs::read(path.join("out.png")).unwrap());
}

#[test]
fn what_cannot_be_guided_is_named_and_nothing_is_lost() {
    let (folder, picture) = frame("balanced");
    let path = folder.path();
    let write = |name: &str, picture: &Picture| write_exr(&path.join(name), picture).unwrap();
    let mut broken = plain(picture.rgb.clone());
    broken.rgb[7][1] = f32::NAN;
    broken.rgb[9][2] = f32::INFINITY;
    write("broken.exr", &broken);
    write("small.exr", &Picture { width: 2, height: 1, rgb: vec![[1.0; 3]; 2], ..Picture::default() });
    write("plain.exr", &plain(picture.rgb.clone()));
    let mut unsaid = picture.clone();
    unsaid.attributes.remove("balance_radius");
    write("unsaid.exr", &unsaid);
    unsaid.attributes.insert("balance_radius".into(), "99999".into());
    write("wide.exr", &unsaid);
    let mut holes = picture.clone();
    holes.planes.get_mut("unbiased.G").unwrap()[3] = f32::NAN;
    write("holes.exr", &holes);
    fs::create_dir(path.join("folder.exr")).unwrap();
    fs::write(path.join("text.exr"), "no picture").unwrap();
    fs::copy(path.join("plain.exr"), path.join("out.exr")).unwrap();
    let before: Vec<_> = fs::read_dir(path).unwrap().map(|file| file.unwrap().file_name()).collect();
    let out = fs::read(path.join("out.exr")).unwrap();
    for (arguments, words) in [
        ("balanced.exr --with broken.exr -o out.exr", "broken.exr: it has 2 pixels that are not finite"),
        ("balanced.exr --with small.exr -o out.exr", "small.exr: it has 2×1 pixels, balanced.exr 53×38"),
        ("plain.exr --with plain.exr -o out.exr", "plain.exr: it has no layer 'unbiased'"),
        ("unsaid.exr --with plain.exr -o out.exr", "unsaid.exr: it does not say its balance_radius"),
        ("wide.exr --with plain.exr -o out.exr", "wide.exr: the balance radius must be at most"),
        ("holes.exr --with plain.exr -o out.exr", "holes.exr: it has 1 pixels that are not finite"),
        ("none.exr --with plain.exr -o out.exr", "none.exr: no such file or folder"),
        ("balanced.exr --with text.exr -o out.exr", "text.exr"),
        ("balanced.exr --with plain.exr -o folder.exr", "folder.exr: it is a folder"),
        ("balanced.exr --with plain.exr -o none/a.exr", "none/a.exr: no such file or folder"),
        ("balanced.exr --with plain.exr -o ./balanced.exr", "balanced.exr would be overwritten"),
        ("balanced.exr --with plain.exr -o plain.exr", "plain.exr would be overwritten"),
        ("balanced.exr --with plain.exr -o out.png", "must end in .exr"),
        ("balanced.exr -o out.exr", "--with <DENOISED.exr>"),
        ("balanced.exr --with plain.exr", "--output <OUT.exr>"),
    ] {
        failure(path, &format!("guide {arguments}"), 2, words);
    }
    let after: Vec<_> = fs::read_dir(path).unwrap().map(|file| file.unwrap().file_name()).collect();
    assert_eq!(before, after);
    assert!(out == fs::read(path.join("out.exr")).unwrap());
    assert_eq!(read_exr(&path.join("balanced.exr")).unwrap(), picture);
}
