//! Energy of the estimators on a heavy-tailed analytic integrand whose mean is known.
//!
//! Every bound is in standard errors of the mean over independent seeds; seeds are fixed, so a pass stays a pass.

use pmcip_core::batch::{Batch8, Integrand, Rgb8};
use pmcip_core::estimate::Estimator;
use pmcip_core::sampler::{Memory, Sampler, Schedule, Sequence, Settings, Workspace};
use wide::f32x8;

const WIDTH: u32 = 20;
const HEIGHT: u32 = 18;
const PIXELS: usize = (WIDTH * HEIGHT) as usize;

/// Mean 1 everywhere: half of it smooth, half from rare bright samples, rarer to the right.
struct Sparks;

impl Integrand for Sparks {
    fn radiance(&mut self, batch: &Batch8) -> Rgb8 {
        let (u, v) = batch.point(1);
        let chance = f32x8::splat(0.1) / (f32x8::ONE + batch.x.floor());
        let spark = u.simd_lt(chance) & (f32x8::HALF / chance);
        let value = v + spark;
        Rgb8 { r: value, g: value, b: value }
    }
}

/// Pictures of one render: one for every estimator asked for.
fn render(settings: Settings, estimators: &[Estimator]) -> Vec<Vec<f64>> {
    let required = Sampler::required(WIDTH, HEIGHT);
    let (mut floats, mut words) = (vec![0.0; required.floats], vec![0; required.words]);
    let mut sampler = Sampler::new(settings, Memory { floats: &mut floats, words: &mut words }).unwrap();
    let (mut batches, mut radiance) = ([Batch8::default(); 64], [Rgb8::default(); 64]);
    let mut work = Workspace::new(&mut batches, &mut radiance).unwrap();
    for samples in Schedule::new(PIXELS as u64, 16, 2, 8) {
        sampler.begin(samples).unwrap();
        for mut job in sampler.jobs() {
            job.render(&mut Sparks, &mut work);
        }
        sampler.end().unwrap();
    }
    let mut scratch = vec![[0.0; 16]; Sampler::resolve_scratch(WIDTH, HEIGHT)];
    let picture = |estimator: &Estimator| {
        let mut rgb = vec![0.0; 3 * PIXELS];
        sampler.resolve(*estimator, &mut scratch, &mut rgb).unwrap();
        rgb.chunks_exact(3).map(|rgb| f64::from(rgb[1])).collect()
    };
    estimators.iter().map(picture).collect()
}

/// Mean and its standard error.
fn mean(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

/// Deviation of the mean energy from the truth in standard errors, for every estimator.
fn energy_deviations(settings: Settings, estimators: &[Estimator], runs: u32) -> Vec<f64> {
    let mut energies = vec![Vec::new(); estimators.len()];
    for seed in 0..runs {
        for (energies, picture) in energies.iter_mut().zip(render(Settings { seed, ..settings }, estimators))
        {
            energies.push(picture.iter().sum::<f64>() / PIXELS as f64);
        }
    }
    let deviation = |energies: &Vec<f64>| {
        let (mean, error) = mean(energies);
        println!("{mean:.5} ± {error:.5}");
        (mean - 1.0) / error
    };
    energies.iter().map(deviation).collect()
}

#[test]
fn difference_and_balanced_keep_the_energy_and_pooled_loses_it() {
    for sequence in [Sequence::Continued, Sequence::Fresh] {
        let settings = Settings { sequence, balance_radius: 4, ..Settings::new(WIDTH, HEIGHT) };
        let estimators = [Estimator::Difference, Estimator::Balanced, Estimator::Pooled];
        let deviations = energy_deviations(settings, &estimators, 1000);
        assert!(deviations[0].abs() < 3.0, "{sequence:?}: difference {}", deviations[0]);
        assert!(deviations[1].abs() < 3.0, "{sequence:?}: balanced {}", deviations[1]);
        assert!(deviations[2] < -5.0, "the control is not biased: {}", deviations[2]);
    }
}

#[test]
fn subframe_keeps_the_energy_with_a_sample_everywhere() {
    let settings = Settings { floor: 1.0, estimator: Estimator::Subframe, ..Settings::new(WIDTH, HEIGHT) };
    let deviations = energy_deviations(settings, &[Estimator::Subframe, Estimator::Pooled], 1000);
    assert!(deviations[0].abs() < 3.0, "subframe {}", deviations[0]);
    assert!(deviations[1] < -3.0, "the control is not biased: {}", deviations[1]);
}

/// Squared deviations of all pixels' means, in squared standard errors, average to 1 where there is no bias.
#[test]
fn difference_is_unbiased_in_every_pixel() {
    let settings = Settings { sequence: Sequence::Fresh, ..Settings::new(WIDTH, HEIGHT) };
    let runs = 600;
    let mut pixels = vec![[Vec::new(), Vec::new()]; PIXELS];
    for seed in 0..runs {
        let pictures = render(Settings { seed, ..settings }, &[Estimator::Difference, Estimator::Pooled]);
        for (kind, picture) in pictures.iter().enumerate() {
            picture.iter().zip(&mut pixels).for_each(|(value, pixel)| pixel[kind].push(*value));
        }
    }
    let score = |kind: usize| {
        let square = |pixel: &[Vec<f64>; 2]| {
            let (mean, error) = mean(&pixel[kind]);
            ((mean - 1.0) / error).powi(2)
        };
        pixels.iter().map(square).sum::<f64>() / PIXELS as f64
    };
    println!("{} {}", score(0), score(1));
    assert!(score(0) < 1.5, "difference: {}", score(0));
    assert!(score(1) > 5.0, "the control is not biased: {}", score(1));
}

/// Where nothing but a constant is seen every estimator is exact.
#[test]
fn uniform_sampling_makes_all_estimators_equal() {
    let settings = Settings { estimator: Estimator::Balanced, ..Settings::uniform(WIDTH, HEIGHT) };
    let pictures = render(settings, &[Estimator::Pooled, Estimator::Difference, Estimator::Balanced]);
    for ((pooled, difference), balanced) in pictures[0].iter().zip(&pictures[1]).zip(&pictures[2]) {
        assert!((pooled - difference).abs() < 1e-5 * pooled && (pooled - balanced).abs() < 1e-5 * pooled);
    }
}
