//! The program from outside: files, numbers, exit codes, and one line for everything that can be wrong.

mod program;

use pmcip::picture::frame_io::{Picture, read_exr, write_exr};
use program::{failure, pmcip, success};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Output;
use tempfile::TempDir;

/// A room of one lit wall, in a folder of its own.
fn room() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let obj = "mtllib room.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv -1 1 2\nv 1 1 2\n\
               usemtl wall\nf 1 2 3 4\nusemtl lamp\nf 4 3 6 5\n";
    fs::write(folder.path().join("room.obj"), obj).unwrap();
    fs::write(folder.path().join("room.mtl"), "newmtl wall\nKd 0.5 0.5 0.5\nnewmtl lamp\nKe 3 2 1\n")
        .unwrap();
    folder
}

fn names(folder: &Path) -> Vec<String> {
    let files = fs::read_dir(folder).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = files.collect();
    names.sort();
    names
}

const VIEW: &str = "--size 24x16 --look-from 0,0,5 --look-at 0,0,0";
const SMALL: &str = "--spp 4 --size 24x16 --look-from 0,0,5 --look-at 0,0,0";

#[test]
fn render_writes_both_files_and_says_so() {
    let room = room();
    let said = success(room.path(), &format!("render room.obj {SMALL}"));
    assert!((3..=6).contains(&said.lines().count()), "{said}");
    assert!(said.contains("24×16 pixels") && said.contains("wrote room.exr and room.png"), "{said}");
    assert_eq!(names(room.path()), ["room.exr", "room.mtl", "room.obj", "room.png"]);
    let picture = read_exr(&room.path().join("room.exr")).unwrap();
    assert_eq!((picture.width, picture.height), (24, 16));
    assert_eq!(picture.planes["count"].iter().sum::<f32>(), 24.0 * 16.0 * 4.0);
    assert!((picture.planes["kernel.weight"].iter().sum::<f32>() - 1.0).abs() < 1e-4);
    assert!(picture.rgb.iter().any(|rgb| rgb[0] > 0.1));
    assert_eq!(picture.attributes["seed"], "0");
    assert_eq!(picture.attributes["look_from"], "0.0,0.0,5.0");
    assert_eq!(image::open(room.path().join("room.png")).unwrap().width(), 24);
}

#[test]
fn the_same_seed_makes_the_same_file_on_any_number_of_threads() {
    let room = room();
    // Large enough for more jobs than threads, small tiles at the edges among them.
    let view = "--spp 6 --size 150x117 --look-from 0,0,5 --look-at 0,0,0";
    let render = |name: &str, more: &str| {
        success(room.path(), &format!("render room.obj {view} --quiet -o {name}.exr {more}"));
        fs::read(room.path().join(name).with_extension("exr")).unwrap()
    };
    let one = render("one", "--threads 1");
    assert_eq!(one, render("two", "--threads 2"));
    assert_eq!(one, render("seven", "--threads 7"));
    assert_ne!(one, render("other", "--seed 1"));
}

#[test]
fn gather_says_what_it_shot() {
    let room = room();
    let gather = format!("render room.obj {SMALL} --integrator gather --photons 1000");
    let report: Value =
        serde_json::from_str(&success(room.path(), &format!("{gather} --seed 3 --json"))).unwrap();
    assert_eq!(report["settings"]["integrator"], "gather");
    assert_eq!(report["settings"]["photons"], 1000);
    assert_eq!(report["settings"]["photon_seed"], 3);
    assert!(report["global_photons"].as_u64().unwrap() > 100, "{report}");
    assert_eq!(report["caustic_photons"], 0);
    assert!(report["photon_seconds"].as_f64().unwrap() > 0.0);
    assert_eq!(read_exr(&room.path().join("room.exr")).unwrap().attributes["photons"], "1000");
    assert!(success(room.path(), &gather).contains("0 caustic ones"));
    let paths = success(room.path(), &format!("render room.obj {SMALL} --json"));
    assert!(!paths.contains("photon"), "{paths}");
}

#[test]
fn json_and_quiet_say_what_they_should() {
    let room = room();
    let text = success(room.path(), &format!("render room.obj {SMALL} --json --sampler paper --max-depth 3"));
    let report: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(report["samples"], 24 * 16 * 4);
    assert_eq!(report["rejected"], 0);
    assert_eq!(report["settings"]["estimator"], "pooled");
    assert_eq!(report["settings"]["max_depth"], 3);
    assert_eq!(report["files"][1], "room.png");
    assert!(report["samples_per_second"].as_f64().unwrap() > 0.0);
    assert_eq!(success(room.path(), &format!("render room.obj {SMALL} --quiet")), "");
}

/// The lines of progress on stderr.
fn progress(folder: &Path, arguments: &str) -> (Vec<Value>, String) {
    let Output { status, stdout, stderr } = pmcip(folder, arguments);
    let lines = String::from_utf8(stderr).unwrap();
    assert!(status.success(), "{lines}");
    (
        lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect(),
        String::from_utf8(stdout).unwrap(),
    )
}

#[test]
fn json_tells_how_far_the_render_is() {
    let room = room();
    // A target that cannot be met: the frame takes all of its samples.
    let render = format!("render room.obj {VIEW} --spp 24 --target-err 1e-20 --json");
    let (lines, report) = progress(room.path(), &render);
    let report: Value = serde_json::from_str(&report).unwrap();
    let done: Vec<f64> = lines.iter().map(|line| line["done"].as_f64().unwrap()).collect();
    assert!(lines.len() >= 2 && done[0] == 0.0 && done.is_sorted() && done.ends_with(&[1.0]), "{done:?}");
    assert!(lines.iter().all(|line| line["event"] == "progress" && line.get("frame").is_none()));
    let (first, last) = (&lines[0], &lines[lines.len() - 1]);
    assert!(first["seconds_left"].is_null() && first["estimated_err"].is_null(), "{first}");
    assert_eq!((&last["samples"], &last["spp"]), (&report["samples"], &24.0.into()));
    assert_eq!(last["seconds_left"], 0.0);
    assert_eq!(last["estimated_err"], report["estimated_err"]);
    assert!(last["estimated_err"].as_f64().unwrap() > 0.0);
    // Without a target it is nobody's business but the watcher's: the file does not depend on who watches.
    let plain = |name: &str, more: &str| {
        let said = pmcip(room.path(), &format!("render room.obj {SMALL} -o {name}.exr {more}"));
        assert!(said.status.success());
        fs::read(room.path().join(name).with_extension("exr")).unwrap()
    };
    assert_eq!(plain("a", "--json"), plain("b", "--quiet"));
    failure(room.path(), "render room.obj --quiet --progress json", 2, "cannot be used with");
}

#[test]
fn progress_knows_frames_and_what_was_there() {
    let room = room();
    let scene = "[film]\nwidth = 24\nheight = 16\n[camera]\nfrom = [0, 0, 5]\nat = [0, 0, 0]\nfov = 40\n\
                 [frames]\nfirst = 1\nlast = 4\n[[meshes]]\nfile = \"room.obj\"\n";
    fs::write(room.path().join("room.toml"), scene).unwrap();
    success(room.path(), "render room.toml --spp 4 --frames 2 --quiet");
    let (lines, report) = progress(room.path(), "render room.toml --spp 4 --frames .. --json");
    assert_eq!(report.lines().count(), 4);
    let begins = |line: &&Value| line["samples"] == 0;
    let begun: Vec<f64> = lines.iter().filter(begins).map(|line| line["done"].as_f64().unwrap()).collect();
    assert_eq!(begun, [0.0, 0.3333, 0.6666]);
    let frames: Vec<u64> = lines.iter().filter(begins).map(|line| line["frame"].as_u64().unwrap()).collect();
    assert_eq!(frames, [1, 3, 4]);
    assert_eq!(lines[lines.len() - 1]["done"], 1.0);
    // A film that is complete already leaves nothing to wait for.
    success(room.path(), &format!("render room.obj {SMALL} -o f.exr --film --quiet"));
    let again = format!("render room.obj {SMALL} -o f.exr --film --resume");
    let (lines, _) = progress(room.path(), &format!("{again} --progress json"));
    assert_eq!((&lines[0]["done"], &lines[0]["seconds_left"]), (&1.0.into(), &0.0.into()));
    assert_eq!(lines[0]["samples"], 24 * 16 * 4);
    let said = success(room.path(), &format!("{again} --progress openjd"));
    assert!(said.starts_with("openjd_progress: 100.0\nopenjd_status: 4.0 spp"), "{said}");
}

/// Of what takes long beside `render`: lines from nothing to everything, of as many samples as were to be drawn.
#[test]
fn json_tells_how_far_bakes_references_and_comparisons_are() {
    let room = room();
    let whole = |arguments: &str, spp: f64| {
        let Output { status, stderr, .. } = pmcip(room.path(), arguments);
        let text = String::from_utf8(stderr).unwrap();
        assert!(status.success(), "{text}");
        let lines = text.lines().filter(|line| line.starts_with('{'));
        let lines: Vec<Value> = lines.map(|line| serde_json::from_str(line).unwrap()).collect();
        let done: Vec<f64> = lines.iter().map(|line| line["done"].as_f64().unwrap()).collect();
        assert!(done.first() == Some(&0.0) && done.is_sorted() && done.ends_with(&[1.0]), "{text}");
        assert!(lines.iter().all(|line| line["event"] == "progress" && line.get("frame").is_none()));
        let last = lines[lines.len() - 1].clone();
        assert_eq!((&last["spp"], &last["seconds_left"]), (&spp.into(), &0.0.into()));
        last
    };
    let last = whole(&format!("reference room.obj {VIEW} --spp 24 -o r.exr --json"), 24.0);
    assert!(last["estimated_err"].as_f64().unwrap() > 0.0, "{last}");
    whole("bake room.obj --size 32 --spp 6 -o b.exr --json", 6.0);
    // Reference, warm-up, and two methods.
    let compare =
        format!("compare room.obj {VIEW} --reference-spp 16 --spp 2 --methods uniform,pmc --runs 1 -o c");
    whole(&format!("{compare} --json"), 16.0 + 2.0 + 4.0);
    // The reference is there already: the same whole.
    whole(&format!("{compare} --progress json"), 16.0 + 2.0 + 4.0);
    let said = success(room.path(), "bake room.obj --size 32 --spp 6 -o b.exr --progress openjd");
    assert!(said.starts_with("openjd_progress: 0.0\nopenjd_status: 0.0 spp"), "{said}");
    assert!(said.contains("openjd_progress: 100.0\nopenjd_status: 6.0 spp"), "{said}");
    for command in ["reference room.obj --spp 1 -o r.exr", "bake room.obj -o b.exr", "compare room.obj -o c"]
    {
        failure(room.path(), &format!("{command} --quiet --progress json"), 2, "cannot be used with");
    }
}

#[test]
fn every_sampler_and_estimator_renders() {
    let room = room();
    for sampler in ["pmc", "uniform", "paper"] {
        for estimator in ["balanced", "pooled", "subframe", "difference", "guided"] {
            let options =
                format!("--sampler {sampler} --estimator {estimator} --integrator path --exposure -1");
            success(room.path(), &format!("render room.obj {SMALL} {options}"));
        }
    }
}

#[test]
fn direct_lighting_takes_its_numbers_and_says_them() {
    let room = room();
    let settings = |options: &str| {
        let arguments = format!("render room.obj {SMALL} --json --integrator direct {options}");
        let report: Value = serde_json::from_str(&success(room.path(), &arguments)).unwrap();
        report["settings"].clone()
    };
    let list = settings("");
    assert_eq!(
        (&list["integrator"], &list["light_samples"], &list["bsdf_samples"]),
        (&"direct".into(), &8.into(), &8.into())
    );
    let attributes = read_exr(&room.path().join("room.exr")).unwrap().attributes;
    assert_eq!((attributes["integrator"].as_str(), attributes["light_samples"].as_str()), ("direct", "8"));
    let list = settings("--light-samples 3");
    assert_eq!((&list["light_samples"], &list["bsdf_samples"]), (&3.into(), &3.into()));
    let list = settings("--light-samples 3 --bsdf-samples 1");
    assert_eq!((&list["light_samples"], &list["bsdf_samples"]), (&3.into(), &1.into()));
}

#[test]
fn reference_and_error_go_together() {
    let room = room();
    success(room.path(), &format!("reference room.obj {VIEW} --spp 64 -o sub.exr"));
    assert_eq!(names(room.path()), ["room.mtl", "room.obj", "sub.exr"]);
    success(room.path(), &format!("render room.obj {SMALL}"));
    let report: Value = serde_json::from_str(&success(room.path(), "error room.exr sub.exr --json")).unwrap();
    for measure in ["err", "err_lowpass", "mse", "mse_trimmed", "rel_mse", "rel_mse_trimmed", "oracle_ratio"]
    {
        assert!(report[measure].as_f64().unwrap() > 0.0, "{measure}");
    }
    let (bias, stderr) =
        (report["energy_bias"].as_f64().unwrap(), report["energy_bias_stderr"].as_f64().unwrap());
    assert!(bias.abs() < 6.0 * stderr, "{bias} ± {stderr}");
    let words = success(room.path(), "error sub.exr sub.exr");
    assert!(words.contains("energy bias   +0.0000 %"), "{words}");
}

#[test]
fn info_says_what_is_in_a_scene() {
    let room = room();
    assert!(success(room.path(), "info room.obj").contains("4 triangles, 2 of them shine"));
    let report: Value = serde_json::from_str(&success(room.path(), "info room.obj --json")).unwrap();
    assert_eq!(report["triangles"], 4);
}

#[test]
fn wrong_words_on_the_command_line_get_one_line() {
    let room = room();
    let path = room.path();
    for (arguments, words) in [
        ("render", "<SCENE>"),
        ("paint room.obj", "paint"),
        ("render room.obj --samples 3", "--samples"),
        ("render room.obj --spp 0", "'0' for '--spp <N>'"),
        ("render room.obj --spp many", "'many' for '--spp <N>'"),
        ("render room.obj --size 0x16", "--size <WxH>"),
        ("render room.obj --size 16", "such as 640x480"),
        ("render room.obj --size 99999x16", "--size <WxH>"),
        ("render room.obj --sampler best", "pmc, uniform, paper"),
        ("render room.obj --integrator none", "--integrator"),
        ("render room.obj --integrator direct --photons 9", "--photons needs --integrator gather"),
        ("render room.obj --integrator gather --photons 0", "--photons"),
        ("render room.obj --light-samples 4", "--light-samples needs --integrator direct"),
        ("render room.obj --integrator direct --bsdf-samples 0", "--bsdf-samples <N>"),
        ("render room.obj --estimator best", "balanced, pooled, subframe, difference, guided"),
        ("render room.obj --gamma -1", "0 to 4"),
        ("render room.obj --gamma NaN", "0 to 4"),
        ("render room.obj --max-depth 0", "--max-depth <N>"),
        ("render room.obj --seed -1", "--seed"),
        ("render room.obj --threads 0", "1 to 1024"),
        ("render room.obj --exposure bright", "expected a number"),
        ("render room.obj --look-from 1,2", "three numbers"),
        ("render room.obj --look-at 1,2,inf", "three numbers"),
        ("render room.obj --fov 180", "between 0 and 180"),
        ("render room.obj -o picture.png", "must end in .exr"),
        ("render room.obj --iterations 0", "--iterations <K>"),
        ("reference room.obj --spp 4", "--output <REF.exr>"),
        ("reference room.obj -o a.exr", "--spp <N>"),
        ("error room.exr", "<REF.exr>"),
    ] {
        failure(path, arguments, 2, words);
    }
    assert_eq!(names(path), ["room.mtl", "room.obj"]);
}

#[test]
fn bad_input_is_named_before_work_begins() {
    let room = room();
    let path = room.path();
    let sphere = "center = [0, 0, 0]\nradius = 1\nsubdivisions = 0\nmaterial = \"m\"";
    fs::write(path.join("dark.toml"), format!("[[spheres]]\n{sphere}\n[materials.m]\n")).unwrap();
    fs::create_dir(path.join("folder.exr")).unwrap();
    for (arguments, words) in [
        ("render none.toml", "none.toml"),
        ("info none.obj", "none.obj"),
        ("render dark.toml", "dark.toml: no light"),
        ("render room.obj -o none/a.exr", "none/a.exr: no such file or folder"),
        ("render room.obj -o room.obj/a.exr", "room.obj/a.exr: a part of the path is not a folder"),
        ("render room.obj -o folder.exr", "folder.exr: it is a folder"),
        ("reference room.obj --spp 4 -o none/a.exr", "none/a.exr"),
        ("render room.obj --up 0,0,0", "up"),
        ("render room.obj --look-from 1,1,1 --look-at 1,1,1", "camera"),
        ("error none.exr none.exr", "none.exr: no such file or folder"),
        ("error room.obj room.obj", "room.obj"),
    ] {
        failure(path, arguments, 2, words);
    }
    assert_eq!(names(path), ["dark.toml", "folder.exr", "room.mtl", "room.obj"]);
}

/// A cube with its front outwards, around the origin, and a lamp above it.
const CUBE_AND_LAMP: &str = "mtllib room.mtl\nv -1 -1 -1\nv 1 -1 -1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 1\nv 1 -1 1\n\
    v -1 1 1\nv 1 1 1\nv -1 3 -1\nv 1 3 -1\nv -1 3 1\nv 1 3 1\nusemtl wall\nf 1 3 4 2\nf 5 6 8 7\nf 1 5 7 3\n\
    f 2 4 8 6\nf 1 2 6 5\nf 3 7 8 4\nusemtl lamp\nf 9 10 12 11\n";

#[test]
fn an_obj_without_light_renders_with_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("dark.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let Output { status, stderr, .. } = pmcip(folder.path(), "render dark.obj --size 8x8 --spp 1");
    assert!(status.success());
    assert!(String::from_utf8(stderr).unwrap().starts_with("warning: dark.obj: no light: "));
}

#[test]
fn a_camera_that_sees_no_light_is_named() {
    let room = room();
    let path = room.path();
    fs::write(path.join("cube.obj"), CUBE_AND_LAMP).unwrap();
    let inside = "render cube.obj --light own --size 8x8 --spp 1 --look-from 0,0,0 --look-at 0,0,1";
    failure(path, inside, 2, "the camera at 0,0,0 is inside a wall");
    let away = "render cube.obj --size 8x8 --spp 1 --look-from 0,0,5 --look-at 0,0,9";
    let Output { status, stderr, .. } = pmcip(path, away);
    assert!(status.success());
    assert!(String::from_utf8(stderr).unwrap().starts_with("warning: no light reached the camera"));
    assert!(
        success(path, "render cube.obj --size 8x8 --spp 1 --look-from 0,0,5 --look-at 0,0,0")
            .contains("wrote")
    );
}

#[test]
fn images_that_do_not_fit_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let picture = |name: &str, width: u32, value: f32| {
        let rgb = vec![[value; 3]; width as usize];
        write_exr(&folder.path().join(name), &Picture { width, height: 1, rgb, ..Picture::default() })
            .unwrap();
    };
    picture("small.exr", 2, 1.0);
    picture("large.exr", 3, 1.0);
    picture("broken.exr", 2, f32::NAN);
    failure(folder.path(), "error small.exr large.exr", 2, "the image has 2×1 pixels, the reference 3×1");
    failure(folder.path(), "error broken.exr small.exr", 2, "the image has 2 pixels that are not finite");
    failure(folder.path(), "error small.exr broken.exr", 2, "the reference has 2 pixels that are not finite");
}

#[test]
fn help_is_there_for_everything() {
    let folder = tempfile::tempdir().unwrap();
    for command in ["", "render", "guide", "compare", "reference", "error", "info"] {
        let help = success(folder.path(), &format!("{command} --help"));
        assert!(help.contains("Usage: pmcip"), "{help}");
    }
    assert!(success(folder.path(), "--version").starts_with("pmcip "));
}
