//! What the measuring programs share: many independent renders, and what they cost in error.

use pmcip::frame::render;
use pmcip::frame::settings::{Method, Settings};
use pmcip::picture::frame_io::Picture;
use pmcip::picture::metrics::{self, Metrics};
use pmcip::scene::{self, LoadedScene};
use rayon::prelude::*;

/// A scene of this project, at a side length of its square picture.
pub struct Study {
    /// The scene.
    pub scene: LoadedScene,
    /// Its reference.
    pub reference: Picture,
    side: u32,
}

/// Means over runs.
pub struct Outcome {
    /// Mean squared luminance error over tvi.
    pub err: f64,
    /// The same after a box of 8 × 8 pixels.
    pub err_lowpass: f64,
    /// Mean squared relative error.
    pub rel_mse: f64,
    /// Mean of Σe/Σref and its standard error from the spread of the runs.
    pub bias: (f64, f64),
    /// Mean of the Err that the frames estimate, and the standard deviation of one; not a number without a target.
    pub estimate: (f64, f64),
    /// Samples a pixel.
    pub spp: f64,
}

impl Study {
    /// Loads `scenes/NAME.toml` and renders its reference, uniformly, with a seed no run uses.
    pub fn new(name: &str, side: u32, reference_spp: u32) -> Study {
        let path = crate::scene_file(name);
        let scene = scene::load(&path).expect("a scene of this project loads");
        let mut settings = Settings::new(&scene, Method::Uniform, Some(reference_spp), Some((side, side)));
        settings.sampler.seed = u32::MAX;
        let frame = render::render(&scene, &settings, None, &|_| ()).expect("the reference renders");
        let reference = frame.picture(&settings, &scene);
        Study { scene, reference, side }
    }

    /// The settings of a method at this study's size.
    pub fn settings(&self, method: Method, spp: u32) -> Settings {
        Settings::new(&self.scene, method, Some(spp), Some((self.side, self.side)))
    }

    /// Renders with `runs` seeds, each on one thread, and measures.
    pub fn run(&self, settings: &Settings, runs: u32) -> Outcome {
        let one = |seed: u32| {
            let mut settings = *settings;
            settings.sampler.seed = seed;
            let frame = render::render(&self.scene, &settings, Some(1), &|_| ()).expect("a run renders");
            let picture = frame.picture(&settings, &self.scene);
            let cd_per_unit = f64::from(self.scene.cd_per_unit);
            let metrics = metrics::measure(&picture, &self.reference, cd_per_unit).expect("same size");
            (metrics, frame.estimated_err.unwrap_or(f64::NAN), frame.spp())
        };
        let runs_of: Vec<(Metrics, f64, f64)> = (0..runs).into_par_iter().map(one).collect();
        let all: Vec<Metrics> = runs_of.iter().map(|run| run.0).collect();
        let count = f64::from(runs);
        let estimate = runs_of.iter().map(|run| run.1).sum::<f64>() / count;
        let squares: f64 = runs_of.iter().map(|run| (run.1 - estimate).powi(2)).sum();
        let mean = |of: fn(&Metrics) -> f64| all.iter().map(of).sum::<f64>() / f64::from(runs);
        let bias = mean(|m| m.energy_bias);
        let spread: f64 = all.iter().map(|m| (m.energy_bias - bias).powi(2)).sum();
        let error = (spread / f64::from(runs * (runs - 1).max(1))).sqrt();
        Outcome {
            err: mean(|m| m.err),
            err_lowpass: mean(|m| m.err_lowpass),
            rel_mse: mean(|m| m.rel_mse),
            bias: (bias, error),
            estimate: (estimate, (squares / (count - 1.0).max(1.0)).sqrt()),
            spp: runs_of.iter().map(|run| run.2).sum::<f64>() / count,
        }
    }
}
