//! The sampler's own cost by the size of the picture: nanoseconds a pixel to begin and to resolve, beside a plain
//! pass that reads and writes the same bytes, and nanoseconds a sample to hand out and accept. One thread; then, to begin and
//! to resolve, several.
//!
//! `cargo run --release -p measure -- overhead [RUNS [SPP [THREADS]]]` prints a Markdown table of medians; the sides of each
//! row alternate, so that a noisy machine hurts them alike. THREADS is 2 unless told.

use pmcip_core::predict::Prior;
use pmcip_core::sampler::batch::{Batch8, Integrand, Rgb8};
use pmcip_core::sampler::film::BYTES_PER_PIXEL;
use pmcip_core::sampler::{Memory, Sampler, Settings, Workspace};
use rayon::iter::{ParallelBridge, ParallelIterator};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::hint::black_box;
use std::time::Instant;

const SIZES: [(u32, u32); 5] = [(256, 256), (512, 512), (1024, 1024), (1920, 1080), (4096, 4096)];

/// Noise everywhere, so that no shortcut is taken; costs next to nothing itself.
struct Noise;

impl Integrand for Noise {
    fn radiance(&mut self, batch: &Batch8) -> Rgb8 {
        let value = batch.x - batch.x.floor();
        Rgb8 { r: value, g: value, b: value }
    }
}

/// Nanoseconds of each step: a pixel, but `samples` a sample.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Cost {
    pub begin: f64,
    pub samples: f64,
    pub resolve: f64,
    pub plain: f64,
}

/// Prints the table.
pub fn run(arguments: &[String]) {
    let mut arguments = arguments.iter().map(|a| a.parse::<usize>().expect("a whole number"));
    let runs = arguments.next().unwrap_or(15).max(1);
    let spp = arguments.next().unwrap_or(2).max(1);
    let threads = arguments.next().unwrap_or(2).max(1);
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    println!(
        "| size | begin ns/px | resolve ns/px | plain pass ns/px | ratio | ns/sample | film, scratch bytes/px \
         | begin, {threads} threads | resolve, {threads} threads |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    for (width, height) in SIZES {
        // As many pixels for the small sizes as for the large ones.
        let repeat = (1920 * 1080 / (width * height) as usize).clamp(1, 32);
        let pixels = f64::from(width * height);
        let costs = measure(width, height, runs.max(3) * repeat, spp as u64, &pool);
        let median = |of: fn(&Cost) -> f64| median(costs.iter().map(|[one, _]| of(one)).collect());
        let many = |of: fn(&Cost) -> f64| self::median(costs.iter().map(|[_, many]| of(many)).collect());
        let own = median(|c| c.begin + c.resolve);
        let plain = median(|c| c.plain);
        println!(
            "| {width}×{height} | {:.2} | {:.2} | {plain:.2} | {:.2} | {:.1} | {BYTES_PER_PIXEL} + {:.2} \
             | {:.2} | {:.2} |",
            median(|c| c.begin),
            median(|c| c.resolve),
            own / plain,
            median(|c| c.samples),
            64.0 * Sampler::resolve_scratch(width, height) as f64 / pixels,
            many(|c| c.begin),
            many(|c| c.resolve),
        );
    }
}

/// On one thread and on those of the pool, by turns.
fn measure(width: u32, height: u32, runs: usize, spp: u64, pool: &ThreadPool) -> Vec<[Cost; 2]> {
    let mut film = Film::new(width, height, None);
    film.run(spp); // The first iteration is uniform.
    (0..runs).map(|_| [film.run(spp), film.run_on(Some(pool), spp)]).collect()
}

/// A film with all that its iterations need.
pub(crate) struct Film {
    sampler: Sampler<'static>,
    batches: Vec<Batch8>,
    radiance: Vec<Rgb8>,
    scratch: Vec<[f32; 16]>,
    rgb: Vec<f32>,
    plain: Plain,
}

impl Film {
    pub(crate) fn new(width: u32, height: u32, labels: Option<&[u16]>) -> Film {
        let pixels = (width * height) as usize;
        let required = match labels {
            None => Sampler::required(width, height),
            Some(_) => Sampler::required_with_labels(width, height),
        };
        // There are few films, and they last as long as the program.
        let (floats, words) = (vec![0.0; required.floats].leak(), vec![0; required.words].leak());
        let (settings, memory) = (Settings::new(width, height), Memory { floats, words });
        let sampler = match labels {
            None => Sampler::new(settings, memory),
            Some(labels) => Sampler::with_labels(settings, memory, labels),
        };
        Film {
            sampler: sampler.expect("valid settings"),
            batches: vec![Batch8::default(); 256],
            radiance: vec![Rgb8::default(); 256],
            scratch: vec![[0.0; 16]; Sampler::resolve_scratch(width, height)],
            rgb: vec![0.0; 3 * pixels],
            plain: Plain::new(pixels),
        }
    }

    /// Runs an iteration of `spp` samples a pixel and reads the picture.
    pub(crate) fn run(&mut self, spp: u64) -> Cost {
        self.run_on(None, spp)
    }

    /// The same; where there is a pool its threads begin and resolve.
    fn run_on(&mut self, pool: Option<&ThreadPool>, spp: u64) -> Cost {
        let Film { sampler, batches, radiance, scratch, rgb, plain } = self;
        let mut work = Workspace::new(batches, radiance).expect("not empty");
        let pixels = rgb.len() as u64 / 3;
        let time = |count: u64, f: &mut dyn FnMut()| {
            let start = Instant::now();
            f();
            start.elapsed().as_secs_f64() * 1e9 / count as f64
        };
        let begin = time(pixels, &mut || begin(pool, sampler, spp * pixels));
        let samples = time(spp * pixels, &mut || {
            sampler.jobs().for_each(|mut job| _ = job.render(&mut Noise, &mut work));
        });
        let end = time(pixels, &mut || _ = sampler.end().expect("all jobs were rendered"));
        let resolve = time(pixels, &mut || resolve(pool, sampler, scratch, rgb));
        let plain = time(pixels, &mut || plain.pass());
        Cost { begin: begin + end, samples, resolve, plain }
    }
}

/// Begins an iteration on all threads of the pool, on this one alone if there is none.
fn begin(pool: Option<&ThreadPool>, sampler: &mut Sampler<'_>, samples: u64) {
    let Some(pool) = pool else { return sampler.begin(samples).expect("none is running") };
    pool.install(|| {
        let mut beginning = sampler.beginning(samples, Prior::Beliefs(&[])).expect("none is running");
        while let Some(parts) = beginning.parts() {
            parts.par_bridge().for_each(|mut part| part.work());
        }
    });
}

/// Makes the picture likewise.
fn resolve(pool: Option<&ThreadPool>, sampler: &Sampler<'_>, scratch: &mut [[f32; 16]], rgb: &mut [f32]) {
    let estimator = sampler.settings().estimator;
    let Some(pool) = pool else {
        return sampler.resolve(estimator, scratch, rgb).expect("memory suffices");
    };
    pool.install(|| {
        let mut resolving = sampler.resolving(estimator, scratch, rgb).expect("memory suffices");
        while let Some(parts) = resolving.parts() {
            parts.par_bridge().for_each(|mut part| part.work());
        }
    });
}

/// Planes like the film's.
struct Plain {
    read: [Vec<f32>; 8],
    written: [Vec<f32>; 2],
    rgb: Vec<[f32; 3]>,
}

impl Plain {
    fn new(pixels: usize) -> Plain {
        let plane = || vec![1.0; pixels];
        Plain { read: [(); 8].map(|()| plane()), written: [plane(), plane()], rgb: vec![[0.0; 3]; pixels] }
    }

    /// What `begin` and `resolve` read and write, and nothing computed: the bound of memory.
    fn pass(&mut self) {
        let [count, r, g, b, m2, x, y, z] = &self.read;
        let [target, planned] = &mut self.written;
        for i in 0..count.len() {
            target[i] = count[i] + m2[i];
            planned[i] = r[i] + g[i] + b[i];
        }
        for (i, rgb) in self.rgb.iter_mut().enumerate() {
            *rgb = [r[i] + x[i], g[i] + y[i], b[i] + z[i]];
        }
        black_box((&mut self.written, &mut self.rgb));
    }
}

pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
