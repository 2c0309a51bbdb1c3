//! Any radiances, in any settings: the loop never fails, counts are exact, weights and pictures finite.

use super::bytes::{Bytes, Cycle};
use pmcip_core::sampler::batch::{Batch8, Rgb8};
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::kernel::{Criterion, Kernel, Window};
use pmcip_core::sampler::{Memory, Sampler, Sequence, Settings, Workspace};

fn settings(bytes: &mut Bytes) -> Settings {
    let estimators = [Estimator::Pooled, Estimator::Subframe, Estimator::Difference, Estimator::Balanced];
    let [width, height] = [0; 2].map(|_| bytes.below(40) as u32);
    let (choice, tame) = (bytes.byte(), bytes.bit());
    Settings {
        gamma: bytes.float(tame),
        epsilon: bytes.float(tame),
        defensive: bytes.float(tame),
        fair: u32::from(bytes.byte()),
        cd_per_unit: bytes.float(tame),
        window: if choice & 1 == 1 { Window::Pixel } else { Window::Square3 },
        criterion: if choice & 2 == 2 { Criterion::Mean } else { Criterion::Sample },
        sequence: if choice & 4 == 4 { Sequence::Fresh } else { Sequence::Continued },
        estimator: estimators[usize::from(choice >> 6)],
        balance_radius: u32::from(bytes.byte() % 100),
        ..Settings::new(width, height)
    }
}

/// A head of settings and iterations, then radiances that are repeated.
pub fn check(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let settings = settings(&mut bytes);
    let spp = [0; 4].map(|_| bytes.byte());
    let tame = bytes.bit();
    let required = Sampler::required(settings.width, settings.height);
    let (mut floats, mut words) = (vec![0.0; required.floats], vec![0; required.words]);
    let Ok(mut sampler) = Sampler::new(settings, Memory { floats: &mut floats, words: &mut words }) else {
        return;
    };
    let pixels = settings.width as usize * settings.height as usize;
    let (mut batches, mut radiance) = ([Batch8::default(); 9], [Rgb8::default(); 9]);
    let mut work = Workspace::new(&mut batches, &mut radiance).expect("not empty");
    let mut integrand = bytes.cycle(usize::MAX, tame);
    let mut total = 0;
    for spp in spp {
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
    weight(&settings, &mut integrand);
}

fn weight(settings: &Settings, any: &mut Cycle) {
    let kernel = Kernel {
        criterion: settings.criterion,
        gamma: settings.gamma,
        window: settings.window,
        cd_per_unit: settings.cd_per_unit,
    };
    let weight = kernel.weight(any.eight(), any.eight());
    assert!(weight.to_array().iter().all(|w| w.is_finite() && *w >= 0.0));
}

/// The default and the paper's settings, tame radiances and any.
pub fn seeds() -> Vec<Vec<u8>> {
    let words = |values: &[i16]| -> Vec<u8> { values.iter().flat_map(|v| v.to_le_bytes()).collect() };
    let head = |choice: u8, tame: u8| {
        let settings = [words(&[204, 3, 85]), vec![2], words(&[25_600]), vec![96]].concat();
        [&[20, 17, choice, 1][..], &settings, &[1, 3, 2, 4, tame]].concat()
    };
    let ramp: Vec<u8> = (0..90i16).flat_map(|i| (i * 83).to_le_bytes()).collect();
    let any = [f32::NAN, f32::INFINITY, 1e-40, 0.3, -1.0, 1e15, 9e14, 1e-20].map(f32::to_le_bytes).concat();
    [0xc2, 0xc6, 0x01, 0x44]
        .iter()
        .flat_map(|c| [[head(*c, 1), ramp.clone()], [head(*c, 0), any.clone()]].map(|p| p.concat()))
        .collect()
}
