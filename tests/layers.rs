//! Layers of a frame's file: which there are, what is in them, and that the picture does not depend on them.

mod program;
mod scene_files;

use pmcip::picture::frame_io::{Picture, read_exr};
use program::{failure, success};
use scene_files::folder;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// A ball under a lamp before nothing, which moves to the right by 0.1 a frame after the first; the camera stands still.
const WALK: &str = "[film]\nwidth = 45\nheight = 34\n[render]\nspp = 4\n[frames]\nfirst = 1\nlast = 4\n\
    [camera]\nfrom = [0, 0, 5]\nat = [0, 0, 0]\nfov = 40\n\
    [[spheres]]\ncenter = [0, 0, 0]\nradius = 1\nsubdivisions = 3\nmaterial = \"m\"\ninterpolation = \"linear\"\n\
    keys = [{ frame = 1, center = [0, 0, 0] }, { frame = 4, center = [0.3, 0, 0] }]\n\
    [[lights]]\ncenter = [0, 4, 2]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\nradiance = [9, 9, 9]\n\
    [materials.m]\ndiffuse = [0.25, 0.5, 0.75]\n";

fn walk() -> TempDir {
    folder(&[("walk.toml", WALK)])
}

fn read(folder: &Path, name: &str) -> Picture {
    read_exr(&folder.join(name)).unwrap()
}

fn names(picture: &Picture) -> Vec<&str> {
    picture.planes.keys().map(String::as_str).collect()
}

/// Three planes as colours.
fn colours(picture: &Picture, layer: &str) -> Vec<[f32; 3]> {
    let [r, g, b] = ["R", "G", "B"].map(|c| &picture.planes[&format!("{layer}.{c}")]);
    r.iter().zip(g).zip(b).map(|((r, g), b)| [*r, *g, *b]).collect()
}

fn sum(rgb: &[[f32; 3]]) -> f64 {
    rgb.as_flattened().iter().map(|v| f64::from(*v)).sum()
}

const STILL: [&str; 17] = [
    "A",
    "albedo.B",
    "albedo.G",
    "albedo.R",
    "balanced.B",
    "balanced.G",
    "balanced.R",
    "count",
    "depth.Z",
    "kernel.weight",
    "normal.X",
    "normal.Y",
    "normal.Z",
    "unbiased.B",
    "unbiased.G",
    "unbiased.R",
    "variance",
];

#[test]
fn layers_are_those_asked_for_and_the_picture_stays_the_same() {
    let walk = walk();
    let path = walk.path();
    for estimator in ["balanced", "guided", "difference"] {
        let render = format!("render walk.toml --quiet --estimator {estimator}");
        success(path, &format!("{render} -o default.exr"));
        success(path, &format!("{render} -o same.exr --layers kernel,variance,count"));
        assert!(fs::read(path.join("default.exr")).unwrap() == fs::read(path.join("same.exr")).unwrap());
        let default = read(path, "default.exr");
        assert_eq!(names(&default), ["count", "kernel.weight", "variance"]);
        assert!(!default.attributes.contains_key("layers"));
        for (layers, wanted) in [
            ("none", vec![]),
            ("all", STILL.to_vec()),
            ("A,depth", vec!["A", "depth.Z"]),
            ("depth,none", vec!["depth.Z"]),
            ("unbiased", vec!["unbiased.B", "unbiased.G", "unbiased.R"]),
        ] {
            success(path, &format!("{render} -o some.exr --layers {layers}"));
            let some = read(path, "some.exr");
            assert_eq!((names(&some), &some.rgb), (wanted, &default.rgb), "{estimator} {layers}");
        }
    }
    assert_eq!(read(path, "some.exr").attributes["layers"], "unbiased");
}

#[test]
fn all_that_is_possible_is_what_the_estimator_has() {
    let walk = walk();
    success(walk.path(), "render walk.toml --quiet --estimator pooled --layers all");
    let picture = read(walk.path(), "walk.exr");
    assert!(
        names(&picture).iter().all(|name| !name.starts_with("unbiased") && !name.starts_with("balanced"))
    );
    assert_eq!(names(&picture).len(), STILL.len() - 6);
}

#[test]
fn layers_say_what_the_scene_shows() {
    let walk = walk();
    success(walk.path(), "render walk.toml --quiet --estimator guided --layers all");
    let picture = read(walk.path(), "walk.exr");
    let (balanced, unbiased) = (colours(&picture, "balanced"), colours(&picture, "unbiased"));
    assert!((sum(&balanced) / sum(&unbiased) - 1.0).abs() < 1e-5 && balanced != unbiased);
    assert!((sum(&picture.rgb) / sum(&unbiased) - 1.0).abs() < 1e-5);
    let (coverage, depth) = (&picture.planes["A"], &picture.planes["depth.Z"]);
    let albedo = colours(&picture, "albedo");
    let middle = 17 * 45 + 22;
    assert_eq!((coverage[middle], albedo[middle]), (1.0, [0.25, 0.5, 0.75]));
    assert!((depth[middle] - 4.0).abs() < 0.01 && (picture.planes["normal.Z"][middle] - 1.0).abs() < 0.02);
    for i in 0..coverage.len() {
        assert!((0.0..=1.0).contains(&coverage[i]));
        // Seen through the edge of the ball, its surface is not nearer than through its middle.
        let is_depth = if coverage[i] > 0.0 { (3.99..5.0).contains(&depth[i]) } else { depth[i] == 1e10 };
        assert!(is_depth, "{} at coverage {}", depth[i], coverage[i]);
        assert!((albedo[i][0] - 0.25 * coverage[i]).abs() < 1e-6, "the border is premultiplied");
    }
    let dark = (0..coverage.len()).filter(|i| coverage[*i] == 0.0 && unbiased[*i] == [0.0; 3]).count();
    let empty = coverage.iter().filter(|coverage| **coverage == 0.0).count();
    assert!(empty - dark < 20, "eight rays overlook little: {dark} of {empty} are dark");
    let covered: f32 = coverage.iter().sum();
    // The ball's outline is a circle of half angle arcsin(1/5).
    let radius = 17.0 / 20f32.to_radians().tan() * (1.0f32 / 5.0).asin().tan();
    assert!((covered / (std::f32::consts::PI * radius * radius) - 1.0).abs() < 0.02, "{covered}");
}

#[test]
fn a_file_with_all_layers_has_the_same_bytes_on_any_number_of_threads() {
    let walk = walk();
    let render = |name: &str, threads: u32| {
        let arguments = format!(
            "render walk.toml --quiet --size 150x117 --estimator guided --layers all --frames 3 -o {name}.exr --threads {threads}"
        );
        success(walk.path(), &arguments);
        fs::read(walk.path().join(format!("{name}.0003.exr"))).unwrap()
    };
    assert!(render("one", 1) == render("three", 3));
}

#[test]
fn motion_is_in_pixels_since_the_frame_before_whatever_was_rendered() {
    let walk = walk();
    let path = walk.path();
    let render = "render walk.toml --quiet --frames .. --startup uniform --layers motion,A";
    success(path, render);
    let moved = |name: &str| {
        let picture = read(path, name);
        let planes = &picture.planes;
        assert_eq!(names(&picture), ["A", "motion.X", "motion.Y"]);
        let pixels = planes["A"].iter().zip(&planes["motion.X"]).zip(&planes["motion.Y"]);
        pixels.map(|((a, x), y)| (*a, *x, *y)).collect::<Vec<_>>()
    };
    assert!(moved("walk.0001.exr").iter().all(|(_, x, y)| (*x, *y) == (0.0, 0.0)), "nothing was before");
    // A tenth of a unit, seen over a distance of four to five units.
    let scale = 17.0 / 20f32.to_radians().tan();
    for (a, x, y) in moved("walk.0003.exr") {
        assert!(y.abs() < 2e-3);
        match a {
            1.0 => assert!((0.1 * scale / 5.0..0.1 * scale / 3.9).contains(&x), "{x}"),
            0.0 => assert!(x.abs() < 1e-3),
            _ => {}
        }
    }
    let before = fs::read(path.join("walk.0003.exr")).unwrap();
    fs::remove_file(path.join("walk.0003.exr")).unwrap();
    success(path, render);
    assert!(before == fs::read(path.join("walk.0003.exr")).unwrap());
    // The camera of the command stands still, too.
    success(path, "render walk.toml --quiet --frames 3 --layers motion,A -o near.exr --look-from 0,0,3");
    let near = moved("near.0003.exr");
    assert!(near[17 * 45 + 22].1 > 0.1 * scale / 3.0 && near[0].1.abs() < 1e-3);
}

#[test]
fn a_frame_without_the_layers_asked_for_is_not_complete() {
    let walk = walk();
    let path = walk.path();
    success(path, "render walk.toml --quiet --frames 1..2");
    let words = "walk.0001.exr is another frame: layers was not set, now it is 'A,depth'";
    failure(path, "render walk.toml --frames 1..2 --layers depth,A", 2, words);
    success(path, "render walk.toml --quiet --frames 1..2 --layers depth,A --overwrite");
    let said = success(path, "render walk.toml --frames 1..2 --layers A,depth");
    assert!(said.contains("2 were there already"), "{said}");
}

#[test]
fn layers_that_cannot_be_are_refused() {
    let walk = walk();
    for (options, words) in [
        ("--layers motion", "--layers motion needs --frames"),
        ("--layers all,motion", "--layers motion needs --frames"),
        ("--layers beauty", "unbiased, balanced, albedo"),
        ("--layers", "--layers <LIST>"),
        ("--layers unbiased --estimator pooled", "the layer 'unbiased' needs the estimator balanced, "),
        ("--layers balanced --sampler paper", "difference or guided, not pooled"),
        ("--layers unbiased --estimator subframe", "not subframe"),
    ] {
        failure(walk.path(), &format!("render walk.toml {options}"), 2, words);
    }
    assert_eq!(fs::read_dir(walk.path()).unwrap().count(), 1);
}
