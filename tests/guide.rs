//! The guide: any picture, put on the energy of the fair samples.

use pmcip_core::sampler::batch::{Batch8, Integrand, Rgb8};
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::guide::{Band, Feature, Filter, Pictures};
use pmcip_core::sampler::{Error, Memory, Sampler, Schedule, Settings, Workspace};
use proptest::prelude::*;
use wide::f32x8;

/// Rare bright samples on a slope, black in one corner.
struct Sparks;

impl Integrand for Sparks {
    fn radiance(&mut self, batch: &Batch8) -> Rgb8 {
        let (u, v) = batch.point(1);
        let lit = (batch.x + batch.y).simd_gt(f32x8::splat(20.0));
        let spark = u.simd_lt(f32x8::splat(0.05)) & f32x8::splat(20.0);
        Rgb8 { r: lit & (spark + batch.x), g: lit & spark, b: lit & (v * batch.y) }
    }
}

/// Renders a film of [`Sparks`] and hands it to `look`.
fn film<T>(settings: Settings, look: impl FnOnce(&Sampler<'_>) -> T) -> T {
    film_of(&mut Sparks, settings, look)
}

fn film_of<T>(integrand: &mut impl Integrand, settings: Settings, look: impl FnOnce(&Sampler<'_>) -> T) -> T {
    let required = Sampler::required(settings.width, settings.height);
    let (mut floats, mut words) = (vec![0.0; required.floats], vec![0; required.words]);
    let memory = Memory { floats: &mut floats, words: &mut words };
    let mut sampler = Sampler::new(settings, memory).unwrap();
    for samples in Schedule::new(u64::from(settings.width) * u64::from(settings.height), 8, 2, 4) {
        sampler.begin(samples).unwrap();
        let (mut batches, mut radiance) = (vec![Batch8::default(); 9], vec![Rgb8::default(); 9]);
        let mut work = Workspace::new(&mut batches, &mut radiance).unwrap();
        sampler.jobs().for_each(|mut job| {
            job.render(integrand, &mut work);
        });
        sampler.end().unwrap();
    }
    look(&sampler)
}

fn resolved(sampler: &Sampler<'_>, estimator: Estimator) -> Vec<[f32; 3]> {
    let (width, height) = (sampler.settings().width, sampler.settings().height);
    let mut scratch = vec![[7.0; 16]; Sampler::resolve_scratch(width, height)];
    let mut rgb = vec![[0.0; 3]; width as usize * height as usize];
    sampler.resolve(estimator, &mut scratch, rgb.as_flattened_mut()).unwrap();
    rgb
}

fn guided(sampler: &Sampler<'_>, guide: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let (width, height) = (sampler.settings().width, sampler.settings().height);
    let mut scratch = vec![[7.0; 16]; Sampler::resolve_scratch(width, height)];
    let mut rgb = vec![[0.0; 3]; guide.len()];
    sampler.resolve_guided(guide, &mut scratch, &mut rgb).unwrap();
    rgb
}

/// The same from pictures of the film alone.
fn restored(sampler: &Sampler<'_>, guide: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let &Settings { width, height, balance_radius, .. } = sampler.settings();
    let (unbiased, mean) = (resolved(sampler, Estimator::Difference), resolved(sampler, Estimator::Pooled));
    let pictures = Pictures { width, height, balance_radius, guide, unbiased: &unbiased, mean: &mean };
    let mut scratch = vec![[7.0; 16]; Sampler::resolve_scratch(width, height)];
    let mut rgb = vec![[0.0; 3]; guide.len()];
    pictures.restore(&mut scratch, &mut rgb).unwrap();
    rgb
}

fn sum(picture: &[[f32; 3]], c: usize) -> f64 {
    picture.iter().map(|rgb| f64::from(rgb[c])).sum()
}

fn magnitude(picture: &[[f32; 3]], c: usize) -> f64 {
    picture.iter().map(|rgb| f64::from(rgb[c].abs())).sum()
}

/// That `guide` comes back with the energy of the fair samples, and finite.
fn check_energy(sampler: &Sampler<'_>, guide: &[[f32; 3]]) {
    let fair = resolved(sampler, Estimator::Difference);
    let picture = guided(sampler, guide);
    assert_eq!(picture, restored(sampler, guide), "the film and its pictures give the same");
    assert!(picture.as_flattened().iter().all(|v| v.is_finite()));
    let usable = |rgb: &[f32; 3]| rgb.iter().all(|v| v.abs() <= 1e15);
    let counted: Vec<[f32; 3]> = guide.iter().copied().filter(usable).collect();
    for c in 0..3 {
        let scale = magnitude(&fair, c) + magnitude(&counted, c) + magnitude(&picture, c);
        let off = sum(&picture, c) - sum(&fair, c);
        assert!(off.abs() <= 1e-5 * scale, "energy is off by {off} of {scale}");
    }
}

#[test]
fn the_mean_as_guide_is_the_balanced_estimator() {
    for (width, height) in [(1, 1), (37, 21), (64, 48)] {
        film(Settings { seed: 3, ..Settings::new(width, height) }, |sampler| {
            let mean = resolved(sampler, Estimator::Pooled);
            assert_eq!(guided(sampler, &mean), resolved(sampler, Estimator::Balanced));
            let missing = vec![[f32::NAN, 1.0, f32::INFINITY]; mean.len()];
            assert_eq!(guided(sampler, &missing), resolved(sampler, Estimator::Balanced));
        });
    }
}

#[test]
fn black_negative_and_huge_guides_keep_the_energy() {
    film(Settings::new(45, 30), |sampler| {
        for value in [0.0, -1.0, 1e15, f32::MAX, 1e-30] {
            check_energy(sampler, &[[value; 3]; 45 * 30]);
            check_energy(sampler, &[[value, 0.0, -value]; 45 * 30]);
        }
    });
}

#[test]
fn a_guide_of_another_size_is_refused() {
    film(Settings::new(9, 9), |sampler| {
        let mut scratch = vec![[0.0; 16]; Sampler::resolve_scratch(9, 9)];
        let mut out = [[0.0; 3]; 81];
        let resolve = |guide: &[[f32; 3]], scratch: &mut [_], out: &mut [_]| {
            sampler.resolve_guided(guide, scratch, out).unwrap_err()
        };
        assert_eq!(resolve(&[[0.0; 3]; 80], &mut scratch, &mut out), Error::Guide);
        assert_eq!(resolve(&[[0.0; 3]; 81], &mut scratch, &mut out[1..]), Error::Output);
        assert_eq!(resolve(&[[0.0; 3]; 81], &mut [], &mut out), Error::Scratch);
    });
    let pooled = Settings { estimator: Estimator::Pooled, ..Settings::new(9, 9) };
    film(pooled, |sampler| {
        let mut scratch = vec![[0.0; 16]; Sampler::resolve_scratch(9, 9)];
        let refused = sampler.resolve_guided(&[[0.0; 3]; 81], &mut scratch, &mut [[0.0; 3]; 81]);
        assert_eq!(refused, Err(Error::Estimator));
    });
}

#[test]
fn pictures_that_do_not_fit_are_refused() {
    let (six, five) = ([[1.0; 3]; 6], [[1.0; 3]; 5]);
    let fitting =
        Pictures { width: 3, height: 2, balance_radius: 9, guide: &six, unbiased: &six, mean: &six };
    let refusal = |pictures: Pictures<'_>, pixels: usize| {
        let mut scratch = vec![[0.0; 16]; Sampler::resolve_scratch(3, 2)];
        pictures.restore(&mut scratch, &mut vec![[0.0; 3]; pixels]).err()
    };
    assert_eq!(refusal(fitting, 6), None);
    assert_eq!(refusal(fitting, 5), Some(Error::Output));
    assert_eq!(refusal(Pictures { height: 0, ..fitting }, 6), Some(Error::Size));
    assert_eq!(refusal(Pictures { height: 3, ..fitting }, 9), Some(Error::Guide));
    assert_eq!(refusal(Pictures { balance_radius: 1 << 20, ..fitting }, 6), Some(Error::BalanceRadius));
    for short in [
        Pictures { guide: &five, ..fitting },
        Pictures { unbiased: &five, ..fitting },
        Pictures { mean: &five, ..fitting },
    ] {
        assert_eq!(refusal(short, 6), Some(Error::Guide));
    }
    assert_eq!(fitting.restore(&mut [], &mut [[0.0; 3]; 6]), Err(Error::Scratch));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Noise of any scale, with holes of what is no colour.
    #[test]
    fn any_guide_keeps_the_energy(
        (width, height) in (1u32..50, 1u32..50),
        scale in -20f32..12.0,
        seed in any::<u32>(),
        holes in 0u32..3,
    ) {
        let value = |i: u32| {
            let mut x = i.wrapping_mul(0x9e37_79b9) ^ seed;
            x = (x ^ x >> 15).wrapping_mul(0x2c1b_3c6d);
            x = (x ^ x >> 12).wrapping_mul(0x297a_2d39);
            match (x ^ x >> 15) % 64 < holes {
                true => [f32::NAN, f32::INFINITY, f32::MIN][(x % 3) as usize],
                false => (x as f32 / u32::MAX as f32 - 0.3) * 10f32.powf(scale),
            }
        };
        let guide: Vec<[f32; 3]> = (0..width * height).map(|i| [0, 1, 2].map(|c| value(3 * i + c))).collect();
        film(Settings { seed, ..Settings::new(width, height) }, |sampler| check_energy(sampler, &guide));
    }
}

/// The film's guide, its bands taken in any order.
fn filtered(sampler: &Sampler<'_>, features: &[Feature], backwards: bool) -> Vec<[f32; 3]> {
    let (width, height) = (sampler.settings().width, sampler.settings().height);
    let mut floats = vec![f32::NAN; Filter::required(width, height)];
    let mut filter = Filter::new(sampler, features, &mut floats).unwrap();
    for _ in 0..Filter::PASSES {
        let mut bands: Vec<Band<'_>> = filter.bands().collect();
        if backwards {
            bands.reverse();
        }
        bands.into_iter().for_each(|mut band| band.filter());
        filter.next();
    }
    assert_eq!(filter.bands().count(), 0);
    let mut guide = vec![[0.0; 3]; width as usize * height as usize];
    filter.write(&mut guide).unwrap();
    guide
}

#[test]
fn any_size_and_any_feature_filters_to_what_is_finite_and_keeps_the_energy() {
    let odd = [0.0, 1.0, -3.0, f32::NAN, f32::INFINITY, f32::MAX, f32::MIN, 1e-40];
    for (width, height) in [(1, 1), (2, 40), (65, 3), (37, 50), (130, 17)] {
        film(Settings { seed: 9, ..Settings::new(width, height) }, |sampler| {
            let pixels = (width * height) as usize;
            let value = |i: usize| odd[(i * 7 + i / 5) % odd.len()];
            let feature = |i: usize| Feature {
                albedo: [0, 1, 2].map(|c| value(3 * i + c)),
                normal: [0, 1, 2].map(|c| value(5 * i + c)),
                depth: value(2 * i),
            };
            let wild: Vec<Feature> = (0..pixels).map(feature).collect();
            for features in [&[][..], &vec![Feature::default(); pixels], &wild] {
                let guide = filtered(sampler, features, false);
                assert!(guide.as_flattened().iter().all(|v| v.is_finite()));
                assert_eq!(guide, filtered(sampler, features, true));
                check_energy(sampler, &guide);
            }
        });
    }
}

/// Noise on a step: both sides become smooth, and the step stays.
struct Step;

impl Integrand for Step {
    fn radiance(&mut self, batch: &Batch8) -> Rgb8 {
        let (u, _) = batch.point(1);
        let side = batch.x.simd_gt(f32x8::splat(32.0)).select(f32x8::splat(8.0), f32x8::ONE);
        let value = side * (u + f32x8::HALF) * (u + f32x8::HALF);
        Rgb8 { r: value, g: value, b: value }
    }
}

#[test]
fn noise_goes_and_edges_stay() {
    film_of(&mut Step, Settings { seed: 1, ..Settings::new(64, 48) }, |sampler| {
        let (mean, guide) = (resolved(sampler, Estimator::Pooled), filtered(sampler, &[], false));
        let error = |picture: &[[f32; 3]]| -> f64 {
            let truth = |i: usize| if i % 64 < 32 { 1.0 } else { 8.0 } * (26.0 / 24.0);
            picture.iter().enumerate().map(|(i, rgb)| (f64::from(rgb[0]) / truth(i) - 1.0).powi(2)).sum()
        };
        assert!(error(&guide) < 0.05 * error(&mean), "{} of {}", error(&guide), error(&mean));
    });
}

#[test]
fn a_filter_refuses_what_does_not_fit() {
    film(Settings::new(9, 9), |sampler| {
        let mut floats = vec![0.0; Filter::required(9, 9)];
        let refused = Filter::new(sampler, &[Feature::default(); 80], &mut floats).err();
        assert_eq!(refused, Some(Error::Guide));
        assert_eq!(Filter::new(sampler, &[], &mut floats[1..]).err(), Some(Error::Scratch));
        let filter = Filter::new(sampler, &[], &mut floats).unwrap();
        assert_eq!(filter.write(&mut [[0.0; 3]; 80]), Err(Error::Output));
        let mut scratch = vec![[0.0; 16]; Sampler::resolve_scratch(9, 9)];
        assert_eq!(sampler.resolve(Estimator::Guided, &mut scratch, &mut [0.0; 243]), Err(Error::Guide));
    });
}
