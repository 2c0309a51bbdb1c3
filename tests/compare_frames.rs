//! `compare --frames` from outside: curves over frames, flicker, a reference for each frame.

use pmcip::picture::frame_io::{Picture, read_exr};
use pmcip::picture::metrics::{Errors, flicker, measure};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

/// A ball before a wall.
const SCENE: &str = "[film]\nwidth = 24\nheight = 16\n[frames]\nfirst = 1\nlast = 9\n\
    [camera]\nfrom = [0, 0, 5]\nat = [0, 0, 0]\nfov = 40\n\
    keys = [{ frame = 1, from = [0, 0, 5] }, { frame = 4, from = [1, 0, 5] }]\n\
    [[spheres]]\ncenter = [0, 0, 0]\nradius = 1\nsubdivisions = 2\nmaterial = \"m\"\n\
    [[spheres]]\ncenter = [0, 0, -60]\nradius = 58\nsubdivisions = 3\nmaterial = \"m\"\n\
    [[lights]]\ncenter = [0, 4, 2]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\nradiance = [9, 9, 9]\n[materials.m]\n";

fn room() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("walk.toml"), SCENE).unwrap();
    folder
}

/// What a successful comparison of frames said on stdout and stderr.
#[track_caller]
fn compare(folder: &Path, more: &str) -> (String, String) {
    let mut program = Command::new(env!("CARGO_BIN_EXE_pmcip"));
    let spp = if more.contains("--reference") { "" } else { "--reference-spp 64" };
    let base = format!("compare walk.toml --spp 2,4 --methods pmc --runs 2 -o report {spp}");
    let arguments = base.split_whitespace().chain(more.split_whitespace());
    let Output { status, stdout, stderr } = program.current_dir(folder).args(arguments).output().unwrap();
    let stderr = String::from_utf8(stderr).unwrap();
    assert!(status.success(), "{more}: {stderr}");
    (String::from_utf8(stdout).unwrap(), stderr)
}

#[test]
fn a_sequence_has_curves_and_flicker() {
    let room = room();
    let (said, _) = compare(room.path(), "--frames 2..4");
    assert!(said.contains("flicker"), "{said}");
    let folder = room.path().join("report");
    let report: Value = serde_json::from_slice(&fs::read(folder.join("report.json")).unwrap()).unwrap();
    let (rows, frames) = (report["rows"].as_array().unwrap(), report["frames"].as_array().unwrap());
    assert_eq!((rows.len(), frames.len()), (4, 12));
    for (i, row) in rows.iter().enumerate() {
        let curve = &frames[3 * i..3 * i + 3];
        let number = |row: &Value, name: &str| row[name].as_f64().unwrap();
        let same = |row: &Value, other: &Value, name| row[name] == other[name];
        assert!(curve.iter().all(|point| same(row, point, "method") && same(row, point, "spp")));
        assert_eq!(curve.iter().map(|p| p["frame"].as_u64().unwrap()).collect::<Vec<_>>(), [2, 3, 4]);
        let err = curve.iter().map(|point| number(point, "err")).sum::<f64>() / 3.0;
        assert!((number(row, "err") / err - 1.0).abs() < 1e-9);
        assert!(curve[0].get("flicker").is_none(), "nothing comes before the first frame");
        let flicker = (number(&curve[1], "flicker") + number(&curve[2], "flicker")) / 2.0;
        assert!((number(row, "flicker") / flicker - 1.0).abs() < 1e-9);
        // Frames have independent noise, so that flicker is the sum of two Errs, but for that of the reference,
        // which is small, for silhouettes that move, and for chance: four differences of 384 heavy-tailed pixels.
        assert!((1.0..3.5).contains(&(flicker / err)), "{}", flicker / err);
    }
    assert!(report["ratios"]["equal_spp"][0]["flicker"].as_f64().unwrap() > 0.0);
    let page = fs::read_to_string(folder.join("report.html")).unwrap();
    // Four measures against time, samples and frames.
    assert_eq!(page.matches("<svg").count(), 12);
    let table = fs::read_to_string(folder.join("frames.csv")).unwrap();
    assert_eq!((table.lines().count(), table.lines().nth(1).unwrap().split(',').count()), (13, 11));
}

#[test]
fn every_frame_has_a_reference_that_is_used_again() {
    let room = room();
    let said = |more: &str| compare(room.path(), more).1;
    assert!(said("--frames 2..3").contains("uses 0 references of the folder, has rendered 2 of 64"));
    assert!(said("--frames 2..4").contains("uses 2 references of the folder, has rendered 1 of 64"));
    let view = |frame: u32| {
        let file = room.path().join(format!("report/reference.{frame:04}.exr"));
        read_exr(&file).unwrap().attributes["look_from"].clone()
    };
    assert_ne!(view(2), view(3));
    // References with a name of the user's, and frames that stand still beyond the last key.
    assert!(said("--frames 2..4 --reference report/reference.exr").is_empty());
}

#[test]
fn flicker_is_the_change_of_the_error_over_the_threshold() {
    let grey = |values: &[f32]| Picture {
        width: values.len() as u32,
        height: 1,
        rgb: values.iter().map(|v| [*v; 3]).collect(),
        ..Picture::default()
    };
    let truth = grey(&[1.0, 2.0]);
    let errors = |image: &[f32]| Errors::new(&grey(image), &truth).unwrap();
    let (a, b) = (errors(&[1.5, 2.0]), errors(&[0.5, 2.0]));
    let change = flicker(&a, &b, 100.0);
    // The same as the Err of an image that is off by the change.
    let err = measure(&grey(&[0.0, 2.0]), &truth, 100.0).unwrap().err;
    assert!((change / err - 1.0).abs() < 1e-6, "{change} {err}");
    assert_eq!(flicker(&a, &a, 100.0), 0.0);
    // What a bright object leaves behind is not judged by the dark alone.
    let uncovered = Errors::new(&grey(&[0.0, 2.0]), &grey(&[0.0, 2.0])).unwrap();
    let between = measure(&grey(&[1.0, 1.0]), &grey(&[0.5, 1.0]), 100.0).unwrap().err;
    assert!((flicker(&a, &uncovered, 100.0) / between - 1.0).abs() < 1e-6);
}
