//! Does adaptive sampling keep the energy of `caustic`? Many independent renders of 16 samples a pixel.
//!
//! The bias is the mean energy of the renders over that of a uniform reference, minus one; its standard error
//! combines the spread of both over independent seeds. An estimator that claims to be unbiased must lie within 3
//! standard errors of zero (0.3 % that a correct one fails, by seed; seeds are fixed), and the standard error
//! must be at most 0.05 %, so that the claim means something. `pooled` and the published method are the negative
//! controls: both must be seen to lose energy by more than 5 standard errors.

mod common;

use common::mean_and_error;
use pmcip::metrics::luminance;
use pmcip::render::render;
use pmcip::scene::{self, LoadedScene};
use pmcip::settings::{Method, Settings};
use pmcip_core::estimate::Estimator;
use rayon::prelude::*;
use std::path::Path;

const SIDE: u32 = 48;
const SPP: u32 = 16;
const RUNS: u32 = 400;
const REFERENCE_SPP: u32 = 512;
const REFERENCE_RUNS: u32 = 64;

/// Mean luminance of each of `runs` renders, first seed `seed`.
fn energies(scene: &LoadedScene, settings: Settings, seed: u32, runs: u32) -> Vec<f64> {
    let energy = |run: u32| {
        let mut settings = settings;
        settings.sampler.seed = seed + run;
        let frame = render(scene, &settings, Some(1), &|_| ()).unwrap();
        assert_eq!(frame.tally.rejected, 0);
        frame.rgb.iter().map(|rgb| luminance(*rgb)).sum::<f64>() / frame.rgb.len() as f64
    };
    (0..runs).into_par_iter().map(energy).collect()
}

/// Relative bias and its standard error.
fn bias(energies: &[f64], reference: (f64, f64)) -> (f64, f64) {
    let (mean, error) = mean_and_error(energies);
    let relative = (error / mean).hypot(reference.1 / reference.0);
    (mean / reference.0 - 1.0, relative)
}

#[test]
fn adaptive_sampling_keeps_the_energy_of_a_caustic() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/caustic.toml");
    let scene = scene::load(&path).unwrap();
    let settings = |method, spp| Settings::new(&scene, method, Some(spp), Some((SIDE, SIDE)));
    let uniform = settings(Method::Uniform, REFERENCE_SPP);
    let reference = mean_and_error(&energies(&scene, uniform, 1_000_000, REFERENCE_RUNS));
    let of = |estimator: Estimator| {
        let mut settings = settings(Method::Pmc, SPP);
        settings.set_estimator(estimator);
        bias(&energies(&scene, settings, 0, RUNS), reference)
    };

    for estimator in [Estimator::Subframe, Estimator::Difference, Estimator::Balanced] {
        let (bias, error) = of(estimator);
        println!("{estimator:?}: {:+.3} % ± {:.3} %", 100.0 * bias, 100.0 * error);
        assert!(error <= 0.0005, "{estimator:?}: the standard error {error} is too large to tell");
        assert!(bias.abs() <= 3.0 * error, "{estimator:?} is biased: {bias} ± {error}");
    }
    let paper = bias(&energies(&scene, settings(Method::Paper, SPP), 0, RUNS), reference);
    for (name, (bias, error)) in [("pooled", of(Estimator::Pooled)), ("paper", paper)] {
        println!("{name}: {:+.3} % ± {:.3} %", 100.0 * bias, 100.0 * error);
        assert!(bias < -5.0 * error, "{name} should be seen to lose energy: {bias} ± {error}");
    }
}
