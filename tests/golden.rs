//! Do renders still agree with pictures recorded before, to within the noise of both?
//!
//! `tests/golden/NAME.exr` has, of 256 renders of 64 samples a pixel with a seed each, every pixel's and channel's mean
//! and its variance over renders (planes `variance.*`; the variances of the image's means are attributes of these names).
//! A test renders 16 or 64 more with other seeds, and asks of each of the 3 × 1024 means whether it differs: Student's t
//! with the variances of both sets pooled, 270 or 318 degrees of freedom. The image's three means are asked the same. A
//! picture fails by chance in 0.1 % of seeds by its pixels and in 0.1 % by its means (α, Šidák-corrected over pixels and
//! channels; four pictures, eight tests; seeds are fixed), as far as means are normal: with 64 renders the largest t of
//! `caustic` in six sets of seeds was 4.7 of 5.2 allowed, with 16 it was 5.7. The largest t are printed.
//!
//! On failure the reference, the render, their difference and t go to the target directory as EXR files. To record anew,
//! where the light itself was wrong: `PMCIP_RECORD=1 cargo test --release --test golden`.

use pmcip::frame::render::render;
use pmcip::frame::settings::{Integrator, Method, Settings};
use pmcip::picture::frame_io::{Picture, read_exr, write_exr};
use pmcip::scene::{LoadedScene, load};
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, StudentsT};
use std::path::{Path, PathBuf};

const SIDE: u32 = 32;
const SPP: u32 = 64;
const RECORDED: u32 = 256;
const RUNS: u32 = 16;
/// The same where bright samples are rare: means of 16 renders are too skewed for Student's t.
const RUNS_OF_RARE_LIGHT: u32 = 64;
/// Seeds of recorded renders begin here, those of tests at 0.
const RECORDED_SEED: u32 = 1_000_000;
const ALPHA: f64 = 0.001;
/// Relative differences that rounding can make, which no variance knows of.
const ROUNDING: f64 = 1e-5;

/// Mean and variance of renders; pixel by pixel, R, G and B.
struct Moments {
    renders: f64,
    mean: Vec<f64>,
    variance: Vec<f64>,
    /// Variance of the image's means of R, G and B.
    image_variance: [f64; 3],
}

fn mean_and_variance(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    (mean, values.map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0))
}

/// Means of a picture's channels.
fn image_means(mean: &[f64]) -> [f64; 3] {
    [0, 1, 2].map(|c| mean.iter().skip(c).step_by(3).sum::<f64>() * 3.0 / mean.len() as f64)
}

impl Moments {
    fn of(renders: &[Vec<f64>]) -> Moments {
        let of_value = |i: usize| mean_and_variance(renders.iter().map(move |render| render[i]));
        let (mean, variance) = (0..renders[0].len()).map(of_value).unzip();
        let images: Vec<[f64; 3]> = renders.iter().map(|render| image_means(render)).collect();
        let image_variance = [0, 1, 2].map(|c| mean_and_variance(images.iter().map(move |i| i[c])).1);
        Moments { renders: renders.len() as f64, mean, variance, image_variance }
    }

    /// Every value's t against recorded moments.
    fn t(&self, recorded: &Moments) -> Vec<f64> {
        let (own, other) = (self.renders - 1.0, recorded.renders - 1.0);
        let shares = 1.0 / self.renders + 1.0 / recorded.renders;
        let t = |i: usize| {
            let pooled = (own * self.variance[i] + other * recorded.variance[i]) / (own + other);
            let rounding = (ROUNDING * recorded.mean[i]).powi(2);
            (self.mean[i] - recorded.mean[i]) / (pooled * shares + rounding).sqrt().max(f64::MIN_POSITIVE)
        };
        (0..self.mean.len()).map(t).collect()
    }

    /// The same of the image's three means.
    fn image_t(&self, recorded: &Moments) -> [f64; 3] {
        let (own, other) = (self.renders - 1.0, recorded.renders - 1.0);
        let shares = 1.0 / self.renders + 1.0 / recorded.renders;
        let [now, before] = [self, recorded].map(|moments| image_means(&moments.mean));
        [0, 1, 2].map(|c| {
            let pooled = (own * self.image_variance[c] + other * recorded.image_variance[c]) / (own + other);
            (now[c] - before[c]) / (pooled * shares).sqrt()
        })
    }

    fn write(&self, path: &Path) {
        let mut file = picture(&self.mean);
        for (c, name) in ["variance.red", "variance.green", "variance.blue"].into_iter().enumerate() {
            let plane = self.variance.iter().skip(c).step_by(3).map(|v| *v as f32).collect();
            file.planes.insert(name.into(), plane);
            file.attributes.insert(name.into(), self.image_variance[c].to_string());
        }
        write_exr(path, &file).unwrap();
    }

    fn read(path: &Path) -> Moments {
        let file = read_exr(path).unwrap();
        let names = ["red", "green", "blue"].map(|colour| format!("variance.{colour}"));
        let planes = names.each_ref().map(|name| &file.planes[name]);
        let pixels = 0..file.rgb.len();
        Moments {
            renders: f64::from(RECORDED),
            mean: file.rgb.as_flattened().iter().map(|v| f64::from(*v)).collect(),
            variance: pixels.flat_map(|i| planes.map(|plane| f64::from(plane[i]))).collect(),
            image_variance: names.each_ref().map(|name| file.attributes[name].parse().unwrap()),
        }
    }
}

fn picture(values: &[f64]) -> Picture {
    let (pixels, _) = values.as_chunks::<3>();
    let rgb = pixels.iter().map(|pixel| pixel.map(|v| v as f32)).collect();
    Picture { width: SIDE, height: SIDE, rgb, ..Picture::default() }
}

/// Largest |t| by chance, but for a part [`ALPHA`] of seeds, of so many tests.
fn limit(tests: usize, freedom: f64) -> f64 {
    let each = 1.0 - (1.0 - ALPHA).powf(1.0 / tests as f64);
    StudentsT::new(0.0, 1.0, freedom).unwrap().inverse_cdf(1.0 - 0.5 * each)
}

/// What differs between the moments, if anything does.
fn difference(now: &Moments, recorded: &Moments) -> Option<String> {
    let largest = |t: &[f64]| t.iter().fold(0.0, |largest: f64, t| largest.max(t.abs()));
    let (pixels, images) = (largest(&now.t(recorded)), largest(&now.image_t(recorded)));
    let freedom = now.renders + recorded.renders - 2.0;
    let [pixel_limit, image_limit] = [now.mean.len(), 3].map(|tests| limit(tests, freedom));
    println!("largest t {pixels:.2} of {pixel_limit:.2} in pixels, {images:.2} of {image_limit:.2} in means");
    // What is not a number differs.
    let same = pixels <= pixel_limit && images <= image_limit && now.mean.iter().all(|v| v.is_finite());
    (!same)
        .then(|| format!("pixels: {pixels:.1} of {pixel_limit:.1}, means: {images:.1} of {image_limit:.1}"))
}

/// Writes the four pictures of a failure, and says where.
fn show(name: &str, now: &Moments, recorded: &Moments) -> String {
    let differences: Vec<f64> = now.mean.iter().zip(&recorded.mean).map(|(a, b)| a - b).collect();
    let pictures = [
        ("reference", &recorded.mean),
        ("render", &now.mean),
        ("difference", &differences),
        ("t", &now.t(recorded)),
    ];
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    for (what, values) in pictures {
        write_exr(&folder.join(format!("golden-{name}-{what}.exr")), &picture(values)).unwrap();
    }
    format!("{}/golden-{name}-{{reference,render,difference,t}}.exr", folder.display())
}

fn scene(name: &str) -> LoadedScene {
    load(&Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{name}.toml"))).unwrap()
}

/// Renders with a seed each.
fn renders(scene: &LoadedScene, integrator: Integrator, seed: u32, count: u32) -> Vec<Vec<f64>> {
    let one = |seed: u32| {
        let mut settings = Settings::new(scene, Method::Uniform, Some(SPP), Some((SIDE, SIDE)));
        settings.sampler.seed = seed;
        settings.integrator = match integrator {
            Integrator::Gather { photons, .. } => Integrator::Gather { photons, photon_seed: seed },
            other => other,
        };
        let frame = render(scene, &settings, Some(1), &|_| ()).unwrap();
        frame.rgb.as_flattened().iter().map(|v| f64::from(*v)).collect()
    };
    (seed..seed + count).into_par_iter().map(one).collect()
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/golden/{name}.exr"))
}

fn recording() -> bool {
    std::env::var_os("PMCIP_RECORD").is_some()
}

/// Compares a scene with its record, or records it.
fn check(scene_name: &str, integrator: Integrator, runs: u32) {
    let (scene, name) = (scene(scene_name), format!("{scene_name}-{}", integrator.name()));
    if recording() {
        Moments::of(&renders(&scene, integrator, RECORDED_SEED, RECORDED)).write(&file(&name));
    }
    let recorded = Moments::read(&file(&name));
    let now = Moments::of(&renders(&scene, integrator, 0, runs));
    if let Some(words) = difference(&now, &recorded) {
        panic!("{name} is another picture: {words}; see {}", show(&name, &now, &recorded));
    }
}

#[test]
fn cornell_is_as_recorded() {
    check("cornell", Integrator::Path, RUNS);
}

#[test]
fn caustic_is_as_recorded() {
    check("caustic", Integrator::Path, RUNS_OF_RARE_LIGHT);
}

#[test]
fn cornell_by_direct_light_is_as_recorded() {
    check("cornell", Integrator::Direct { light_samples: 2, bsdf_samples: 1 }, RUNS);
}

#[test]
fn cornell_by_photons_is_as_recorded() {
    check("cornell", Integrator::Gather { photons: 3_000, photon_seed: 0 }, RUNS_OF_RARE_LIGHT);
}

/// Negative controls: each must be seen, though none is by eye.
#[test]
fn small_errors_are_seen() {
    if recording() {
        return; // What this reads is being written.
    }
    let recorded = Moments::read(&file("cornell-path"));
    let mut cornell = scene("cornell");
    let right = renders(&cornell, Integrator::Path, 500, RUNS);
    assert_eq!(difference(&Moments::of(&right), &recorded), None);

    let lost: Vec<Vec<f64>> = right.iter().map(|render| render.iter().map(|v| 0.98 * v).collect()).collect();
    assert!(difference(&Moments::of(&lost), &recorded).is_some(), "a part of the samples was lost");

    let shifted: Vec<Vec<f64>> = right.iter().map(|render| [&render[3..], &render[..3]].concat()).collect();
    assert!(difference(&Moments::of(&shifted), &recorded).is_some(), "it is a pixel to the left");

    cornell.materials.iter_mut().for_each(|material| material.diffuse = material.diffuse.map(|v| 0.98 * v));
    let darker = Moments::of(&renders(&cornell, Integrator::Path, 500, RUNS));
    assert!(difference(&darker, &recorded).is_some(), "materials are 2 % darker");
    assert!(show("darker", &darker, &recorded).ends_with(".exr"));
}
