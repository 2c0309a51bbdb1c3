//! Numbers that hurt: each case with what must come out of it, derived beforehand. `benches/README.md` has the errors.

mod program;

use pmcip::film::Film;
use pmcip::picture::frame_io::read_exr;
use pmcip_core::maths::sobol::point;
use pmcip_core::maths::tvi::tvi;
use pmcip_core::predict::homography::{Homography, Pair};
use pmcip_core::predict::tracks::Tracks;
use pmcip_core::predict::{Belief, Prior, carry};
use pmcip_core::sampler::batch::{Batch8, Integrand, Rgb8};
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::{Memory, Sampler, Settings};
use program::success;
use std::fs;
use wide::{f32x8, u32x8};

/// A film after iterations of so many samples.
fn film(settings: Settings, iterations: &[u64], integrand: &mut impl Integrand) -> Film {
    let mut film = Film::new(settings).unwrap();
    for samples in iterations {
        film.begin(*samples).unwrap();
        film.render(integrand).unwrap();
        film.end().unwrap();
    }
    film
}

fn grey(value: f32x8) -> Rgb8 {
    Rgb8 { r: value, g: value, b: value }
}

/// The number of each sample's pixel in a film `width` wide.
fn pixel(batch: &Batch8, width: f32) -> f32x8 {
    batch.y.floor() * f32x8::splat(width) + batch.x.floor()
}

fn sum(rgb: &[[f32; 3]]) -> f64 {
    rgb.iter().map(|rgb| f64::from(rgb[1])).sum()
}

/// Samples `offset` ± 1, rounded as single precision has them; keeps what it has given.
struct Offset {
    offset: f32,
    given: Vec<f32>,
}

impl Integrand for Offset {
    fn radiance(&mut self, batch: &Batch8) -> Rgb8 {
        let side = batch.point(1).0.simd_lt(f32x8::HALF).select(f32x8::ONE, -f32x8::ONE);
        let value = f32x8::splat(self.offset) + side;
        self.given.extend(&value.to_array()[..batch.lanes as usize]);
        grey(value)
    }
}

/// A million samples in one pixel, in sixteen parts and in four thousand: mean and variance against two passes in double
/// precision over the same samples. Limits: 1e-4 of the mean, 1e-3 of the variance, which is that of differences: single precision
/// has them exactly, however coarse it is at the offset.
#[test]
fn a_million_samples_on_an_offset() {
    for offset in [0.0, 1.0, 1e3, 1e5, 1e6, 1e8f32] {
        for part in [65_536, 256] {
            let mut samples = Offset { offset, given: Vec::new() };
            let iterations = vec![part; (1 << 20) / part as usize];
            let mut film = film(Settings::new(1, 1), &iterations, &mut samples);
            let n = samples.given.len() as f64;
            assert_eq!(n, 1_048_576.0);
            let truth = samples.given.iter().map(|v| f64::from(*v)).sum::<f64>() / n;
            let squares = samples.given.iter().map(|v| (f64::from(*v) - truth).powi(2)).sum::<f64>();
            let (mean, variance) =
                (sum(&film.resolve(Estimator::Pooled).unwrap()), film.variance().unwrap()[0]);
            let spread = (squares / n).sqrt();
            let off = (mean - truth).abs();
            let of_variance = f64::from(variance) * n * n / squares - 1.0;
            println!("{offset:e}, parts of {part}: mean off by {off:.1e}, variance by {of_variance:+.1e}");
            assert!(off <= 1e-4 * truth.abs().max(spread), "{offset} {part}: mean {mean} for {truth}");
            let is_right = of_variance.abs() < 1e-3;
            assert!(squares == 0.0 && variance == 0.0 || is_right, "{offset} {part}: {variance}");
        }
    }
}

/// A thousand million samples in one pixel, by merging films of n samples about means a and b.
///
/// By pairs, as `pmcip merge` does it: after 14 rounds the mean is (a + b)/2 and the squared deviations are those of all parts
/// and (a − b)²/4 for every sample. Limits: 1e-4 of the spread, 1 % of the variance.
///
/// One after the other: the k-th film of b moves the mean by (b − a)/k², until that is less than half a step of single
/// precision, at k² = 2(b − a)/step: what is missing then, (b − a)/k, is the limit of this way.
#[test]
fn a_thousand_million_samples_in_one_pixel() {
    const PART: u64 = 1 << 16;
    const ROUNDS: u32 = 14;
    let part = |offset: f32, seed: u32| {
        let mut samples = Offset { offset, given: Vec::new() };
        let film = film(Settings { seed, ..Settings::new(1, 1) }, &[PART], &mut samples);
        let mean = samples.given.iter().map(|v| f64::from(*v)).sum::<f64>() / PART as f64;
        let squares = samples.given.iter().map(|v| (f64::from(*v) - mean).powi(2)).sum::<f64>();
        (film, mean, squares)
    };
    let mean_of = |film: &mut Film| f64::from(film.resolve(Estimator::Pooled).unwrap()[0][1]);
    let ((mut one, a, squares_a), (mut other, b, squares_b)) = (part(1.0, 0), part(2.5, 1));
    let (first, second) = (one.save().unwrap(), other.save().unwrap());
    for _ in 0..ROUNDS {
        let bytes = [&mut one, &mut other].map(|film| film.save().unwrap());
        one.merge(&bytes[1]).unwrap();
        other.merge(&bytes[0]).unwrap();
    }
    let all = (PART << ROUNDS) as f64;
    let squares = (squares_a + squares_b) * f64::from(1 << (ROUNDS - 1)) + all * (a - b).powi(2) / 4.0;
    let spread = (squares / all).sqrt();
    let off = mean_of(&mut one) - (a + b) / 2.0;
    let of_variance = f64::from(one.variance().unwrap()[0]) * all * all / squares - 1.0;
    println!("1e9 samples by pairs: mean off by {off:+.1e}, variance by {of_variance:+.1e}");
    assert_eq!(one.count().unwrap(), [1 << 30]);
    assert!(off.abs() < 1e-4 * spread && of_variance.abs() < 0.01, "{off} {of_variance}");
    // Counts end at 2^32 - 1: as many samples again, five times, leave the mean where it is.
    let bytes = other.save().unwrap();
    (0..5).for_each(|_| one.merge(&bytes).unwrap());
    assert_eq!(one.count().unwrap(), [u32::MAX]);
    assert!((mean_of(&mut one) - (a + b) / 2.0).abs() < 1e-4 * spread);
    let mut chain = Film::load(&first).unwrap();
    let films = (1 << ROUNDS) - 1;
    (0..films).for_each(|_| chain.merge(&second).unwrap());
    let off = mean_of(&mut chain) - (a + f64::from(films) * b) / f64::from(films + 1);
    let step = f64::from(2.5f32.next_up() - 2.5);
    println!("one after the other: mean off by {off:+.1e}");
    assert!(off.abs() < ((b - a) * step / 2.0).sqrt(), "{off}");
}

/// A millionfold firefly in a hundred thousand samples, 1 otherwise: mean 11.
struct Fireflies;

impl Integrand for Fireflies {
    fn radiance(&mut self, batch: &Batch8) -> Rgb8 {
        let bright = batch.point(1).0.simd_lt(f32x8::splat(1e-5));
        grey(bright.select(f32x8::splat(1e6), f32x8::ONE))
    }
}

/// However rare and bright what is seen is: `balanced` and `difference` have the energy of uniform sampling with the same seed
/// and as many samples as are fair, whose expectation is known. Limit: rounding, 1e-5. `pooled`, the control, has another
/// energy in every run in which something was seen, since it moves samples there.
#[test]
fn fireflies_keep_their_energy() {
    const PIXELS: f64 = 1024.0;
    let (mut seen, mut control) = (0, 0);
    for seed in 0..200 {
        let pmc = Settings { seed, ..Settings::new(32, 32).for_frame(2, 16) };
        let mut adaptive = film(pmc, &[2048; 8], &mut Fireflies);
        let fair = pmc.fair.max(2);
        let uniform = Settings { seed, ..Settings::uniform(32, 32) };
        let chance = film(uniform, &[1024 * u64::from(fair)], &mut Fireflies);
        let energy = |film: &mut Film, estimator| sum(&film.resolve(estimator).unwrap()) / PIXELS;
        let chance = energy(&mut { chance }, Estimator::Pooled);
        for estimator in [Estimator::Balanced, Estimator::Difference] {
            let off = energy(&mut adaptive, estimator) / chance - 1.0;
            assert!(off.abs() < 1e-5, "seed {seed}, {estimator:?}: {off}");
        }
        if chance > 1.5 {
            seen += 1;
            control += u32::from((energy(&mut adaptive, Estimator::Pooled) / chance - 1.0).abs() > 1e-3);
        }
    }
    println!("fireflies among the fair samples of {seen} runs of 200; pooled is off in {control}");
    // Expected: 200 times 8192 samples at 1e-5, 16 ± 4.
    assert!(seen >= 4 && control > seen / 2, "{seen}, {control}");
}

/// Radiance that single precision holds in a few bits, down to its last: a mean is off by two of its steps an iteration at
/// most, and nothing is not a number.
#[test]
fn radiance_of_a_few_bits() {
    struct Faint;
    impl Integrand for Faint {
        fn radiance(&mut self, batch: &Batch8) -> Rgb8 {
            let bits = [0, 1, 3, 100, 4567, 8_000_000, 8_388_607, 8_388_608];
            let at = pixel(batch, 8.0).to_array().map(|pixel| f32::from_bits(bits[pixel as usize % 8]));
            grey(f32x8::from(at))
        }
    }
    let mut film = film(Settings::new(8, 8), &[256, 256, 256], &mut Faint);
    let step = f64::from(f32::from_bits(1));
    for estimator in [Estimator::Pooled, Estimator::Difference] {
        for (i, rgb) in film.resolve(estimator).unwrap().iter().enumerate() {
            let due = [0.0, 1.0, 3.0, 100.0, 4567.0, 8e6, 8_388_607.0, 8_388_608.0][i % 8] * step;
            for value in rgb {
                let off = (f64::from(*value) - due).abs() / step;
                assert!(
                    off <= 6.0 + due * 1e-6 / step,
                    "{estimator:?}, pixel {i}: {value:e}, off by {off} steps"
                );
            }
        }
    }
    assert!(film.resolve(Estimator::Balanced).unwrap().as_flattened().iter().all(|v| v.is_finite()));
    assert!(film.variance().unwrap().iter().all(|v| v.is_finite()));
}

/// Every pixel has its own constant, from 1e-30 to 1e15: nothing is lost on the way, in no estimator.
#[test]
fn forty_five_decades_in_one_picture() {
    let value = |pixel: f64| 10f64.powf(45.0 * pixel / 2047.0 - 30.0);
    let mut samples = |batch: &Batch8| {
        let lanes = pixel(batch, 64.0).to_array().map(|pixel| value(f64::from(pixel)) as f32);
        grey(lanes.into())
    };
    let mut film = film(Settings::new(64, 32).for_frame(2, 8), &[4096; 4], &mut samples);
    for estimator in [Estimator::Pooled, Estimator::Difference] {
        let picture = film.resolve(estimator).unwrap();
        for (i, rgb) in picture.iter().enumerate() {
            let error = f64::from(rgb[1]) / value(i as f64) - 1.0;
            assert!(error.abs() < 1e-6, "{estimator:?}, pixel {i}: off by {error}");
        }
    }
    let [balanced, difference] =
        [Estimator::Balanced, Estimator::Difference].map(|e| sum(&film.resolve(e).unwrap()));
    assert!((balanced / difference - 1.0).abs() < 1e-5, "{balanced} {difference}");
}

/// Without variance all pixels weigh the same; with all of it in one pixel that one gets what the floor leaves.
#[test]
fn all_of_the_variance_in_one_pixel_or_none() {
    let mut flat =
        film(Settings::new(40, 30).for_frame(2, 16), &[2400; 8], &mut |_: &Batch8| grey(f32x8::ONE));
    assert!(flat.count().unwrap().iter().all(|count| (14..=18).contains(count)));
    let noisy = |batch: &Batch8| {
        let here = pixel(batch, 40.0).simd_eq(f32x8::splat(617.0));
        grey(here.select(batch.point(1).0 * f32x8::splat(2.0), f32x8::ONE))
    };
    let mut one = film(Settings::new(40, 30).for_frame(2, 16), &[2400; 8], &mut { noisy });
    let count = one.count().unwrap();
    let others: u32 = count.iter().sum::<u32>() - count[617];
    // Windows of 3×3 pixels share what one of them has.
    assert!(count[617] > 500 && others > 2 * 1199, "{} {others}", count[617]);
    let [balanced, difference] =
        [Estimator::Balanced, Estimator::Difference].map(|e| sum(&one.resolve(e).unwrap()));
    assert!((balanced / difference - 1.0).abs() < 1e-5, "{balanced} {difference}");
}

/// A given kernel of one spike: all samples go there, and there are as many as were asked for.
#[test]
fn a_single_spike() {
    let settings = Settings::new(50, 20);
    let required = Sampler::required(50, 20);
    let (mut floats, mut words) = (vec![0.0; required.floats], vec![0; required.words]);
    let mut sampler = Sampler::new(settings, Memory { floats: &mut floats, words: &mut words }).unwrap();
    let mut alpha = vec![0.0; 1000];
    alpha[333] = 1.0;
    sampler.begin_predicted(12_345, Prior::Alpha(&alpha)).unwrap();
    let bounds: Vec<_> =
        sampler.jobs().map(|job| (job.samples(), job.bounds())).filter(|job| job.0 > 0).collect();
    assert_eq!(bounds.iter().map(|job| job.0).sum::<u64>(), 12_345);
    let (columns, rows) = &bounds[0].1;
    assert!(bounds.len() == 1 && columns.contains(&33) && rows.contains(&6), "{bounds:?}");
}

/// Fewer samples than pixels, none, and as many as an iteration may have.
#[test]
fn totals_from_nothing_to_the_most() {
    for (width, height, samples) in [(40, 25, 1), (40, 25, 999), (3, 3, u64::from(u32::MAX)), (1, 1, 1)] {
        let required = Sampler::required(width, height);
        let (mut floats, mut words) = (vec![0.0; required.floats], vec![0; required.words]);
        let memory = Memory { floats: &mut floats, words: &mut words };
        let mut sampler = Sampler::new(Settings::new(width, height), memory).unwrap();
        assert!(sampler.begin(0).is_err() && sampler.begin(1 << 32).is_err());
        sampler.begin(samples).unwrap();
        assert_eq!(sampler.jobs().map(|job| job.samples()).sum::<u64>(), samples);
    }
}

#[test]
fn pictures_of_one_pixel_row_or_column() {
    for (width, height) in [(1, 1), (1, 16_384), (16_384, 1)] {
        let pixels = u64::from(width * height);
        let mut film =
            film(Settings::new(width, height).for_frame(2, 8), &[2 * pixels; 4], &mut |batch: &Batch8| {
                grey(batch.point(1).0)
            });
        assert_eq!(film.count().unwrap().iter().map(|count| u64::from(*count)).sum::<u64>(), 8 * pixels);
        let [balanced, difference] =
            [Estimator::Balanced, Estimator::Difference].map(|e| sum(&film.resolve(e).unwrap()));
        assert!((balanced / difference - 1.0).abs() < 1e-5, "{width}×{height}: {balanced} {difference}");
    }
}

/// Light in other units, told to the film: the same samples, and the same picture in those units, to the bit.
#[test]
fn units_do_not_matter() {
    let render = |scale: f32| {
        let settings = Settings { cd_per_unit: 100.0 / scale, ..Settings::new(48, 40).for_frame(2, 16) };
        let mut samples = |batch: &Batch8| {
            let (u, v) = batch.point(1);
            grey(
                u * u
                    * v.simd_lt(batch.x * f32x8::splat(1.0 / 48.0)).select(f32x8::splat(scale), f32x8::ZERO),
            )
        };
        let mut film = film(settings, &[2 * 48 * 40; 8], &mut samples);
        let picture = film.resolve(Estimator::Balanced).unwrap();
        (film.count().unwrap(), picture.iter().map(|rgb| rgb[1] / scale).collect::<Vec<f32>>())
    };
    let (count, picture) = render(1.0);
    let (least, most) = (count.iter().min().unwrap(), count.iter().max().unwrap());
    assert!(most - least > 4, "{least} to {most}");
    // Powers of four, so that rounding is the same, of roots too: 2^±40 is 1e±12.
    for power in [-40, -12, 12, 40] {
        let (other, same) = render(2f32.powi(power));
        assert_eq!(count, other, "2^{power}");
        assert!(picture == same, "2^{power}");
    }
}

/// Rises but for the seam at 10^-1.44 cd/m², where the published pieces are 3 % apart (Ferwerda et al. 1996).
#[test]
fn the_threshold_of_vision_is_positive_and_rises() {
    let mut before = 0.0;
    for step in 0..=1700 {
        // 0, and 1e-5 to 1e12 cd/m².
        let luminance = if step == 0 { 0.0 } else { 10f32.powf(step as f32 / 100.0 - 5.0) };
        let threshold = tvi(f32x8::splat(luminance)).to_array()[0];
        assert!(
            threshold > 0.0 && threshold.is_finite() && threshold >= before * 0.97,
            "{luminance}: {threshold}"
        );
        before = threshold;
    }
    for odd in [f32::MIN_POSITIVE / 8.0, -1.0, f32::INFINITY] {
        let threshold = tvi(f32x8::splat(odd)).to_array()[0];
        assert!(threshold > 0.0, "{odd}: {threshold}");
    }
}

/// A plane seen at a grazing angle, whose horizon runs through the middles of pixels: where a pixel was has one clear answer.
/// In column x it was at h·x/(h − x), h the horizon's: inside of a picture w wide for x below h·w/(h + w). On and behind the
/// horizon it was nowhere; nothing there reaches the film.
#[test]
fn homographies_at_the_horizon() {
    const SIDE: usize = 64;
    let h = 32.5;
    let plane = Homography { matrix: [[h, 0.0, 0.0], [0.0, h, 0.0], [-1.0, 0.0, h]] };
    assert_eq!(plane.apply([h, 7.0]), None);
    assert_eq!(plane.apply([h.next_up(), 7.0]), None);
    let [x, y] = plane.apply([h.next_down(), 7.0]).unwrap();
    assert!(x.is_finite() && y.is_finite() && x > 1e15, "{x} {y}");
    let back = plane.inverse().unwrap();
    for x in [-1e6, -1.0, 0.5, 31.5, 32.499] {
        let [u, v] = back.apply(plane.apply([x, 3.0]).unwrap()).unwrap();
        assert!((u - x).abs() < 1e-9 * x.abs().max(1.0) && (v - 3.0).abs() < 1e-9, "{x}: {u} {v}");
    }
    // So near to the horizon that the place has no number; none of these may become one.
    for w in [5e-324, 1e-310, 0.0, -0.0, -5e-324, f64::NAN] {
        let near = Homography { matrix: [[1.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, 0.0, w]] };
        assert_eq!(near.apply([1e6, 1e6]), None, "{w}");
        assert!(near.inverse().is_none_or(|back| back.matrix.iter().flatten().all(|x| x.is_finite())));
        assert_eq!(near.error(&Pair { from: [1e6, 1e6], to: [0.0; 2] }), f64::INFINITY);
    }
    let tracks = Tracks { global: Some(plane), ..Tracks::default() };
    let mut positions = vec![[0.0; 2]; SIDE * SIDE];
    tracks.positions(&[u32::MAX; SIDE * SIDE], SIDE, SIDE, &mut positions).unwrap();
    let old = Belief { variance: 2.0, light: 1.0, freedom: 8.0 };
    let mut beliefs = vec![Belief::NONE; SIDE * SIDE];
    carry(&[old; SIDE * SIDE], SIDE, SIDE, &positions, Belief::NONE, &mut beliefs).unwrap();
    let inside = |x: f64| x < h * SIDE as f64 / (h + SIDE as f64);
    for (i, (position, belief)) in positions.iter().zip(&beliefs).enumerate() {
        let (x, y) = ((i % SIDE) as f64 + 0.5, (i / SIDE) as f64 + 0.5);
        let was_seen = inside(x) && h * y / (h - x) < SIDE as f64;
        assert_eq!(*belief, if was_seen { old } else { Belief::NONE }, "pixel {x}, {y}");
        assert_eq!(position.iter().any(|place| place.is_nan()), x >= h, "pixel {x}, {y}");
    }
    let mut film = Film::new(Settings::new(SIDE as u32, SIDE as u32).for_frame(2, 8)).unwrap();
    let pixels = film.pixels();
    for _ in 0..4 {
        film.begin_predicted(2 * pixels, Prior::Beliefs(&beliefs)).unwrap();
        film.render(&mut |batch: &Batch8| grey(batch.point(1).0)).unwrap();
        film.end().unwrap();
    }
    assert_eq!(film.count().unwrap().iter().map(|count| u64::from(*count)).sum::<u64>(), 8 * pixels);
    for estimator in [Estimator::Balanced, Estimator::Difference, Estimator::Pooled] {
        assert!(film.resolve(estimator).unwrap().as_flattened().iter().all(|value| value.is_finite()));
    }
}

/// The last points of a sequence are as good as the first: 2^16 of them from 2^32 − 2^16 on, one in each of 2^16 strips.
#[test]
fn the_last_sobol_points() {
    for set in [0, 5, u32::MAX] {
        let (mut across, mut down) = (vec![0u8; 1 << 16], vec![0u8; 1 << 16]);
        for first in (0..1u32 << 16).step_by(8) {
            let index = u32x8::from(core::array::from_fn(|lane| u32::MAX - 65_535 + first + lane as u32));
            let (u, v) = point(index, u32x8::splat(7), set);
            for (strip, value) in [(&mut across, u), (&mut down, v)] {
                value.to_array().iter().for_each(|x| strip[(x * 65_536.0) as usize] += 1);
            }
        }
        assert!(across.iter().chain(&down).all(|count| *count == 1), "set {set}");
    }
}

/// A room in millimetres and in megametres is the same room: the same light to a thousandth, with the same random numbers.
#[test]
fn scenes_of_any_scale() {
    let mean = |scale: f32| {
        let folder = tempfile::tempdir().unwrap();
        let corners = [
            [-1.0, -1.0, 0.0],
            [1.0, -1.0, 0.0],
            [1.0, 1.0, 0.0],
            [-1.0, 1.0, 0.0],
            [-1.0, -1.0, 2.0],
            [1.0, -1.0, 2.0],
            [-0.5, 1.0, 0.5],
            [0.5, 1.0, 0.5],
            [0.5, 1.0, 1.5],
            [-0.5, 1.0, 1.5],
        ];
        let vertices: String = corners
            .iter()
            .map(|[x, y, z]: &[f32; 3]| format!("v {:e} {:e} {:e}\n", x * scale, y * scale, z * scale))
            .collect();
        let obj =
            format!("mtllib r.mtl\n{vertices}usemtl wall\nf 1 2 3 4\nf 1 5 6 2\nusemtl lamp\nf 7 8 9 10\n");
        fs::write(folder.path().join("r.obj"), obj).unwrap();
        fs::write(folder.path().join("r.mtl"), "newmtl wall\nKd 0.7 0.7 0.7\nnewmtl lamp\nKe 9 9 9\n")
            .unwrap();
        let eye = format!("--look-from=0,0,{:e} --look-at=0,0,0 --fov 40", 5.0 * scale);
        success(
            folder.path(),
            &format!("render r.obj {eye} --size 48x48 --spp 16 --sampler uniform --light own --quiet"),
        );
        let picture = read_exr(&folder.path().join("r.exr")).unwrap();
        sum(&picture.rgb) / picture.rgb.len() as f64
    };
    let truth = mean(1.0);
    assert!(truth > 0.1, "{truth}");
    for scale in [1e-6, 1e-3, 1e3, 1e6] {
        let error = mean(scale) / truth - 1.0;
        println!("scale {scale:e}: light off by {error:+.1e}");
        assert!(error.abs() < 1e-3, "scale {scale:e}: {error}");
    }
}
