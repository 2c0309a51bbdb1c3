//! Films whose pixels are islands in unused space: nothing outside, nothing across, energy exact for each.

use pmcip_core::predict::{Belief, Prior};
use pmcip_core::sampler::batch::{Batch8, Integrand, Rgb8};
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::guide::history::{Blend, Past, carry};
use pmcip_core::sampler::guide::{Feature, Filter};
use pmcip_core::sampler::{Error, Memory, Mode, Sampler, Schedule, Settings, Workspace};
use proptest::prelude::*;
use wide::f32x8;

/// Noise of the mean `level` of the island a pixel is in, rare and bright on islands of an odd label.
#[derive(Clone, Copy)]
struct Islands<'a> {
    width: usize,
    labels: &'a [u16],
    level: fn(u16) -> f32,
}

impl Integrand for Islands<'_> {
    fn radiance(&mut self, batch: &Batch8) -> Rgb8 {
        let (u, v) = batch.point(1);
        let (x, y) = (batch.x.to_array(), batch.y.to_array());
        let (u, v) = (u.to_array(), v.to_array());
        let value = f32x8::from(core::array::from_fn::<f32, 8, _>(|k| {
            let label = self.labels[y[k] as usize * self.width + x[k] as usize];
            assert!(label > 0 || self.labels.iter().all(|l| *l == 0), "a sample where there is no pixel");
            let rare = if label % 2 == 1 { if u[k] < 0.05 { 20.0 } else { 0.0 } } else { 2.0 * u[k] };
            (self.level)(label) * rare * (0.5 + v[k])
        }));
        Rgb8 { r: value, g: value, b: value * f32x8::HALF }
    }
}

fn iterate(sampler: &mut Sampler<'_>, samples: u64, integrand: &mut impl Integrand) {
    let (mut batches, mut radiance) = ([Batch8::default(); 16], [Rgb8::default(); 16]);
    let mut work = Workspace::new(&mut batches, &mut radiance).unwrap();
    sampler.jobs().for_each(|mut job| {
        job.render(integrand, &mut work);
    });
    assert_eq!(sampler.end().map(|_| samples).unwrap(), samples);
}

/// Renders a film with the integrand's labels and shows it.
fn film<T>(settings: Settings, integrand: Islands<'_>, look: impl FnOnce(&Sampler<'_>) -> T) -> T {
    film_of(settings, integrand.labels, integrand, look)
}

/// The same with other labels.
fn film_of<T>(
    settings: Settings,
    labels: &[u16],
    integrand: Islands<'_>,
    look: impl FnOnce(&Sampler<'_>) -> T,
) -> T {
    let required = Sampler::required_with_labels(settings.width, settings.height);
    let (mut floats, mut words) = (vec![f32::NAN; required.floats], vec![9; required.words]);
    let memory = Memory { floats: &mut floats, words: &mut words };
    let mut sampler = Sampler::with_labels(settings, memory, labels).unwrap();
    for samples in Schedule::new(sampler.pixels() as u64, 16, 2, 8) {
        sampler.begin(samples).unwrap();
        iterate(&mut sampler, samples, &mut { integrand });
    }
    look(&sampler)
}

fn resolved(sampler: &Sampler<'_>, estimator: Estimator) -> Vec<[f32; 3]> {
    let (width, height) = (sampler.settings().width, sampler.settings().height);
    let mut scratch = vec![[f32::NAN; 16]; Sampler::resolve_scratch(width, height)];
    let mut rgb = vec![[f32::NAN; 3]; (width * height) as usize];
    sampler.resolve(estimator, &mut scratch, rgb.as_flattened_mut()).unwrap();
    rgb
}

fn guided(sampler: &Sampler<'_>, guide: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let mut scratch =
        vec![[f32::NAN; 16]; Sampler::resolve_scratch(sampler.settings().width, sampler.settings().height)];
    let mut rgb = vec![[f32::NAN; 3]; guide.len()];
    sampler.resolve_guided(guide, &mut scratch, &mut rgb).unwrap();
    rgb
}

fn filtered(sampler: &Sampler<'_>, features: &[Feature]) -> Vec<[f32; 3]> {
    let (width, height) = (sampler.settings().width, sampler.settings().height);
    let mut floats = vec![f32::NAN; Filter::required_with_labels(width, height)];
    let mut filter = Filter::new(sampler, features, &mut floats).unwrap();
    for _ in 0..Filter::PASSES {
        filter.bands().for_each(|mut band| band.filter());
        filter.next();
    }
    let mut guide = vec![[0.0; 3]; (width * height) as usize];
    filter.write(&mut guide).unwrap();
    guide
}

/// Red of an island's pixels, summed.
fn energy(rgb: &[[f32; 3]], labels: &[u16], label: u16) -> f64 {
    rgb.iter().zip(labels).filter(|(_, l)| **l == label).map(|(rgb, _)| f64::from(rgb[0])).sum()
}

/// Four islands that touch, and unused space: a disc, a frame, a checked one, a lone pixel.
fn atlas(width: usize, height: usize) -> Vec<u16> {
    let label = |x: usize, y: usize| match (x, y) {
        (x, y) if (x as f32 - 20.0).hypot(y as f32 - 17.0) < 11.0 => 1,
        (x, y) if x > 34 && x < 50 && y > 3 => 2,
        (x, y) if x < 30 && y > 30 && (x + y) % 2 == 0 => 3,
        (x, y) if x >= 50 && y > 3 => 500,
        (40, 1) => 65_535,
        _ => 0,
    };
    (0..width * height).map(|i| label(i % width, i / width)).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Any labels at any size: no samples outside, all of them inside, energy exact for each island.
    #[test]
    fn samples_are_inside_and_energy_is_exact(
        (width, height) in (1u32..60, 1u32..60),
        islands in 1u16..9,
        block in 1usize..12,
        seed in any::<u32>(),
    ) {
        let hash = |x: usize, y: usize| {
            let h = ((x / block * 7919) ^ (y / block * 104_729)) as u32 ^ seed;
            (h.wrapping_mul(0x9e37_79b9) >> 16) as u16 % (islands + 1)
        };
        let mut labels: Vec<u16> = (0..width * height).map(|i| hash((i % width) as usize, (i / width) as usize)).collect();
        labels[0] = islands;
        let integrand = Islands { width: width as usize, labels: &labels, level: f32::from };
        film(Settings { seed, ..Settings::new(width, height).for_frame(2, 16) }, integrand, |sampler| {
            let pixels = labels.len();
            let (mut count, mut alpha) = (vec![0; pixels], vec![0.0; pixels]);
            sampler.count(&mut count).unwrap();
            sampler.alpha(&mut alpha).unwrap();
            let used = labels.iter().filter(|label| **label > 0).count();
            assert_eq!(count.iter().map(|n| *n as usize).sum::<usize>(), 16 * used);
            let sum: f64 = alpha.iter().map(|a| f64::from(*a)).sum();
            assert!((sum - 1.0).abs() < 1e-5, "alpha sums to {sum}");
            let outside = |i: &usize| labels[*i] == 0;
            assert!((0..pixels).filter(outside).all(|i| count[i] == 0 && alpha[i] == 0.0));
            assert!((0..pixels).filter(|i| labels[*i] > 0).all(|i| count[i] > 0));
            let fair = resolved(sampler, Estimator::Difference);
            let noise: Vec<[f32; 3]> = (0..pixels).map(|i| [(i * 7 % 13) as f32, f32::NAN, 0.0]).collect();
            let flat: Vec<[f32; 3]> = (0..pixels).map(|i| [(i * 7 % 13) as f32; 3]).collect();
            for picture in [resolved(sampler, Estimator::Balanced), guided(sampler, &noise), guided(sampler, &flat), guided(sampler, &filtered(sampler, &[]))] {
                assert!(picture.as_flattened().iter().all(|v| v.is_finite()));
                assert!((0..pixels).filter(outside).all(|i| picture[i] == [0.0; 3]));
                for label in 1..=islands {
                    let size: f64 = labels.iter().filter(|l| **l == label).count() as f64;
                    let (want, found) = (energy(&fair, &labels, label), energy(&picture, &labels, label));
                    assert!((want - found).abs() <= 1e-5 * (want + 13.0 * size), "{found}, not {want}");
                }
            }
        });
    }
}

/// What is seen of an island depends on nothing that another one shows.
#[test]
fn nothing_crosses() {
    let (width, height) = (70, 45);
    let labels = atlas(width, height);
    let features: Vec<Feature> = (0..width * height)
        .map(|i| Feature { albedo: [0.5; 3], normal: [0.0, 0.0, 1.0], depth: 5.0 + (i % 7) as f32 * 0.1 })
        .collect();
    let settings = Settings {
        mode: Mode::Uniform,
        estimator: Estimator::Balanced,
        ..Settings::new(width as u32, height as u32)
    };
    let seen = |level: fn(u16) -> f32| {
        film(settings, Islands { width, labels: &labels, level }, |sampler| {
            let mut beliefs = vec![Belief::NONE; labels.len()];
            sampler.beliefs(&mut beliefs).unwrap();
            let guide = filtered(sampler, &features);
            let picture = guided(sampler, &guide);
            (beliefs, guide, resolved(sampler, Estimator::Balanced), picture)
        })
    };
    let (calm, wild) = (seen(|_| 1.0), seen(|label| if label == 1 { 1.0 } else { 1e4 }));
    let of = |i: &usize| labels[*i] == 1;
    let island: Vec<usize> = (0..labels.len()).filter(of).collect();
    assert!(island.len() > 300);
    for i in island {
        assert_eq!(calm.0[i], wild.0[i], "a window crosses");
        assert_eq!(calm.1[i], wild.1[i], "the filter crosses");
        assert_eq!(calm.2[i], wild.2[i], "smoothing crosses");
        assert_eq!(calm.3[i], wild.3[i], "guided smoothing crosses");
    }
}

/// One label for all is no label.
#[test]
fn one_island_is_a_film() {
    let labels = vec![7u16; 53 * 37];
    let settings = Settings::new(53, 37).for_frame(2, 16);
    let mut integrand = Islands { width: 53, labels: &labels, level: |_| 1.0 };
    let all = film(settings, integrand, |sampler| resolved(sampler, Estimator::Balanced));
    let required = Sampler::required(53, 37);
    let (mut floats, mut words) = (vec![0.0; required.floats], vec![0; required.words]);
    let mut sampler = Sampler::new(settings, Memory { floats: &mut floats, words: &mut words }).unwrap();
    for samples in Schedule::new(53 * 37, 16, 2, 8) {
        sampler.begin(samples).unwrap();
        iterate(&mut sampler, samples, &mut integrand);
    }
    assert_eq!(all, resolved(&sampler, Estimator::Balanced));
}

/// Every island's energy within 3 standard errors of the truth, 40 frames of five islands: a false alarm once in 75. With one
/// label for all energy strays.
#[test]
fn islands_keep_their_energy() {
    let (width, height) = (70, 45);
    let labels = atlas(width, height);
    let inside: Vec<u16> = labels.iter().map(|label| (*label).min(1)).collect();
    let level = |label: u16| if label % 2 == 1 { 1.0 } else { 2.0 };
    let off = |given: &[u16], label: u16| {
        let truth = f64::from(level(label)) * labels.iter().filter(|l| **l == label).count() as f64;
        let errors: Vec<f64> = (0..40)
            .map(|seed| {
                let settings =
                    Settings { seed, ..Settings::new(width as u32, height as u32).for_frame(2, 16) };
                film_of(settings, given, Islands { width, labels: &labels, level }, |sampler| {
                    energy(&resolved(sampler, Estimator::Balanced), &labels, label) / truth - 1.0
                })
            })
            .collect();
        let mean = errors.iter().sum::<f64>() / 40.0;
        let variance = errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / 39.0;
        (mean, mean / (variance / 40.0).sqrt())
    };
    for label in [1, 2, 3, 500] {
        let (mean, sigmas) = off(&labels, label);
        assert!(sigmas.abs() < 3.0, "island {label} is off by {mean}, {sigmas} standard errors");
    }
    // What balancing does not give back to the island it was lost in, of the energy of the fair samples.
    let integrand = Islands { width, labels: &labels, level };
    let settings = Settings::new(width as u32, height as u32).for_frame(2, 16);
    let strayed = |one: bool| {
        let given = if one { &inside } else { &labels };
        let pictures = |sampler: &Sampler<'_>| {
            [Estimator::Balanced, Estimator::Difference].map(|estimator| resolved(sampler, estimator))
        };
        let [balanced, fair] = film_of(settings, given, integrand, pictures);
        let parts = [1, 2, 3, 500].map(|l| energy(&balanced, &labels, l) / energy(&fair, &labels, l) - 1.0);
        parts.into_iter().map(f64::abs).fold(0.0, f64::max)
    };
    assert!(strayed(false) < 1e-5 && strayed(true) > 1e-3, "{} and {}", strayed(false), strayed(true));
}

#[test]
fn labels_that_do_not_fit_are_refused() {
    let refused = |labels: &[u8], words: usize| {
        let (mut floats, mut words) = (vec![0.0; 8 * 12], vec![0; words]);
        let memory = Memory { floats: &mut floats, words: &mut words };
        Sampler::with_labels(Settings::new(4, 3), memory, labels).err()
    };
    assert_eq!(refused(&[1; 12], 4 * 12), None);
    assert_eq!(refused(&[1; 12], 3 * 12), Some(Error::Memory));
    assert_eq!(refused(&[1; 11], 4 * 12), Some(Error::Labels));
    assert_eq!(refused(&[0; 12], 4 * 12), Some(Error::Labels));
}

/// A kernel that is given decides the first iteration, and where it is 0 there is nothing, of no estimator.
#[test]
fn a_given_kernel_counts_from_the_first_iteration_on() {
    for estimator in [Estimator::Balanced, Estimator::Subframe, Estimator::Pooled] {
        let (width, height) = (40u32, 24u32);
        let pixels = (width * height) as usize;
        let settings = Settings { estimator, fair: 4, ..Settings::new(width, height).for_frame(0, 16) };
        let required = Sampler::required(width, height);
        let (mut floats, mut words) = (vec![0.0; required.floats], vec![0; required.words]);
        let mut sampler = Sampler::new(settings, Memory { floats: &mut floats, words: &mut words }).unwrap();
        let alpha: Vec<f32> = (0..pixels).map(|i| [0.0, 1.0, 3.0, 0.0][i % 40 / 10]).collect();
        let all = vec![1u16; pixels];
        let mut integrand = Islands { width: 40, labels: &all, level: |_| 1.0 };
        sampler.begin_predicted(8 * pixels as u64, Prior::Alpha(&alpha)).unwrap();
        iterate(&mut sampler, 8 * pixels as u64, &mut integrand);
        let mut count = vec![0; pixels];
        sampler.count(&mut count).unwrap();
        let part = |i: usize| count.iter().skip(i * 10).step_by(40).sum::<u32>();
        assert_eq!((part(0), part(3)), (0, 0));
        assert!(count.iter().zip(&alpha).all(|(n, a)| (*n == 0) == (*a == 0.0)));
        let ratio = f64::from(part(2)) / f64::from(part(1));
        assert!((1.5..3.1).contains(&ratio), "{ratio}");
        let mut found = vec![0.0; pixels];
        sampler.alpha(&mut found).unwrap();
        assert!(found.iter().zip(&alpha).all(|(a, b)| (*a == 0.0) == (*b == 0.0)));
        // What was left out gets its fair samples later.
        for _ in 0..12 {
            sampler.begin(2 * pixels as u64).unwrap();
            iterate(&mut sampler, 2 * pixels as u64, &mut integrand);
        }
        sampler.count(&mut count).unwrap();
        assert!(count.iter().all(|n| *n >= 4));
        // A kernel of zeros says nothing.
        sampler.begin_predicted(pixels as u64, Prior::Alpha(&vec![0.0; pixels])).unwrap();
        iterate(&mut sampler, pixels as u64, &mut integrand);
    }
}

/// What another island has shown is not carried over, and does not say that this one has changed.
#[test]
fn history_stays_on_its_island() {
    let (width, labels) = (8, [1u16, 1, 1, 1, 2, 2, 2, 2]);
    let feature = Feature { albedo: [1.0; 3], normal: [0.0, 0.0, 1.0], depth: 1.0 };
    let past = |label: u16| Past { light: [f32::from(label); 3], variance: 1.0, feature };
    let before = labels.map(past);
    let positions: Vec<[f32; 2]> = (0..8).map(|x| [x as f32 + 0.9, 0.5]).collect();
    let mut carried = [Past::NONE; 8];
    carry(&before, width, &positions, &[feature; 8], &labels, &mut carried).unwrap();
    assert_eq!((carried[3].light, carried[4].light), ([1.0; 3], [2.0; 3]));
    carry(&before, width, &positions, &[feature; 8], &[], &mut carried).unwrap();
    assert!(carried[3].light[0] > 1.2, "the control does not cross");
    let blended = |second: f32, labels: &[u16]| {
        let filtered = side_by_side(second);
        let (variance, features) = ([1.0; 8], [feature; 8]);
        let blend = Blend {
            width,
            filtered: &filtered,
            variance: &variance,
            features: &features,
            carried: &before,
            labels,
        };
        let (mut work, mut kept, mut out) = ([[0.0; 2]; 8], [Past::NONE; 8], [[0.0; 3]; 8]);
        blend.run(&mut work, &mut kept, &mut out).unwrap();
        out[3]
    };
    assert_eq!(blended(2.0, &labels), blended(900.0, &labels));
    assert_ne!(blended(2.0, &[]), blended(900.0, &[]), "the control does not cross");
    assert_eq!(
        carry(&before, width, &positions, &[feature; 8], &labels[1..], &mut carried),
        Err(Error::Labels)
    );
}

/// An island of light 1.5 beside one of `second`.
fn side_by_side(second: f32) -> [[f32; 3]; 8] {
    std::array::from_fn(|x| [if x < 4 { 1.5 } else { second }; 3])
}

/// How many samples of a pixel are fair depends on the size of the picture, which unused pixels do not count to.
#[test]
fn unused_pixels_do_not_make_a_picture_large() {
    let fair = |settings: Settings| (settings.fair, settings.defensive);
    let small = fair(Settings::new(200, 150).for_frame(2, 16));
    assert_eq!(fair(Settings::new(256, 256).for_pixels(30_000, 2, 16)), small);
    assert_eq!((small.0, Settings::new(256, 256).for_frame(2, 16).fair), (8, 4));
}
