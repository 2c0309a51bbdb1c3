//! Does adaptive sampling keep the energy of `caustic`? Many independent renders of 16 samples a pixel.
//!
//! From the energy of each render that of a uniform one of the same seed is subtracted. Uniform sampling is unbiased, since
//! nothing it sees decides anything, and its samples are the fair ones of the adaptive render: of `balanced` nothing may be
//! left but rounding, and a few hits that depend on the other rays of their packet (see `shade::path`); 0.02 % a render
//! at most. `pooled`, from the same films, and the published method are the negative controls: both must be seen to lose
//! energy by more than 5 standard errors.

mod common;

use common::mean_and_error;
use pmcip::animation::startup::Predictor;
use pmcip::frame::render::{Run, render, render_while};
use pmcip::frame::settings::{Method, Settings};
use pmcip::picture::metrics::luminance;
use pmcip::scene::{self, LoadedScene};
use pmcip_core::sampler::Sampler;
use pmcip_core::sampler::estimate::Estimator;
use rayon::prelude::*;
use std::path::Path;

const SIDE: u32 = 48;
const SPP: u32 = 16;
const RUNS: u32 = 100;
/// Fair samples of a pixel.
const FAIR: u32 = 8;

fn energy<'a>(rgb: impl ExactSizeIterator<Item = &'a [f32; 3]>) -> f64 {
    let pixels = rgb.len() as f64;
    rgb.map(|rgb| luminance(*rgb)).sum::<f64>() / pixels
}

/// Energies of one render, balanced and pooled from one film.
fn balanced_and_pooled(scene: &LoadedScene, settings: &Settings) -> [f64; 2] {
    let mut pooled = vec![[0.0; 3]; (SIDE * SIDE) as usize];
    let mut scratch = vec![Default::default(); Sampler::resolve_scratch(SIDE, SIDE)];
    let mut look = |film: &Sampler<'_>| {
        film.resolve(Estimator::Pooled, &mut scratch, pooled.as_flattened_mut()).unwrap();
        Ok(true)
    };
    let mut none = Predictor::default();
    let frame = {
        let run = Run { threads: Some(1), ..Run::watched(&|_| (), &mut none) };
        render_while(scene, settings, run, &mut look).unwrap()
    };
    assert_eq!(frame.tally.rejected, 0);
    [energy(frame.rgb.iter()), energy(pooled.iter())]
}

/// Relative bias of the energies `values` against those of uniform sampling, and its standard error.
fn bias(values: impl Iterator<Item = f64>, uniform: &[f64]) -> (f64, f64) {
    let differences: Vec<f64> = values.zip(uniform).map(|(value, uniform)| value - uniform).collect();
    let ((mean, error), (truth, _)) = (mean_and_error(&differences), mean_and_error(uniform));
    (mean / truth, error / truth)
}

#[test]
fn adaptive_sampling_keeps_the_energy_of_a_caustic() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/caustic.toml");
    let scene = scene::load(&path).unwrap();
    let settings = |method, spp, seed| {
        let mut settings = Settings::new(&scene, method, Some(spp), Some((SIDE, SIDE)));
        settings.sampler.seed = seed;
        settings
    };
    let plain = |method, spp| {
        let one =
            |seed| energy(render(&scene, &settings(method, spp, seed), Some(1), &|_| ()).unwrap().rgb.iter());
        (0..RUNS).into_par_iter().map(one).collect::<Vec<f64>>()
    };
    let uniform = plain(Method::Uniform, FAIR);
    let adaptive = (0..RUNS).into_par_iter();
    let adaptive: Vec<[f64; 2]> =
        adaptive.map(|seed| balanced_and_pooled(&scene, &settings(Method::Pmc, SPP, seed))).collect();

    let off = adaptive.iter().zip(&uniform).map(|(pair, uniform)| (pair[0] / uniform - 1.0).abs());
    let worst = off.fold(0.0, f64::max);
    println!("balanced: {:.5} % at most", 100.0 * worst);
    assert!(worst < 2e-4, "balanced is not what uniform sampling makes of the fair samples: {worst}");
    let pooled = bias(adaptive.iter().map(|pair| pair[1]), &uniform);
    let paper = bias(plain(Method::Paper, SPP).into_iter(), &uniform);
    for (name, (bias, error)) in [("pooled", pooled), ("paper", paper)] {
        println!("{name}: {:+.3} % ± {:.3}", 100.0 * bias, 100.0 * error);
        assert!(bias < -5.0 * error, "{name} should be seen to lose energy: {bias} ± {error}");
    }
}
