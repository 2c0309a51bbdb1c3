//! `merge`: films rendered apart are one frame.

mod program;

use pmcip::picture::frame_io::{Picture, read_exr};
use program::{failure, success};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

const FRAME: &str = "render room.toml --spp 16 --quiet --film";

/// A folder with the films of four seeds.
fn films(more: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let scene = "[film]\nwidth = 40\nheight = 33\n[camera]\nfrom = [0, 0, 5]\nat = [0, 0, 0]\nfov = 40\n\
        [[spheres]]\ncenter = [0, 0, 0]\nradius = 1\nsubdivisions = 2\nmaterial = \"m\"\n\
        [[lights]]\ncenter = [0, 4, 2]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\nradiance = [9, 9, 9]\n[materials.m]\n";
    fs::write(folder.path().join("room.toml"), scene).unwrap();
    for seed in 0..4 {
        success(folder.path(), &format!("{FRAME} {more} --seed {seed} -o s{seed}.exr"));
    }
    folder
}

fn read(folder: &Path, name: &str) -> Picture {
    read_exr(&folder.join(name)).unwrap()
}

fn energy(picture: &Picture) -> f64 {
    picture.rgb.iter().map(|rgb| f64::from(rgb[1])).sum()
}

/// Counts add up, means are weighed by them, to rounding in single precision; in any order, and in steps, the same bits.
#[test]
fn a_merged_frame_is_that_of_all_samples() {
    let folder = films("--estimator pooled");
    let here = folder.path();
    success(here, "merge s0.film s1.film s2.film s3.film -o all.exr");
    success(here, "merge s2.film s3.film s0.film s1.film -o turned.exr");
    for ending in ["exr", "film", "png"] {
        let [a, b] = ["all", "turned"].map(|name| fs::read(here.join(name).with_extension(ending)).unwrap());
        assert!(a == b, "{ending}");
    }
    let (all, parts) = (read(here, "all.exr"), [0, 1, 2, 3].map(|seed| read(here, &format!("s{seed}.exr"))));
    assert_eq!(all.attributes["merged_seeds"], "0,1,2,3");
    for i in 0..40 * 33 {
        let counts = parts.each_ref().map(|part| f64::from(part.planes["count"][i]));
        let n: f64 = counts.iter().sum();
        assert_eq!(f64::from(all.planes["count"][i]), n);
        let means = parts.each_ref().map(|part| f64::from(part.rgb[i][1]));
        let mean = means.iter().zip(counts).map(|(mean, n)| mean * n).sum::<f64>() / n;
        assert!((f64::from(all.rgb[i][1]) - mean).abs() <= 1e-6 * mean, "pixel {i}");
    }
    // Two and two: the means are the same but for their rounding.
    success(here, "merge s0.film s1.film -o a.exr");
    success(here, "merge s2.film s3.film -o b.exr");
    success(here, "merge b.film a.film -o steps.exr");
    let steps = read(here, "steps.exr");
    assert_eq!(steps.planes["count"], all.planes["count"]);
    assert!(steps.rgb.iter().zip(&all.rgb).all(|(a, b)| (a[1] - b[1]).abs() <= 1e-6 * b[1].abs()));
    // The variance is about a quarter of one part's.
    let variance = |picture: &Picture| picture.planes["variance"].iter().map(|v| f64::from(*v)).sum::<f64>();
    let ratio = variance(&all) / parts.iter().map(variance).sum::<f64>() * 4.0;
    assert!((0.15..0.4).contains(&ratio), "{ratio}");
}

/// What estimators hold of the energy they hold of the merged film: `difference` has the mean of the parts' to rounding, and
/// `balanced` the same energy as that.
#[test]
fn a_merged_frame_has_the_parts_energy() {
    let folder = films("--estimator difference");
    let here = folder.path();
    success(here, "merge s0.film s1.film s2.film s3.film -o all.exr");
    let mean = (0..4).map(|seed| energy(&read(here, &format!("s{seed}.exr")))).sum::<f64>() / 4.0;
    let all = energy(&read(here, "all.exr"));
    assert!((all / mean - 1.0).abs() < 1e-6, "{all} {mean}");
    let folder = films("--estimator guided --layers unbiased,balanced");
    let here = folder.path();
    let report = success(here, "merge s0.film s1.film s2.film s3.film -o all.exr --json");
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    assert_eq!(report["seeds"], serde_json::json!([0, 1, 2, 3]));
    assert_eq!(report["samples"], 4 * 16 * 40 * 33);
    let balanced = energy(&read(here, "all.exr"));
    assert!((balanced / all - 1.0).abs() < 1e-4, "{balanced} {all}");
    // Filtered with the scene: no samples more, and the energy stays.
    let filtered = success(
        here,
        "render room.toml --spp 16 --estimator guided --layers unbiased,balanced --resume -o all.exr --json",
    );
    let filtered: serde_json::Value = serde_json::from_str(&filtered).unwrap();
    assert_eq!(filtered["samples"], 4 * 16 * 40 * 33);
    assert!(here.join("all.film").exists(), "the merged film is lost");
    let guided = energy(&read(here, "all.exr"));
    assert!((guided / all - 1.0).abs() < 1e-4, "{guided} {all}");
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let folder = films("--estimator pooled");
    let here = folder.path();
    success(here, "render room.toml --quiet --film --estimator pooled --spp 8 --seed 9 -o other.exr");
    failure(here, "merge s0.film other.film -o m.exr", 2, "other.film is of another frame than s0.film: ");
    failure(here, "merge s0.film s1.film s0.film -o m.exr", 2, "have samples of the same seed");
    success(here, "merge s0.film s1.film -o a.exr");
    failure(here, "merge a.film s1.film -o m.exr", 2, "s1.film and a.film have samples of the same seed");
    failure(here, "merge s0.film room.toml -o m.exr", 2, "room.toml: it is no film file");
    failure(here, "merge s0.film none.film -o m.exr", 2, "none.film: no such file");
    let mut damaged = fs::read(here.join("s1.film")).unwrap();
    let last = damaged.len() - 1;
    damaged[last] ^= 1;
    fs::write(here.join("s1.film"), damaged).unwrap();
    failure(
        here,
        "merge s0.film s1.film -o m.exr",
        2,
        "s1.film: not a saved film of this version, or damaged",
    );
    // A scene that has changed.
    let scene = fs::read_to_string(here.join("room.toml")).unwrap().replace("radius = 1\n", "radius = 1.1\n");
    fs::write(here.join("room.toml"), scene).unwrap();
    success(here, &format!("{FRAME} --estimator pooled --seed 7 -o s7.exr"));
    failure(here, "merge s0.film s7.film -o m.exr", 2, "the scene or the program was another");
    assert!(!here.join("m.exr").exists() && !here.join("m.film").exists());
}
