//! The loop: same bits in any order and any workspace, exact counts, refused misuse, rejected samples.

use pmcip_core::sampler::batch::{Batch8, Integrand, Rgb8};
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::film::BYTES_PER_PIXEL;
use pmcip_core::sampler::{
    Error, Job, Memory, Mode, Sampler, Schedule, Sequence, Settings, Tally, Workspace,
};
use wide::f32x8;

mod parts;

/// A disc of noise on a calm slope.
#[derive(Clone, Copy)]
struct Disc;

impl Integrand for Disc {
    fn radiance(&mut self, batch: &Batch8) -> Rgb8 {
        let (u, v) = batch.point(1);
        let (x, y) = (batch.x - f32x8::splat(20.0), batch.y - f32x8::splat(15.0));
        let noise = (x * x + y * y).simd_lt(f32x8::splat(90.0)) & (u * f32x8::splat(9.0));
        Rgb8 { r: batch.x * f32x8::splat(0.1) + noise, g: noise + v, b: u }
    }
}

struct Lent {
    floats: Vec<f32>,
    words: Vec<u32>,
}

impl Lent {
    fn new(settings: &Settings) -> Lent {
        let required = Sampler::required(settings.width, settings.height);
        Lent { floats: vec![f32::NAN; required.floats], words: vec![77; required.words] }
    }

    fn sampler(&mut self, settings: Settings) -> Sampler<'_> {
        Sampler::new(settings, Memory { floats: &mut self.floats, words: &mut self.words }).unwrap()
    }
}

/// Renders all iterations, each one's jobs by `work`, and returns everything that can be read out.
fn outcome(settings: Settings, mut work: impl FnMut(Vec<Job>)) -> (Vec<u32>, Vec<u32>) {
    let mut lent = Lent::new(&settings);
    let mut sampler = lent.sampler(settings);
    let pixels = (settings.width * settings.height) as usize;
    for samples in Schedule::new(pixels as u64, 12, 2, 6) {
        sampler.begin(samples).unwrap();
        work(sampler.jobs().collect());
        sampler.end().unwrap();
    }
    let mut scratch = vec![[0.0; 16]; Sampler::resolve_scratch(settings.width, settings.height)];
    let (mut rgb, mut alpha, mut variance) = (vec![0.0; 3 * pixels], vec![0.0; pixels], vec![0.0; pixels]);
    let mut count = vec![0; pixels];
    sampler.resolve(settings.estimator, &mut scratch, &mut rgb).unwrap();
    sampler.alpha(&mut alpha).unwrap();
    sampler.variance(&mut variance).unwrap();
    sampler.count(&mut count).unwrap();
    assert_eq!(count.iter().map(|n| u64::from(*n)).sum::<u64>(), 12 * pixels as u64);
    let sum: f64 = alpha.iter().map(|a| f64::from(*a)).sum();
    assert!((sum - 1.0).abs() < 1e-5, "alpha sums to {sum}");
    (rgb.iter().chain(&alpha).chain(&variance).map(|v: &f32| v.to_bits()).collect(), count)
}

fn render(job: &mut Job, batches: usize) -> Tally {
    let (mut batches, mut radiance) = (vec![Batch8::default(); batches], vec![Rgb8::default(); batches + 3]);
    job.render(&mut Disc, &mut Workspace::new(&mut batches, &mut radiance).unwrap())
}

#[test]
fn order_threads_workspace_and_own_loop_do_not_matter() {
    for estimator in [Estimator::Balanced, Estimator::Subframe] {
        let settings = Settings { estimator, seed: 5, ..Settings::new(133, 70) };
        let forward = outcome(settings, |jobs| {
            assert!(jobs.len() > 1);
            jobs.into_iter().for_each(|mut job| {
                render(&mut job, 100);
            });
        });
        let backward = outcome(settings, |jobs| {
            jobs.into_iter().rev().for_each(|mut job| {
                render(&mut job, 1);
            });
        });
        let threads = outcome(settings, |jobs| {
            std::thread::scope(|scope| {
                jobs.into_iter().for_each(|mut job| {
                    scope.spawn(move || render(&mut job, 7));
                });
            });
        });
        let own = outcome(settings, |jobs| jobs.into_iter().for_each(|mut job| own_loop(&mut job)));
        assert!(forward == backward && forward == threads && forward == own);
        let other = outcome(Settings { frame: 1, ..settings }, |jobs| {
            jobs.into_iter().for_each(|mut job| {
                render(&mut job, 100);
            });
        });
        assert!(forward != other, "another frame has the same noise");
    }
}

fn own_loop(job: &mut Job) {
    let mut batches = [Batch8::default(); 5];
    loop {
        let used = job.fill(&mut batches);
        if used == 0 {
            return;
        }
        for batch in &batches[..used] {
            job.accept(&[Disc.radiance(batch)]);
        }
        job.accept(&[Rgb8::default()]); // superfluous
    }
}

#[test]
fn samples_follow_the_noise() {
    let settings = Settings::new(40, 30);
    let (_, count) = outcome(settings, |jobs| {
        jobs.into_iter().for_each(|mut job| {
            render(&mut job, 64);
        })
    });
    let block = |x0: usize, y0: usize| -> u32 {
        (y0..y0 + 6).map(|y| count[y * 40 + x0..y * 40 + x0 + 6].iter().sum::<u32>()).sum()
    };
    let (inside, outside) = (block(17, 12), block(2, 2));
    assert!(inside > 2 * outside, "{inside} in the disc, {outside} outside");
}

#[test]
fn every_size_and_variant_works() {
    for (width, height) in [(1, 1), (1, 40), (17, 1), (16, 16), (33, 31)] {
        for settings in
            [Settings::new(width, height), Settings::paper(width, height), Settings::uniform(width, height)]
        {
            for sequence in [Sequence::Fresh, Sequence::Continued] {
                let (values, _) = outcome(Settings { sequence, ..settings }, |jobs| {
                    jobs.into_iter().for_each(|mut job| {
                        render(&mut job, 9);
                    });
                });
                assert!(values.iter().all(|v| f32::from_bits(*v).is_finite()));
            }
        }
    }
}

/// Positions lie inside their pixel, keys and numbers never repeat.
#[test]
fn every_sample_is_another_one_inside_its_pixel() {
    for sequence in [Sequence::Continued, Sequence::Fresh] {
        let settings = Settings { sequence, ..Settings::new(21, 19) };
        let mut lent = Lent::new(&settings);
        let mut sampler = lent.sampler(settings);
        let mut seen = std::collections::HashSet::new();
        for samples in [798, 1201, 3] {
            sampler.begin(samples).unwrap();
            let mut found = 0;
            for mut job in sampler.jobs() {
                let mut batch = [Batch8::default()];
                while job.fill(&mut batch) == 1 {
                    let (index, key) = (batch[0].index.to_array(), batch[0].key.to_array());
                    for lane in 0..batch[0].lanes as usize {
                        assert!(seen.insert((index[lane], key[lane])), "sample repeated");
                    }
                    assert!(batch[0].x.to_array().iter().all(|x| (0.0..21.0).contains(x)));
                    assert!(batch[0].y.to_array().iter().all(|y| (0.0..19.0).contains(y)));
                    found += u64::from(batch[0].lanes);
                    job.accept(&[Disc.radiance(&batch[0])]);
                }
            }
            assert_eq!(found, samples);
            sampler.end().unwrap();
        }
    }
}

/// An integrand that fails in the left half of the picture.
struct Broken(f32);

impl Integrand for Broken {
    fn radiance(&mut self, batch: &Batch8) -> Rgb8 {
        let value = batch.x.simd_lt(f32x8::splat(8.0)).bitselect(f32x8::splat(self.0), f32x8::ONE);
        Rgb8 { r: f32x8::ONE, g: value, b: f32x8::ONE }
    }
}

#[test]
fn unusable_samples_are_counted_and_stay_out() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e16] {
        for estimator in [Estimator::Pooled, Estimator::Subframe, Estimator::Balanced] {
            let settings = Settings { estimator, ..Settings::new(16, 8) };
            let mut lent = Lent::new(&settings);
            let mut sampler = lent.sampler(settings);
            let (mut batches, mut radiance) = ([Batch8::default(); 4], [Rgb8::default(); 4]);
            let mut work = Workspace::new(&mut batches, &mut radiance).unwrap();
            let mut total = Tally::default();
            for _ in 0..3 {
                sampler.begin(256).unwrap();
                for mut job in sampler.jobs() {
                    total += job.render(&mut Broken(bad), &mut work);
                }
                assert_eq!(sampler.end().unwrap(), total);
            }
            assert_eq!(total.samples + total.rejected, 768);
            assert!(total.rejected >= 256);
            let mut rgb = [0.0; 3 * 128];
            let mut scratch = vec![[0.0; 16]; Sampler::resolve_scratch(16, 8)];
            sampler.resolve(estimator, &mut scratch, &mut rgb).unwrap();
            assert!(rgb.iter().all(|v| v.is_finite()));
        }
    }
}

#[test]
fn misuse_is_refused() {
    let settings = Settings::new(16, 16);
    let required = Sampler::required(16, 16);
    assert_eq!(4 * (required.floats + required.words), BYTES_PER_PIXEL * 256);
    let try_new = |settings, floats, words| {
        let (mut floats, mut words) = (vec![0.0; floats], vec![0; words]);
        Sampler::new(settings, Memory { floats: &mut floats, words: &mut words }).err()
    };
    let with = |change: fn(&mut Settings)| {
        let mut settings = settings;
        change(&mut settings);
        try_new(settings, required.floats, required.words)
    };
    assert_eq!(try_new(settings, required.floats - 1, required.words), Some(Error::Memory));
    assert_eq!(try_new(settings, required.floats, required.words - 1), Some(Error::Memory));
    assert_eq!(with(|s| s.width = 0), Some(Error::Size));
    assert_eq!(with(|s| s.height = 16_385), Some(Error::Size));
    assert_eq!(with(|s| s.cd_per_unit = 0.0), Some(Error::CdPerUnit));
    assert_eq!(with(|s| s.gamma = f32::NAN), Some(Error::Gamma));
    assert_eq!(with(|s| s.epsilon = -0.1), Some(Error::Epsilon));
    assert_eq!(with(|s| s.defensive = 1.1), Some(Error::Defensive));
    assert_eq!(with(|s| s.balance_radius = u32::MAX), Some(Error::BalanceRadius));
    assert_eq!(Workspace::new(&mut [], &mut [Rgb8::default()]).err(), Some(Error::Workspace));
    assert_eq!(Workspace::new(&mut [Batch8::default()], &mut []).err(), Some(Error::Workspace));
    assert_eq!(Sampler::required(u32::MAX, u32::MAX).floats, usize::MAX);
}

#[test]
fn the_order_of_calls_is_checked() {
    let settings = Settings { estimator: Estimator::Subframe, ..Settings::new(16, 16) };
    let mut lent = Lent::new(&settings);
    let mut sampler = lent.sampler(settings);
    assert_eq!(sampler.end(), Err(Error::NotBegun));
    assert_eq!(sampler.jobs().count(), 0);
    assert_eq!(sampler.begin(0), Err(Error::Samples));
    assert_eq!(sampler.begin(1 << 32), Err(Error::Samples));
    assert_eq!(sampler.begin(512), Ok(()));
    assert_eq!(sampler.begin(512), Err(Error::Begun));
    assert_eq!(sampler.end(), Err(Error::Unfinished));
    sampler.jobs().for_each(|mut job| {
        render(&mut job, 3);
    });
    assert!(sampler.end().is_ok());
    let mut rgb = [0.0; 768];
    let mut scratch = vec![[0.0; 16]; Sampler::resolve_scratch(16, 16)];
    assert_eq!(sampler.resolve(Estimator::Balanced, &mut scratch, &mut rgb), Err(Error::Estimator));
    assert_eq!(sampler.resolve(Estimator::Pooled, &mut scratch[1..], &mut rgb), Err(Error::Scratch));
    assert_eq!(sampler.resolve(Estimator::Pooled, &mut scratch, &mut rgb[1..]), Err(Error::Output));
    assert_eq!(sampler.variance(&mut rgb), Err(Error::Output));
    sampler.begin(512).unwrap();
    let mut numbers = [0; 256];
    assert_eq!(sampler.resolve(Estimator::Pooled, &mut scratch, &mut rgb), Err(Error::Running));
    assert_eq!(sampler.variance(&mut rgb[..256]), Err(Error::Running));
    assert_eq!(sampler.count(&mut numbers), Err(Error::Running));
}

/// A job that is rendered twice cannot stand for one that was left out: what is in the film is not handed out again.
#[test]
fn every_job_is_rendered_exactly_once() {
    let settings = Settings { mode: Mode::Uniform, ..Settings::new(64, 64) };
    let mut lent = Lent::new(&settings);
    let mut sampler = lent.sampler(settings);
    sampler.begin(4 * 4096).unwrap();
    assert!(sampler.jobs().count() > 2);
    for _ in 0..2 {
        render(&mut sampler.jobs().next().unwrap(), 3);
        assert_eq!(sampler.end(), Err(Error::Unfinished));
    }
    sampler.jobs().skip(1).for_each(|mut job| {
        render(&mut job, 3);
    });
    assert_eq!(sampler.end(), Err(Error::Unfinished));
    let left: u64 = sampler.jobs().map(|mut job| render(&mut job, 3).samples).sum();
    assert!(left > 0);
    assert_eq!(sampler.jobs().map(|job| job.samples()).sum::<u64>(), 0);
    assert_eq!(sampler.end().unwrap().samples, 4 * 4096);
    let mut count = vec![0; 4096];
    sampler.count(&mut count).unwrap();
    assert!(count.iter().all(|n| *n == 4));
}

/// A noisy disc on black ground.
struct Lamp;

impl Integrand for Lamp {
    fn radiance(&mut self, batch: &Batch8) -> Rgb8 {
        let (u, _) = batch.point(1);
        let (x, y) = (batch.x - f32x8::splat(20.0), batch.y - f32x8::splat(15.0));
        let light = (x * x + y * y).simd_lt(f32x8::splat(90.0)) & (u * u * u * f32x8::splat(9.0));
        Rgb8 { r: light, g: light, b: light }
    }
}

#[test]
fn balancing_gives_to_the_bright_and_nothing_to_the_black() {
    let settings = Settings { seed: 3, ..Settings::new(61, 40) };
    let mut lent = Lent::new(&settings);
    let mut sampler = lent.sampler(settings);
    for samples in Schedule::new(61 * 40, 12, 2, 6) {
        sampler.begin(samples).unwrap();
        let (mut batches, mut radiance) = (vec![Batch8::default(); 9], vec![Rgb8::default(); 9]);
        let mut work = Workspace::new(&mut batches, &mut radiance).unwrap();
        sampler.jobs().for_each(|mut job| {
            job.render(&mut Lamp, &mut work);
        });
        sampler.end().unwrap();
    }
    let mut scratch = vec![[0.0; 16]; Sampler::resolve_scratch(61, 40)];
    let [balanced, difference, pooled] =
        [Estimator::Balanced, Estimator::Difference, Estimator::Pooled].map(|estimator| {
            let mut rgb = vec![0.0; 3 * 61 * 40];
            sampler.resolve(estimator, &mut scratch, &mut rgb).unwrap();
            rgb
        });
    let energy = |rgb: &[f32]| rgb.iter().map(|v| f64::from(*v)).sum::<f64>();
    assert!((energy(&balanced) / energy(&difference) - 1.0).abs() < 1e-5);
    assert!((energy(&pooled) / energy(&difference) - 1.0).abs() > 1e-4, "nothing to give back: no test");
    let black = balanced.iter().zip(&pooled).filter(|(_, pooled)| **pooled == 0.0);
    assert!(black.clone().count() > 1000 && black.clone().all(|(balanced, _)| *balanced == 0.0));
}
