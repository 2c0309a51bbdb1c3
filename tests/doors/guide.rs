//! Any film, features, guide and past: filter, blend and picture are finite, and the picture has the energy of the fair samples.

use super::bytes::{Bytes, Cycle};
use pmcip_core::sampler::batch::{Batch8, MAX_RADIANCE, Rgb8};
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::guide::history::{Blend, Past, carry};
use pmcip_core::sampler::guide::{Feature, Filter};
use pmcip_core::sampler::{Memory, Sampler, Settings, Workspace};

type Picture = Vec<[f32; 3]>;

fn feature(any: &mut Cycle) -> Feature {
    Feature { albedo: any.rgb(), normal: any.rgb(), depth: any.one() }
}

fn finite(picture: &Picture) {
    assert!(picture.as_flattened().iter().all(|v| v.is_finite()));
}

fn filtered(film: &Sampler, features: &[Feature], pixels: usize) -> (Picture, Vec<f32>) {
    let settings = film.settings();
    let mut scratch = vec![0.0; Filter::required(settings.width, settings.height)];
    let mut filter = Filter::new(film, features, &mut scratch).expect("right lengths");
    for _ in 0..Filter::PASSES {
        filter.bands().for_each(|mut band| band.filter());
        filter.next();
    }
    let (mut guide, mut variance) = (vec![[0.0; 3]; pixels], vec![0.0; pixels]);
    filter.write(&mut guide).expect("right length");
    filter.variance(&mut variance).expect("right length");
    (guide, variance)
}

/// Whatever the guide, the picture sums to what the fair samples sum to, but for the rounding of what was summed.
fn check_energy(film: &Sampler, guide: &Picture) {
    let settings = film.settings();
    let mut scratch = vec![[0.0; 16]; Sampler::resolve_scratch(settings.width, settings.height)];
    let (mut fair, mut out) = (guide.clone(), guide.clone());
    film.resolve(Estimator::Difference, &mut scratch, fair.as_flattened_mut()).expect("right lengths");
    film.resolve_guided(guide, &mut scratch, &mut out).expect("right lengths");
    finite(&out);
    for c in 0..3 {
        let sum =
            |picture: &Picture, of: fn(f64) -> f64| picture.iter().map(|v| of(f64::from(v[c]))).sum::<f64>();
        let used = guide
            .iter()
            .flatten()
            .filter(|v| v.abs() <= MAX_RADIANCE)
            .map(|v| f64::from(v.abs()))
            .sum::<f64>();
        let rounding = 1e-3 * (used + sum(&fair, f64::abs) + sum(&out, f64::abs)) + 1e-30;
        assert!((sum(&out, |v| v) - sum(&fair, |v| v)).abs() <= rounding);
    }
}

/// A head of settings, then four lists of numbers that are repeated: radiances, features, a guide, the past.
pub fn check(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let kind = bytes.byte();
    let (tame, with_features) = (kind & 1 == 1, kind & 2 == 2);
    let size = [0; 2].map(|_| bytes.below(40) as u32);
    let settings = Settings {
        balance_radius: u32::from(bytes.byte() % 100),
        fair: u32::from(bytes.byte()),
        ..Settings::new(size[0], size[1])
    };
    let required = Sampler::required(settings.width, settings.height);
    let (mut floats, mut words) = (vec![0.0; required.floats], vec![0; required.words]);
    let Ok(mut film) = Sampler::new(settings, Memory { floats: &mut floats, words: &mut words }) else {
        return;
    };
    let pixels = size[0] as usize * size[1] as usize;
    let (mut batches, mut radiance) = ([Batch8::default(); 9], [Rgb8::default(); 9]);
    let mut work = Workspace::new(&mut batches, &mut radiance).expect("not empty");
    let mut integrand = list(&mut bytes, tame);
    for _ in 0..3 {
        film.begin(2 * pixels as u64).expect("valid samples");
        for mut job in film.jobs() {
            job.render(&mut integrand, &mut work);
        }
        film.end().expect("every job was rendered");
    }
    let mut any = list(&mut bytes, tame);
    let features: Vec<Feature> = (0..pixels).map(|_| feature(&mut any)).collect();
    let (guide, variance) = filtered(&film, if with_features { &features } else { &[] }, pixels);
    finite(&guide);
    check_energy(&film, &guide);
    let mut any = list(&mut bytes, tame);
    check_energy(&film, &(0..pixels).map(|_| any.rgb()).collect());

    let mut any = list(&mut bytes, tame);
    let past = |any: &mut Cycle| Past { light: any.rgb(), variance: any.one(), feature: feature(any) };
    let before: Vec<Past> = (0..pixels).map(|_| past(&mut any)).collect();
    let positions: Vec<[f32; 2]> = (0..pixels).map(|_| [any.one(), any.one()]).collect();
    let (mut carried, mut kept) = (vec![Past::NONE; pixels], vec![Past::NONE; pixels]);
    carry(&before, size[0] as usize, &positions, &features, &[], &mut carried).expect("right lengths");
    for carried in [&carried, &before] {
        let (width, features) = (size[0] as usize, &features[..]);
        let blend = Blend { width, filtered: &guide, variance: &variance, features, carried, labels: &[] };
        let (mut work, mut out) = (vec![[0.0; 2]; pixels], guide.clone());
        blend.run(&mut work, &mut kept, &mut out).expect("right lengths");
        check_energy(&film, &out);
    }
}

/// Numbers from as many bytes as the first one says.
fn list(bytes: &mut Bytes, tame: bool) -> Cycle {
    let length = usize::from(bytes.byte());
    bytes.cycle(length, tame)
}

/// With features and without, tame numbers and any.
pub fn seeds() -> Vec<Vec<u8>> {
    let ramp: Vec<u8> = (0..45i16).flat_map(|i| (i * 83).to_le_bytes()).collect();
    let any = [f32::NAN, f32::INFINITY, 1e-40, 0.3, -1.0, 1e15, 9e14, 1e-20].map(f32::to_le_bytes).concat();
    let list = |values: &[u8]| [&[values.len() as u8], values].concat();
    let seed = |kind: u8, values: &[u8]| [&[kind, 19, 16, 96, 2][..], &list(values).repeat(4)].concat();
    vec![seed(1, &ramp), seed(3, &ramp), seed(2, &any), seed(0, &any)]
}
