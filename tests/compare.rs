//! The comparison from outside: its files, its numbers, and when the reference is used again.

use pmcip::picture::frame_io::{Picture, read_exr, write_exr};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

/// A lamp before a wall, in a folder of its own.
fn room() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let obj = "mtllib room.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv -1 1 2\nv 1 1 2\n\
               usemtl wall\nf 1 2 3 4\nusemtl lamp\nf 4 3 6 5\n";
    fs::write(folder.path().join("room.obj"), obj).unwrap();
    paint(folder.path(), 0.5);
    folder
}

/// Gives the wall another grey.
fn paint(folder: &Path, grey: f32) {
    let text = format!("newmtl wall\nKd {grey} {grey} {grey}\nnewmtl lamp\nKe 3 2 1\n");
    fs::write(folder.join("room.mtl"), text).unwrap();
}

/// Compares in `folder`, with further arguments divided by spaces.
fn compare(folder: &Path, more: &str) -> Output {
    let view = "compare room.obj --size 24x16 --look-from 0,0,5 --look-at 0,0,0";
    let mut program = Command::new(env!("CARGO_BIN_EXE_pmcip"));
    program.current_dir(folder).args(view.split(' ')).args(more.split_whitespace()).output().unwrap()
}

/// What a successful comparison said on stdout and stderr.
#[track_caller]
fn success(folder: &Path, more: &str) -> (String, String) {
    let Output { status, stdout, stderr } = compare(folder, more);
    let stderr = String::from_utf8(stderr).unwrap();
    assert!(status.success(), "{more}: {stderr}");
    (String::from_utf8(stdout).unwrap(), stderr)
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

const QUICK: &str = "--spp 2,4 --runs 2 --reference-spp 64 -o report";

/// The columns that everybody may rely on, but for words.
const NUMBERS: [&str; 13] = [
    "spp",
    "iterations",
    "seconds",
    "err",
    "p_eff",
    "err_lowpass",
    "mse",
    "rel_mse",
    "rel_mse_trimmed",
    "energy_bias",
    "energy_bias_stderr",
    "energy_bias_ci95",
    "runs",
];

#[test]
fn a_report_has_its_files_and_its_numbers() {
    let room = room();
    let (said, _) = success(room.path(), QUICK);
    assert!(said.contains("equal time") && said.contains("report/report.html"), "{said}");
    let folder = room.path().join("report");
    let mut names: Vec<_> = fs::read_dir(&folder).unwrap().map(|file| file.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["reference.exr", "report.csv", "report.html", "report.json"]);

    let report = json(&folder.join("report.json"));
    let rows = report["rows"].as_array().unwrap();
    let methods: Vec<_> = rows.iter().map(|row| row["method"].as_str().unwrap()).collect();
    assert_eq!(methods, ["uniform", "uniform", "paper", "paper", "pmc", "pmc"]);
    for row in rows {
        for name in NUMBERS {
            assert!(row[name].as_f64().is_some_and(f64::is_finite), "{name}: {row}");
        }
        let number = |name: &str| row[name].as_f64().unwrap();
        assert!(number("err") > 0.0 && number("rel_mse_trimmed") < number("rel_mse"), "{row}");
        assert!((number("p_eff") * number("seconds") * number("err") - 1.0).abs() < 1e-9, "{row}");
        assert_eq!((number("runs"), row["seeds"].as_array().unwrap().len()), (2.0, 2));
        assert!(row["stderr"]["err"].as_f64().unwrap() > 0.0, "{row}");
        let reference = report["reference"]["noise_energy"].as_f64().unwrap();
        assert!(number("energy_bias_stderr") > reference * (1.0 + number("energy_bias")) * 0.999, "{row}");
        let t = number("energy_bias_ci95") / number("energy_bias_stderr");
        // Two runs have one degree of freedom, a reference of eight parts seven.
        assert!((2.36..12.71).contains(&t), "{t}");
    }
    let reference = &report["reference"];
    let number = |name: &str| reference[name].as_f64().unwrap();
    assert_eq!(reference["noise_source"], "parts");
    assert!((number("noise_energy_ci95") / number("noise_energy") - 2.3646).abs() < 1e-4);
    assert_eq!((&rows[0]["estimator"], &rows[4]["estimator"]), (&"pooled".into(), &"balanced".into()));
    assert!(report["oracle_ratio"].as_f64().unwrap() >= 1.0);
    assert!(report["oracle_ratio_equal_rays"].as_f64().unwrap() >= 1.0);
    assert_eq!(report["settings"]["width"], 24);
    assert_eq!(report["methods"]["paper"]["gamma"], 1.0);
    assert!(!report["machine"]["cpu"].as_str().unwrap().is_empty());
}

#[test]
fn ratios_are_those_of_the_rows() {
    let room = room();
    let (said, _) = success(room.path(), &format!("{QUICK} --json --methods pmc"));
    let report: Value = serde_json::from_str(&said).unwrap();
    assert_eq!(report, json(&room.path().join("report/report.json")));
    let (rows, same) = (&report["rows"], &report["ratios"]["equal_spp"]);
    assert_eq!((rows[1]["method"].as_str(), rows[3]["method"].as_str()), (Some("uniform"), Some("pmc")));
    for measure in ["err", "err_lowpass", "rel_mse"] {
        let number = |row: &Value| row[measure].as_f64().unwrap();
        assert!((number(&same[1]) - number(&rows[1]) / number(&rows[3])).abs() < 1e-9, "{measure}");
    }
    assert_eq!(report["ratios"]["equal_time"].as_array().unwrap().len(), 2);
}

#[test]
fn the_page_stands_alone_and_shows_every_method() {
    let room = room();
    success(room.path(), &format!("{QUICK} --methods pmc,pmc:gamma=0.5+difference --quiet"));
    let page = fs::read_to_string(room.path().join("report/report.html")).unwrap();
    assert_eq!(page.matches("<svg").count(), 6);
    // The reference, and five pictures for each of three methods.
    assert!(page.matches("data:image/png;base64,").count() >= 16);
    assert!(page.contains("pmc:gamma=0.5+difference"));
    let addresses = page.matches("http").count() - page.matches("http://www.w3.org/2000/svg").count();
    assert_eq!(addresses, 0, "the page must not load anything");
    let table = fs::read_to_string(room.path().join("report/report.csv")).unwrap();
    let columns: Vec<usize> = table.lines().map(|line| line.split(',').count()).collect();
    assert_eq!((columns.len(), columns.iter().min()), (7, columns.iter().max()));
}

#[test]
fn the_reference_is_rendered_once_for_the_same_scene() {
    let room = room();
    let path = room.path();
    let reference = || fs::metadata(path.join("report/reference.exr")).unwrap().modified().unwrap();
    let said = |more: &str| {
        let options = "--spp 2 --runs 1 --methods uniform --reference-spp 64 -o report";
        success(path, &format!("{options} {more}")).1
    };
    assert!(said("").contains("renders the reference with 64 samples a pixel: there is none yet"));
    let first = reference();
    assert!(said("").contains("uses the reference"));
    assert_eq!(reference(), first);
    assert!(said("--max-depth 2").contains("shows another scene, size, integrator, depth or camera"));
    assert!(said("").contains("shows another scene, size, integrator, depth or camera"));
    assert!(said("--integrator direct").contains("shows another scene, size, integrator, depth or camera"));
    assert!(
        said("--integrator direct --light-samples 2").contains("uses the reference"),
        "it shows the same"
    );
    for photons in [100, 200] {
        let other = said(&format!("--integrator gather --photons {photons}"));
        assert!(other.contains("shows another scene"), "the map is part of the picture: {other}");
    }
    paint(path, 0.25);
    assert!(said("").contains("shows another scene, size, integrator, depth or camera"));
    assert!(said("").contains("uses the reference"));
    fs::write(path.join("report/reference.exr"), "half a file").unwrap();
    assert!(said("").contains("cannot read"));
    let picture = read_exr(&path.join("report/reference.exr")).unwrap();
    assert_eq!((picture.attributes["spp"].as_str(), picture.attributes["scene_hash"].len()), ("64", 64));
}

#[test]
fn another_number_of_samples_makes_another_reference() {
    let room = room();
    let said = |spp: u32| {
        let options = format!("--spp 2 --runs 1 --methods uniform --reference-spp {spp} -o report");
        success(room.path(), &options).1
    };
    said(16);
    assert!(said(32).contains("has 16 samples a pixel, not 32"));
}

#[test]
fn any_picture_of_the_right_size_can_be_the_reference() {
    let room = room();
    let path = room.path();
    for (name, width) in [("fits.exr", 24), ("narrow.exr", 12)] {
        let rgb = vec![[0.3; 3]; width as usize * 16];
        write_exr(&path.join(name), &Picture { width, height: 16, rgb, ..Picture::default() }).unwrap();
    }
    let options = "--spp 2 --runs 1 -o report --reference";
    success(path, &format!("{options} fits.exr"));
    let report = json(&path.join("report/report.json"));
    assert!(report["oracle_ratio"].is_null());
    assert!(report["reference"]["noise_source"].is_null(), "nothing tells its noise");
    let page = fs::read_to_string(path.join("report/report.html")).unwrap();
    assert!(page.contains("its own noise is unknown, and no ± contains it"));
    // A single run is known by the variance of its pixels, as if that were exact.
    let number = |name: &str| report["rows"][0][name].as_f64().unwrap();
    assert!((number("energy_bias_ci95") / number("energy_bias_stderr") - 1.96).abs() < 1e-4);
    assert!(!path.join("report/reference.exr").exists());
    for (more, words) in [
        (&*format!("{options} narrow.exr"), "the reference 12×16"),
        (&*format!("{options} none.exr"), "none.exr: no such file"),
        ("-o report --methods best", "expected one of pmc, uniform, paper"),
        ("-o report --methods pmc:best", "'best' is no option"),
        ("-o report --spp 4,none", "'none'"),
        ("-o report --runs 0", "--runs <R>"),
        ("-o room.obj", "room.obj: it is a file, not a folder"),
        ("", "--output <REPORT_DIR>"),
    ] {
        let Output { status, stderr, .. } = compare(path, more);
        let stderr = String::from_utf8(stderr).unwrap();
        assert_eq!(status.code(), Some(2), "{more}: {stderr}");
        assert!(stderr.lines().count() == 1 && stderr.contains(words), "{more}: {stderr}");
    }
}

#[test]
fn samples_that_are_no_numbers_are_said() {
    let folder = tempfile::tempdir().unwrap();
    // A lamp seen in a part of the picture is brighter than a sample may be.
    let scene = "[film]\nwidth = 16\nheight = 16\n[camera]\nfrom = [0, 0, 5]\nat = [0, 0, 0]\nfov = 40\n\
        [[lights]]\ncenter = [0, 0, 0]\nedge_u = [1, 0, 0]\nedge_v = [0, 1, 0]\nradiance = [1e17, 1e17, 1e17]\n\
        [[lights]]\ncenter = [1, 1, 0]\nedge_u = [0.5, 0, 0]\nedge_v = [0, 0.5, 0]\nradiance = [1, 1, 1]\n";
    fs::write(folder.path().join("s.toml"), scene).unwrap();
    let compare = "compare s.toml --spp 4 --methods pmc --runs 1 --reference-spp 16 -o report --quiet";
    let mut program = Command::new(env!("CARGO_BIN_EXE_pmcip"));
    let Output { status, stderr, .. } =
        program.current_dir(folder.path()).args(compare.split(' ')).output().unwrap();
    let said = String::from_utf8(stderr).unwrap();
    assert_eq!(status.code(), Some(3), "{said}");
    assert!(said.contains("samples") && said.contains("left out of the picture"), "{said}");
    assert!(folder.path().join("report/report.json").exists());
}
