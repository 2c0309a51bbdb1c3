//! Any radiances, in any settings: the loop never fails, counts are exact, weights and pictures finite.

#![no_main]

#[path = "../any.rs"]
mod any;

use any::Any;
use arbitrary::Arbitrary;
use libfuzzer_sys::fuzz_target;
use pmcip_core::sampler::batch::{Batch8, Rgb8};
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::kernel::{Criterion, Kernel, Window};
use pmcip_core::sampler::{Memory, Sampler, Sequence, Settings, Workspace};

#[derive(Arbitrary, Debug)]
struct Input {
    width: u8,
    height: u8,
    spp: [u8; 4],
    gamma: f32,
    epsilon: f32,
    defensive: f32,
    fair: u8,
    cd_per_unit: f32,
    pixel: bool,
    mean: bool,
    fresh: bool,
    estimator: u8,
    radius: u16,
    radiance: Vec<u32>,
}

fn settings(input: &Input) -> Settings {
    let estimators = [Estimator::Pooled, Estimator::Subframe, Estimator::Difference, Estimator::Balanced];
    Settings {
        gamma: input.gamma,
        epsilon: input.epsilon,
        defensive: input.defensive,
        fair: u32::from(input.fair),
        cd_per_unit: input.cd_per_unit,
        window: if input.pixel { Window::Pixel } else { Window::Square3 },
        criterion: if input.mean { Criterion::Mean } else { Criterion::Sample },
        sequence: if input.fresh { Sequence::Fresh } else { Sequence::Continued },
        estimator: estimators[usize::from(input.estimator % 4)],
        balance_radius: u32::from(input.radius % 100),
        ..Settings::new(u32::from(input.width % 40), u32::from(input.height % 40))
    }
}

fuzz_target!(|input: Input| {
    let settings = settings(&input);
    let required = Sampler::required(settings.width, settings.height);
    let (mut floats, mut words) = (vec![0.0; required.floats], vec![0; required.words]);
    let Ok(mut sampler) = Sampler::new(settings, Memory { floats: &mut floats, words: &mut words }) else {
        return;
    };
    let pixels = settings.width as usize * settings.height as usize;
    let (mut batches, mut radiance) = ([Batch8::default(); 9], [Rgb8::default(); 9]);
    let mut work = Workspace::new(&mut batches, &mut radiance).expect("not empty");
    let mut integrand = Any::new(&input.radiance);
    let mut total = 0;
    for spp in input.spp {
        let samples = u64::from(spp % 5) * pixels as u64 + 1;
        sampler.begin(samples).expect("valid samples");
        for mut job in sampler.jobs() {
            job.render(&mut integrand, &mut work);
        }
        let tally = sampler.end().expect("every job was rendered");
        total += samples;
        assert_eq!(tally.samples + tally.rejected, total);
        let mut alpha = vec![0.0; pixels];
        sampler.alpha(&mut alpha).expect("right length");
        assert!(alpha.iter().all(|a| a.is_finite() && *a >= 0.0));
    }
    let mut rgb = vec![0.0; 3 * pixels];
    let mut scratch = vec![[0.0; 16]; Sampler::resolve_scratch(settings.width, settings.height)];
    sampler.resolve(settings.estimator, &mut scratch, &mut rgb).expect("right lengths");
    assert!(rgb.iter().all(|v| v.is_finite()));

    let kernel = Kernel {
        criterion: settings.criterion,
        gamma: settings.gamma,
        window: settings.window,
        cd_per_unit: settings.cd_per_unit,
    };
    let weight = kernel.weight(integrand.eight(), integrand.eight());
    assert!(weight.to_array().iter().all(|w| w.is_finite() && *w >= 0.0));
});
