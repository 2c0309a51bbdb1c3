//! Frames that start from what earlier ones have seen.

use pmcip::animation::motion::Motion;
use pmcip::animation::startup::Predictor;
use pmcip::frame::render::{self, Frame};
use pmcip::frame::settings::{Method, Settings, Startup};
use pmcip::scene::{Animation, LoadedScene};
use pmcip_core::predict::{Belief, Prior, carry};
use pmcip_core::sampler::{Memory, Sampler};
use pmcip_core::tracer::scene::{Light, light};
use std::path::Path;

const SIDE: u32 = 32;

fn scene(name: &str) -> Animation {
    Animation::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name)).unwrap()
}

fn settings(scene: &LoadedScene, method: Method, startup: Startup, spp: u32) -> Settings {
    let mut settings = Settings::new(scene, method, Some(spp), Some((SIDE, SIDE)));
    (settings.startup, settings.max_depth) = (startup, 4);
    settings
}

fn next(scene: &LoadedScene, settings: &Settings, threads: usize, predictor: &mut Predictor) -> Frame {
    render::render_next(scene, settings, Some(threads), &|_| (), predictor).unwrap()
}

/// Renders `frames` of the diffuse box, whose camera moves a little.
fn sequence(method: Method, startup: Startup, frames: u32, seed: u32, threads: usize) -> Vec<(Frame, bool)> {
    let mut animation = scene("cornell.toml");
    let scene = animation.scene().clone();
    let mut settings = settings(&scene, method, startup, 8);
    settings.sampler.seed = seed;
    let mut predictor = Predictor::default();
    animation.seek(0).unwrap();
    let frame = |frame| {
        settings.sampler.frame = frame;
        settings.view.from[0] = scene.view.from[0] + 4.0 * frame as f32;
        let done = next(&scene, &settings, threads, &mut predictor);
        (done, predictor.predicted())
    };
    (0..frames).map(frame).collect()
}

#[test]
fn a_still_camera_keeps_everything() {
    let animation = scene("cornell.toml");
    let scene = animation.scene();
    let pose = scene.pose(scene.view);
    let motion = Motion::new(scene, &scene.view, &pose, (SIDE, SIDE), None).unwrap();
    let positions: Vec<_> = motion.sights.iter().map(|sight| sight.before.unwrap_or([f32::NAN; 2])).collect();
    let before: Vec<u32> = (0..SIDE * SIDE).collect();
    let mut after = vec![u32::MAX; before.len()];
    carry(&before, SIDE as usize, SIDE as usize, &positions, u32::MAX, &mut after).unwrap();
    assert_eq!(after, before);
}

#[test]
fn what_was_hidden_is_not_known() {
    let animation = scene("cornell.toml");
    let mut view = animation.scene().view;
    let mut predictor = Predictor::default();
    let mut settings = settings(animation.scene(), Method::Pmc, Startup::Motion, 4);
    // What the first frame tells is judged by the second one.
    next(animation.scene(), &settings, 1, &mut predictor);
    next(animation.scene(), &settings, 1, &mut predictor);
    view.from[0] += 120.0;
    settings.view = view;
    next(animation.scene(), &settings, 1, &mut predictor);
    let beliefs = &predictor.prediction().expect("most of it was seen before").beliefs;
    let unknown = beliefs.iter().filter(|belief| belief.usable().is_none()).count();
    assert!(unknown > 10 && unknown < beliefs.len() / 2, "{unknown}");
}

#[test]
fn frames_are_predicted_on_any_number_of_threads() {
    for startup in [Startup::Motion, Startup::Homography] {
        let one = sequence(Method::Pmc, startup, 3, 5, 1);
        let three = sequence(Method::Pmc, startup, 3, 5, 3);
        let predicted = [one[0].1, one[1].1, one[2].1];
        // In so small a picture there is nothing to be found again.
        assert_eq!(predicted, [false, false, startup == Startup::Motion]);
        for (a, b) in one.iter().zip(&three) {
            assert!(a.0.rgb == b.0.rgb && a.0.count == b.0.count && a.0.alpha == b.0.alpha);
        }
        assert_eq!(one[2].0.tally.samples + one[2].0.tally.rejected, u64::from(8 * SIDE * SIDE));
    }
}

#[test]
fn the_first_frame_is_the_same_with_and_without() {
    let [with, without] = [Startup::Motion, Startup::Uniform].map(|s| sequence(Method::Pmc, s, 1, 3, 2));
    assert!(with[0].0.rgb == without[0].0.rgb);
}

#[test]
fn a_cut_starts_uniformly() {
    let animation = scene("cornell.toml");
    let mut settings = settings(animation.scene(), Method::Pmc, Startup::Motion, 4);
    let mut predictor = Predictor::default();
    (0..3).for_each(|_| drop(next(animation.scene(), &settings, 1, &mut predictor)));
    assert!(predictor.predicted());
    // From the open side to a view back out of it.
    settings.view.at = [278.0, 273.0, -2000.0];
    next(animation.scene(), &settings, 1, &mut predictor);
    assert!(!predictor.predicted());
    next(animation.scene(), &settings, 1, &mut predictor);
    // Another size is another film.
    settings.sampler.width = SIDE / 2;
    next(animation.scene(), &settings, 1, &mut predictor);
    assert!(!predictor.predicted());
}

/// The table of the lamps, made anew. They are few: there is no tree.
fn list_lights(scene: &mut LoadedScene) {
    scene.lights = vec![Light::default(); light::count(&scene.surfaces, &scene.materials)];
    let used = light::build(&scene.triangles, &scene.surfaces, &scene.materials, &mut scene.lights);
    scene.lights.truncate(used);
    scene.light_nodes.clear();
}

#[test]
fn dark_and_flashing_frames_break_nothing() {
    let animation = scene("cornell.toml");
    for startup in [Startup::Motion, Startup::Homography] {
        for method in [Method::Pmc, Method::Paper] {
            let mut scene = animation.scene().clone();
            let settings = settings(&scene, method, startup, 4);
            let mut predictor = Predictor::default();
            let lamps: Vec<_> = scene.materials.iter().map(|m| m.emission).collect();
            for power in [1.0, 1e4, 0.0, 0.0, 1e-6, 1.0] {
                for (material, lamp) in scene.materials.iter_mut().zip(&lamps) {
                    material.emission = lamp.map(|e| e * power);
                }
                list_lights(&mut scene);
                let frame = next(&scene, &settings, 1, &mut predictor);
                assert!(frame.rgb.as_flattened().iter().all(|x| x.is_finite()));
                let sum: f64 = frame.alpha.iter().map(|a| f64::from(*a)).sum();
                assert!((sum - 1.0).abs() < 1e-4, "{method} {power}: {sum}");
            }
        }
    }
}

/// Means of 60 seeds of the third frame, with and without prediction, are within 4 standard errors of each other: a
/// difference that chance makes once in 16,000 times. The negative control, the paper's preset, loses more.
#[test]
fn a_predicted_frame_keeps_its_energy() {
    const SEEDS: u32 = 60;
    let energy = |method, startup, seed| {
        let frames = sequence(method, startup, 3, seed, 2);
        frames[2].0.rgb.as_flattened().iter().map(|x| f64::from(*x)).sum::<f64>()
    };
    let difference = |method| {
        let each = |seed| {
            let plain = energy(Method::Uniform, Startup::Uniform, 1000 + seed);
            energy(method, Startup::Motion, seed) / plain - 1.0
        };
        let all: Vec<f64> = (0..SEEDS).map(each).collect();
        let mean = all.iter().sum::<f64>() / f64::from(SEEDS);
        let squares: f64 = all.iter().map(|x| (x - mean).powi(2)).sum();
        (mean, (squares / f64::from(SEEDS * (SEEDS - 1))).sqrt())
    };
    let (mean, error) = difference(Method::Pmc);
    assert!(mean.abs() < 4.0 * error, "{mean} ± {error}");
    let (mean, error) = difference(Method::Paper);
    assert!(mean < -4.0 * error, "{mean} ± {error}");
}

#[test]
fn a_prior_must_fit() {
    let core = pmcip_core::sampler::Settings::new(8, 8);
    let required = Sampler::required(8, 8);
    let (mut floats, mut words) = (vec![0.0; required.floats], vec![0; required.words]);
    let memory = Memory { floats: &mut floats, words: &mut words };
    let mut sampler = Sampler::new(core, memory).unwrap();
    let error = sampler.begin_predicted(64, Prior::Beliefs(&[Belief::NONE; 63])).unwrap_err();
    assert_eq!(error, pmcip_core::sampler::Error::Prior);
    sampler.begin_predicted(64, Prior::Alpha(&[f32::NAN; 64])).unwrap();
}
