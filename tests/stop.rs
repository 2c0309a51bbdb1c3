//! Frames that end when they are good enough: by an estimate that is true, the same on any number of threads.

use pmcip::frame::render::{Frame, render};
use pmcip::frame::schedule::Target;
use pmcip::frame::settings::{Method, Settings};
use pmcip::picture::metrics;
use pmcip::scene::{self, LoadedScene};
use std::path::Path;

const SIDE: u32 = 32;

fn load(name: &str) -> LoadedScene {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    scene::load(&scenes.join(name).with_extension("toml")).unwrap()
}

fn settings(scene: &LoadedScene, spp: u32, err: f32, expected_spp: Option<u32>) -> Settings {
    let settings = Settings::new(scene, Method::Pmc, Some(spp), Some((SIDE, SIDE)));
    Settings { target: Some(Target { err, expected_spp }), ..settings }
}

fn frame(scene: &LoadedScene, settings: &Settings, threads: usize) -> Frame {
    render(scene, settings, Some(threads), &|_| ()).unwrap()
}

#[test]
fn a_frame_ends_when_it_is_good_enough_on_any_number_of_threads() {
    let scene = load("cornell");
    let settings = settings(&scene, 256, 2.0, None);
    let one = frame(&scene, &settings, 1);
    assert!(one.estimated_err.unwrap() < 2.0 && (8.0..128.0).contains(&one.spp()), "{}", one.spp());
    assert_eq!(one.spp().fract(), 0.0);
    let three = frame(&scene, &settings, 3);
    assert_eq!((one.rgb, one.count, one.estimated_err), (three.rgb, three.count, three.estimated_err));
}

#[test]
fn what_cannot_be_reached_ends_with_the_samples() {
    let scene = load("cornell");
    let hard = frame(&scene, &settings(&scene, 12, 1e-6, None), 2);
    assert_eq!(hard.spp(), 12.0);
    // What is easily reached still gets enough samples to know.
    let easy = frame(&scene, &settings(&scene, 64, 1e6, None), 2);
    assert_eq!(easy.spp(), 8.0);
    let few = frame(&scene, &settings(&scene, 3, 1e6, None), 2);
    assert_eq!(few.spp(), 3.0);
}

#[test]
fn the_length_of_the_frame_before_sets_the_pace() {
    let scene = load("cornell");
    let paced = frame(&scene, &settings(&scene, 512, 2.0, Some(64)), 2);
    // Iterations of 64/16 samples.
    assert_eq!(paced.spp() % 4.0, 0.0);
    assert!(paced.estimated_err.unwrap() < 2.0);
}

/// The mean of 16 estimates, seeds 0 to 15, against the true Err of the same frames. One estimate spreads by about 15 %
/// on `cornell` and 60 % on `caustic`, its true error as much: four standard errors of the ratio are below 22 % and 85 %,
/// and the estimate itself may be off by 1.3.
#[test]
fn the_estimate_is_the_true_error() {
    for (name, off) in [("cornell", 1.5), ("caustic", 2.0)] {
        let scene = load(name);
        let mut reference = Settings::new(&scene, Method::Uniform, Some(1024), Some((SIDE, SIDE)));
        reference.sampler.seed = u32::MAX;
        let truth = render(&scene, &reference, None, &|_| ()).unwrap().picture(&reference, &scene);
        let (mut estimated, mut err) = (0.0, 0.0);
        for seed in 0..16 {
            let mut settings = settings(&scene, 24, 1e-6, None);
            settings.sampler.seed = seed;
            let frame = render(&scene, &settings, None, &|_| ()).unwrap();
            estimated += frame.estimated_err.unwrap();
            let picture = frame.picture(&settings, &scene);
            err += metrics::measure(&picture, &truth, f64::from(scene.cd_per_unit)).unwrap().err;
        }
        let ratio = estimated / err;
        println!("{name}: estimated ÷ true {ratio:.2}");
        assert!((1.0 / off..off).contains(&ratio), "{name}: {ratio}");
    }
}
