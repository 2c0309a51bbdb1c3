//! How well is the start-up kernel of a frame predicted, and what does that cost?
//!
//! `cargo run --release -p measure -- prediction [SCENE [FIRST..LAST [SIDE [SPP]]]]` prints a Markdown table. The RMSE between
//! predicted and final α is divided by that between the final α of two seeds of the same frame. α is the kernel at
//! equal counts: of what was predicted, and of what the finished frame has seen. For the preset `paper` it is the
//! kernel of the last iteration, carried as it is.

use pmcip::animation::sequence::Range;
use pmcip::animation::startup::Predictor;
use pmcip::frame::render;
use pmcip::frame::settings::{Method, Settings, Startup};
use pmcip::scene::{Animation, LoadedScene};
use pmcip_core::predict::Belief;
use pmcip_core::sampler::Sampler;
use pmcip_core::sampler::kernel::{Criterion, Kernel};

/// A sequence of one seed.
struct Run {
    seed: u32,
    settings: Settings,
    predictor: Predictor,
}

/// One frame of a run.
struct Shown {
    predicted: Option<Vec<f32>>,
    last: Vec<f32>,
    milliseconds: f64,
    miss: f32,
}

/// Prints the table.
pub fn run(arguments: &[String]) {
    let get = |i: usize, default: &str| arguments.get(i).map_or(default.to_owned(), Clone::clone);
    let number = |i, default| get(i, default).parse::<u32>().expect("a whole number");
    let (scene, side, spp) = (get(0, "cornell-anim"), number(2, "96"), number(3, "16"));
    let range: Range = get(1, "1..8").parse().expect("frames as 1..8");
    let path = crate::scene_file(&scene);
    let mut animation = Animation::load(&path).expect("a scene of this project loads");
    let frames = animation.frames().map(|f| (f.first, f.last));
    let frames = range.within(frames).expect("frames of the scene");
    println!("{scene}, {side}×{side}, {spp} samples a pixel\n");
    println!("| start | camera | RMSE ÷ floor | RMSE | floor | ms a frame | miss |");
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    for (method, startup) in [
        (Method::Pmc, Startup::Motion),
        (Method::Pmc, Startup::Homography),
        (Method::Paper, Startup::Motion),
        (Method::Paper, Startup::Homography),
    ] {
        for still in [true, false] {
            animation.seek(*frames.start()).expect("a frame of the scene");
            let first = animation.scene().view;
            let mut runs = [1, 2].map(|seed| {
                let settings = Settings::new(animation.scene(), method, Some(spp), Some((side, side)));
                Run { seed, settings: Settings { startup, ..settings }, predictor: Predictor::default() }
            });
            let (mut errors, mut floors, mut times, mut misss) = (vec![], vec![], vec![], vec![]);
            for frame in frames.clone() {
                animation.seek(frame).expect("a frame of the scene");
                let view = if still { first } else { animation.scene().view };
                let shown = runs.each_mut().map(|run| {
                    run.settings.view = view;
                    run.show(animation.scene(), frame)
                });
                if let Some(predicted) = &shown[0].predicted {
                    errors.push(rmse(predicted, &shown[0].last));
                    floors.push(rmse(&shown[0].last, &shown[1].last));
                    times.push(shown[0].milliseconds);
                    misss.push(f64::from(shown[0].miss));
                }
            }
            let [error, floor, time, miss] = [errors, floors, times, misss].map(|list| mean(&list));
            let (ratio, camera) = (error / floor, if still { "still" } else { "moving" });
            println!(
                "| {method} {startup:?} | {camera} | {ratio:.2} | {error:.2e} | {floor:.2e} | {time:.1} | {miss:.2} |"
            );
        }
    }
}

impl Run {
    fn show(&mut self, scene: &LoadedScene, frame: u32) -> Shown {
        let settings = &mut self.settings;
        (settings.sampler.seed, settings.sampler.frame) = (self.seed, frame);
        let (kernel, epsilon) = (kernel(settings), settings.sampler.epsilon);
        let predictor = &mut self.predictor;
        let mut seen = vec![Belief::NONE; settings.pixels() as usize];
        let mut last = vec![0.0; seen.len()];
        let method = settings.method;
        let run = render::Run { threads: Some(1), ..render::Run::watched(&|_| (), predictor) };
        let done = render::render_while(scene, settings, run, &mut |film: &Sampler| {
            film.beliefs(&mut seen).expect("as large as the film");
            film.alpha(&mut last).expect("as large as the film");
            Ok(true)
        });
        done.expect("a frame renders");
        if method == Method::Pmc {
            kernel.alpha(epsilon, &seen, &mut last);
        }
        let mut alpha = vec![0.0; seen.len()];
        let predicted = self.predictor.prediction().map(|prediction| {
            match method {
                Method::Pmc => kernel.alpha(epsilon, &prediction.beliefs, &mut alpha),
                _ => fill(&prediction.alpha, &mut alpha),
            }
            alpha
        });
        let miss = self.predictor.outlook().map_or(0.0, |outlook| outlook.miss);
        let milliseconds = 1e3 * self.predictor.seconds();
        Shown { predicted, last, milliseconds, miss }
    }
}

/// The kernel at equal counts.
fn kernel(settings: &Settings) -> Kernel {
    let core = &settings.sampler;
    Kernel {
        criterion: Criterion::Sample,
        gamma: core.gamma,
        window: core.window,
        cd_per_unit: core.cd_per_unit,
    }
}

/// A carried kernel as the sampler takes it: the mean where nothing was carried, and a sum of one.
fn fill(carried: &[f32], alpha: &mut [f32]) {
    let known: Vec<f32> = carried.iter().copied().filter(|a| a.is_finite()).collect();
    let sum: f64 = known.iter().map(|a| f64::from(*a)).sum();
    let mean = sum / known.len().max(1) as f64;
    let pixels = carried.len() as f64;
    for (alpha, carried) in alpha.iter_mut().zip(carried) {
        let value = if carried.is_finite() { f64::from(*carried) } else { mean };
        *alpha = (value / (mean * pixels).max(f64::MIN_POSITIVE)) as f32;
    }
}

fn rmse(a: &[f32], b: &[f32]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2));
    (squares.sum::<f64>() / a.len() as f64).sqrt()
}

fn mean(list: &[f64]) -> f64 {
    list.iter().sum::<f64>() / list.len() as f64
}
