//! Pictures of other programs in a comparison: rows like all others, without samples.

mod program;
mod scene_files;

use pmcip::picture::frame_io::{Picture, read_exr, write_exr};
use program::{failure, success};
use scene_files::folder;
use serde_json::Value;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

const OBJ: &str = "mtllib room.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv -1 1 2\nv 1 1 2\n\
    usemtl wall\nf 1 2 3 4\nusemtl lamp\nf 4 3 6 5\n";
const MTL: &str = "newmtl wall\nKd 0.5 0.5 0.5\nnewmtl lamp\nKe 3 2 1\n";
const VIEW: &str = "room.obj --size 24x16 --look-from 0,0,5 --look-at 0,0,0";
const QUICK: &str = "--spp 2,4 --runs 1 --methods pmc --reference-spp 64 -o report";

/// A lamp before a wall, and two pictures of it.
fn room() -> TempDir {
    let room = folder(&[("room.obj", OBJ), ("room.mtl", MTL)]);
    success(room.path(), &format!("render {VIEW} --spp 4 --seed 77 --quiet -o own.exr"));
    let own = read_exr(&room.path().join("own.exr")).unwrap();
    let foreign = Picture { planes: Default::default(), attributes: Default::default(), ..own };
    write_exr(&room.path().join("foreign.exr"), &foreign).unwrap();
    room
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

#[test]
fn a_picture_of_another_program_is_a_row_of_every_table() {
    let room = room();
    let path = room.path();
    let others = "--other peer=foreign.exr:0.25 --other told=own.exr:0.5 --other peer=own.exr:2";
    let said = success(path, &format!("compare {VIEW} {QUICK} {others}"));
    let line = said.lines().find(|line| line.starts_with("peer")).unwrap();
    assert!(line.contains(" –    0.250 ") && line.ends_with("± –"), "{said}");

    let report = json(&path.join("report/report.json"));
    let rows = report["rows"].as_array().unwrap();
    let methods: Vec<_> = rows.iter().map(|row| row["method"].as_str().unwrap()).collect();
    assert_eq!(methods, ["uniform", "uniform", "pmc", "pmc", "peer", "peer", "told"]);
    let [peer, same, told] = [4, 5, 6].map(|i| &rows[i]);
    for row in [peer, same, told] {
        assert!(["spp", "iterations", "estimator"].iter().all(|name| row[name].is_null()), "{row}");
        assert_eq!((&row["runs"], &row["seeds"]), (&1.into(), &serde_json::json!([])));
        assert_eq!(row["err"], peer["err"], "the same picture has the same error");
    }
    assert_eq!((&peer["seconds"], &same["seconds"]), (&0.25.into(), &2.0.into()));
    assert!(peer["energy_bias_ci95"].is_null() && told["energy_bias_ci95"].as_f64().unwrap() > 0.0);
    let error = success(path, "error foreign.exr report/reference.exr --json");
    let error: Value = serde_json::from_str(&error).unwrap();
    for measure in ["err", "err_lowpass", "mse", "rel_mse", "rel_mse_trimmed", "energy_bias"] {
        assert_eq!(peer[measure], error[measure], "{measure}");
    }
    let p_eff = 1.0 / (0.25 * peer["err"].as_f64().unwrap());
    assert!((peer["p_eff"].as_f64().unwrap() / p_eff - 1.0).abs() < 1e-9);
    let names = report["others"].as_array().unwrap().iter().map(|other| other["file"].as_str().unwrap());
    assert_eq!(names.collect::<Vec<_>>(), ["foreign.exr", "own.exr", "own.exr"]);
    let ratios = |kind: &str| report["ratios"][kind].as_array().unwrap().clone();
    assert_eq!(ratios("equal_spp").len(), 5);
    assert!(ratios("equal_spp")[2]["err"].is_null() && ratios("equal_spp")[2]["p_eff_gain"].is_null());

    let csv = fs::read_to_string(path.join("report/report.csv")).unwrap();
    let columns = csv.lines().next().unwrap().split(',').count();
    assert!(csv.lines().all(|line| line.split(',').count() == columns), "{csv}");
    assert!(csv.lines().any(|line| line.starts_with("peer,,,,0.25,")), "{csv}");
    let page = fs::read_to_string(path.join("report/report.html")).unwrap();
    assert!(page.contains("</i>peer</td><td>–</td>") && page.contains("<dt>told</dt><dd>own.exr</dd>"));
    assert!(!page.contains("NaN"));
    // Image, difference, and as many crops as places are enlarged.
    for caption in ["</i>peer, 0.25", "</i>peer, 2", "</i>told, 0.5"] {
        let own = page.matches(caption).count();
        assert!(own >= 3, "{caption}: {own}");
    }
}

#[test]
fn at_equal_time_the_baseline_is_read_off_its_curve() {
    let room = room();
    let path = room.path();
    success(path, &format!("compare {VIEW} {QUICK} --quiet"));
    let seconds = json(&path.join("report/report.json"))["rows"][0]["seconds"].as_f64().unwrap();
    // Times are of the moment: a picture at a time that uniform needs now has a ratio, unless the machine has changed.
    let many = (-6..=6).map(|k| format!("--other peer=foreign.exr:{}", seconds * 2f64.powi(k)));
    let many = many.collect::<Vec<_>>().join(" ");
    success(path, &format!("compare {VIEW} {QUICK} --quiet {many}"));
    let report = json(&path.join("report/report.json"));
    let ratios = report["ratios"]["equal_time"].as_array().unwrap();
    let known = |ratio: &&Value| ratio["method"] == "peer" && ratio["err"].is_f64();
    assert!(ratios.iter().filter(known).count() > 0, "{ratios:?}");
}

#[test]
fn pictures_that_do_not_fit_are_refused_before_work_begins() {
    let room = room();
    let path = room.path();
    let mut broken = read_exr(&path.join("foreign.exr")).unwrap();
    broken.rgb[3][0] = f32::NAN;
    write_exr(&path.join("broken.exr"), &broken).unwrap();
    let small = Picture { width: 2, height: 1, rgb: vec![[1.0; 3]; 2], ..Picture::default() };
    write_exr(&path.join("small.exr"), &small).unwrap();
    for (options, words) in [
        ("--other peer=small.exr:1", "small.exr: it has 2×1 pixels, not 24×16"),
        ("--other peer=broken.exr:1", "broken.exr: it has 1 pixels that are not finite"),
        ("--other peer=none.exr:1", "none.exr: no such file or folder"),
        ("--other peer=foreign.exr", "expected NAME=PICTURE.exr:SECONDS"),
        ("--other pmc=foreign.exr:1", "'pmc' is the name of a method"),
        ("--other peer=foreign.exr:1 --frames 1..2", "--frames"),
    ] {
        failure(path, &format!("compare {VIEW} {QUICK} {options}"), 2, words);
    }
    assert!(!path.join("report/reference.exr").exists());
}
