//! Is the default sampler unbiased? Energy of adaptive sampling on integrands of known mean, cell by cell.
//!
//! `cargo run --release -p measure -- bias [STANDARD_ERROR_IN_PERCENT [SPP…]]` prints a Markdown table: bias of `balanced`
//! (and so of `difference`, which has the same energy) and its standard error, with points that continue a sequence and
//! with fresh ones, and of `pooled` for comparison. Runs are repeated until the standard error is as asked for. From each run
//! of continued sequences that of a uniform render with the same seed is subtracted, whose points are nearly the scheduled
//! ones and whose expectation is known: common random numbers.

use pmcip_core::sampler::batch::{Batch8, Integrand, Rgb8};
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::{Memory, Sampler, Schedule, Sequence, Settings, Workspace};
use rayon::prelude::*;
use wide::f32x8;

const SIDE: u32 = 32;
const PIXELS: usize = (SIDE * SIDE) as usize;
/// Runs between two looks at the standard error.
const ROUND: u32 = 2048;
/// Runs after which it is left as it is: rare values at few samples would need millions.
const MOST: u32 = 1 << 17;

/// A function of a pixel's samples with mean 1.
#[derive(Clone, Copy)]
enum Function {
    /// 1/p with probability p, else 0.
    TwoValued(f32),
    /// Smooth in both coordinates.
    Smooth,
    /// 2 on one side of a slanted edge, 0 on the other.
    Edge,
    /// Two-valued, rarer to the right: p = 0.3/(1 + column).
    Mixed,
}

impl Integrand for Function {
    fn radiance(&mut self, batch: &Batch8) -> Rgb8 {
        let (u, v) = batch.point(1);
        let (one, two) = (f32x8::ONE, f32x8::splat(2.0));
        let rare = |p: f32x8| u.simd_lt(p) & (one / p);
        let value = match self {
            Function::TwoValued(p) => rare(f32x8::splat(*p)),
            Function::Smooth => two * u * (f32x8::HALF + v),
            Function::Edge => (u + v).simd_lt(one) & two,
            Function::Mixed => rare(f32x8::splat(0.3) / (one + batch.x.floor())),
        };
        Rgb8 { r: value, g: value, b: value }
    }
}

/// Mean of the picture by each estimator.
fn energies(function: Function, settings: Settings, schedule: Schedule, wanted: &[Estimator]) -> Vec<f64> {
    let required = Sampler::required(SIDE, SIDE);
    let (mut floats, mut words) = (vec![0.0; required.floats], vec![0; required.words]);
    let memory = Memory { floats: &mut floats, words: &mut words };
    let mut sampler = Sampler::new(settings, memory).expect("valid settings");
    let (mut batches, mut radiance) = ([Batch8::default(); 64], [Rgb8::default(); 64]);
    let mut work = Workspace::new(&mut batches, &mut radiance).expect("not empty");
    for samples in schedule {
        sampler.begin(samples).expect("samples");
        sampler.jobs().for_each(|mut job| {
            job.render(&mut { function }, &mut work);
        });
        sampler.end().expect("all rendered");
    }
    let mut scratch = vec![[0.0; 16]; Sampler::resolve_scratch(SIDE, SIDE)];
    let mut rgb = vec![0.0; 3 * PIXELS];
    let mut energy = |estimator: &Estimator| {
        sampler.resolve(*estimator, &mut scratch, &mut rgb).expect("right lengths");
        rgb.chunks_exact(3).map(|rgb| f64::from(rgb[1])).sum::<f64>() / PIXELS as f64
    };
    wanted.iter().map(&mut energy).collect()
}

/// Biases of the wanted estimators in one run, with what is known to be chance subtracted.
fn biases(function: Function, sequence: Sequence, spp: u32, seed: u32) -> [f64; 2] {
    let iterations = (spp / 2).clamp(1, 16);
    let pilot = spp / iterations;
    let adaptive = Settings { seed, sequence, ..Settings::new(SIDE, SIDE) }.for_frame(pilot, spp);
    let fair = adaptive.fair.max(pilot);
    let schedule = Schedule::new(PIXELS as u64, spp, pilot, iterations);
    let found = energies(function, adaptive, schedule, &[Estimator::Balanced, Estimator::Pooled]);
    let chance = match sequence {
        Sequence::Fresh => 1.0,
        Sequence::Continued => {
            let uniform = Settings { seed, ..Settings::uniform(SIDE, SIDE) };
            let schedule = Schedule::new(PIXELS as u64, fair, fair, 1);
            energies(function, uniform, schedule, &[Estimator::Pooled])[0]
        }
    };
    [found[0] - chance, found[1] - chance]
}

/// Mean and standard error of both biases in percent.
fn measure(function: Function, sequence: Sequence, spp: u32, error: f64) -> [(f64, f64); 2] {
    let mut sums = [[0.0; 2]; 2];
    let mut runs = 0;
    loop {
        let biases: Vec<[f64; 2]> =
            (runs..runs + ROUND).into_par_iter().map(|seed| biases(function, sequence, spp, seed)).collect();
        runs += ROUND;
        for biases in biases {
            for (sums, bias) in sums.iter_mut().zip(biases) {
                (sums[0], sums[1]) = (sums[0] + bias, sums[1] + bias * bias);
            }
        }
        let n = f64::from(runs);
        let found = sums.map(|[sum, squares]| {
            let (mean, square) = (sum / n, squares / n);
            (100.0 * mean, 100.0 * ((square - mean * mean) / (n - 1.0)).sqrt())
        });
        if found[0].1 <= error || runs >= MOST {
            return found;
        }
    }
}

/// Prints the table.
pub fn run(arguments: &[String]) {
    let mut arguments = arguments.iter();
    let error = arguments.next().map_or(0.02, |a| a.parse().expect("a number"));
    let rest: Vec<u32> = arguments.map(|a| a.parse().expect("a whole number")).collect();
    let spps = if rest.is_empty() { vec![4, 8, 16, 64, 256] } else { rest };
    let two = [0.5, 0.3, 0.2, 0.1, 0.03, 0.01, 0.003].map(|p| (format!("p = {p}"), Function::TwoValued(p)));
    let others =
        [("smooth", Function::Smooth), ("edge", Function::Edge), ("p = 0.3/column", Function::Mixed)];
    let others = others.map(|(name, function)| (name.to_string(), function));
    println!("| integrand | spp | continued | in errors | fresh | in errors | pooled |");
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    for spp in spps {
        for (name, function) in two.iter().chain(&others) {
            let [continued, pooled] = measure(*function, Sequence::Continued, spp, error);
            let [fresh, _] = measure(*function, Sequence::Fresh, spp, error);
            let cell = |(bias, error): (f64, f64)| format!("{bias:+.3} ± {error:.3} %");
            // Where nothing is left to chance the rest is rounding.
            let errors = |(bias, error): (f64, f64)| format!("{:+.1}", bias / error.max(1e-4));
            println!(
                "| {name} | {spp} | {} | {} | {} | {} | {} |",
                cell(continued),
                errors(continued),
                cell(fresh),
                errors(fresh),
                cell(pooled)
            );
        }
    }
}
