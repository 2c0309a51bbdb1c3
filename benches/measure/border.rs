//! What the border to C costs: nanoseconds a sample through the functions that `pmcip-capi` exports, and through the core, the
//! same integrand in both, by how many samples are handed over at once. One thread.
//!
//! `cargo run --release -p measure -- border [RUNS]` prints a Markdown table of medians; the two sides take turns, so that a
//! noisy machine hurts them alike. C calls by address, as it does from a library, so that nothing is inlined. Both films must
//! have the same bits in the end.

use crate::overhead::median;
use pmcip_capi::{Film, PmcipEstimator, PmcipJob, PmcipJobs, PmcipSettings, PmcipStatus};
use pmcip_core::sampler::wave::{self, Wave};
use pmcip_core::sampler::{Estimator, Memory, Sampler, Settings};
use std::ffi::c_void;
use std::hint::black_box;
use std::ptr;
use std::time::Instant;

const SIDE: u32 = 256;
const PIXELS: usize = (SIDE * SIDE) as usize;
/// Samples of an iteration.
const SAMPLES: u64 = 4 * PIXELS as u64;
const ROOMS: [usize; 4] = [8, 64, 512, 4096];

/// Prints the table.
pub fn run(arguments: &[String]) {
    let runs = arguments.first().map_or(101, |runs| runs.parse().expect("a whole number"));
    println!("| samples a call | core ns/sample | C ns/sample | C ÷ core |");
    println!("| --- | --- | --- | --- |");
    for room in ROOMS {
        let (core, c, ratio) = measure(room, runs.max(1));
        println!("| {room} | {core:.2} | {c:.2} | {ratio:.3} |");
    }
}

/// Medians of both sides and of their ratio.
fn measure(room: usize, runs: usize) -> (f64, f64, f64) {
    let required = Sampler::required(SIDE, SIDE);
    let (mut floats, mut words) = (vec![0.0; required.floats], vec![0; required.words]);
    let memory = Memory { floats: &mut floats, words: &mut words };
    let mut core = Sampler::new(Settings::new(SIDE, SIDE), memory).expect("valid settings");
    let mut c = CFilm::new();
    let mut arrays = Arrays::new(room);
    let mut time = |work: &mut dyn FnMut(&mut Arrays)| {
        let start = Instant::now();
        work(&mut arrays);
        start.elapsed().as_secs_f64() * 1e9 / SAMPLES as f64
    };
    let times: Vec<[f64; 2]> = (0..=runs)
        .map(|_| {
            core.begin(SAMPLES).expect("none is running");
            c.begin();
            let times =
                [time(&mut |arrays| by_core(&mut core, arrays)), time(&mut |arrays| c.sample(arrays))];
            core.end().expect("all was delivered");
            c.end();
            times
        })
        .collect();
    let mut scratch = vec![[0.0; 16]; Sampler::resolve_scratch(SIDE, SIDE)];
    let mut rgb = vec![0.0; 3 * PIXELS];
    core.resolve(Estimator::Balanced, &mut scratch, &mut rgb).expect("memory suffices");
    assert!(rgb.iter().map(|v| v.to_bits()).eq(c.resolve().iter().map(|v| v.to_bits())), "other bits");
    // The first iteration is uniform.
    let of = |f: fn(&[f64; 2]) -> f64| median(times[1..].iter().map(f).collect());
    (of(|t| t[0]), of(|t| t[1]), of(|t| t[1] / t[0]))
}

/// What goes to and fro.
struct Arrays {
    floats: [Vec<f32>; 4],
    words: [Vec<u32>; 2],
    rgb: Vec<[f32; 3]>,
}

impl Arrays {
    fn new(room: usize) -> Arrays {
        Arrays {
            floats: [(); 4].map(|()| vec![0.0; room]),
            words: [(); 2].map(|()| vec![0; room]),
            rgb: vec![[0.0; 3]; room],
        }
    }

    /// A ramp with noise that grows to the right.
    fn shade(&mut self, samples: usize) {
        let [x, y, u, v] = self.floats.each_ref().map(|values| &values[..samples]);
        for (i, rgb) in self.rgb[..samples].iter_mut().enumerate() {
            *rgb = [x[i] * u[i], y[i] * v[i], u[i] + v[i]];
        }
    }
}

/// All samples of an iteration.
fn by_core(sampler: &mut Sampler<'_>, arrays: &mut Arrays) {
    for mut job in sampler.jobs() {
        loop {
            let ([x, y, u, v], [index, key]) = (&mut arrays.floats, &mut arrays.words);
            let samples = job.plan(&mut Wave { x, y, index, key });
            if samples == 0 {
                break;
            }
            wave::points(1, &index[..samples], &key[..samples], &mut u[..samples], &mut v[..samples]);
            arrays.shade(samples);
            job.deliver(&arrays.rgb[..samples]);
        }
    }
}

type Begin = unsafe extern "C" fn(*mut Film, *mut c_void, usize, *mut *mut PmcipJobs) -> PmcipStatus;
type Next = unsafe extern "C" fn(*mut PmcipJobs, *mut c_void, usize, *mut *mut PmcipJob) -> PmcipStatus;
type Plan = unsafe extern "C" fn(
    *mut PmcipJob,
    usize,
    *mut f32,
    *mut f32,
    *mut u32,
    *mut u32,
    *mut usize,
) -> PmcipStatus;
type Points = unsafe extern "C" fn(u32, usize, *const u32, *const u32, *mut f32, *mut f32) -> PmcipStatus;
type Deliver = unsafe extern "C" fn(*mut PmcipJob, *const f32, usize) -> PmcipStatus;

/// What is called for every batch, by address.
#[derive(Clone, Copy)]
struct Calls {
    jobs_begin: Begin,
    jobs_next: Next,
    plan: Plan,
    points: Points,
    deliver: Deliver,
}

const CALLS: Calls = Calls {
    jobs_begin: pmcip_capi::pmcip_jobs_begin,
    jobs_next: pmcip_capi::pmcip_jobs_next,
    plan: pmcip_capi::pmcip_job_plan,
    points: pmcip_capi::pmcip_points,
    deliver: pmcip_capi::pmcip_job_deliver,
};

/// A film behind the border.
struct CFilm {
    film: *mut Film,
    /// Of the film, of the iteration's jobs, and of a job.
    memory: [Vec<u64>; 3],
}

impl CFilm {
    fn new() -> CFilm {
        let sizes = [
            pmcip_capi::pmcip_film_size(SIDE, SIDE, 0),
            pmcip_capi::pmcip_jobs_size(),
            pmcip_capi::pmcip_job_size(),
        ];
        let mut made = CFilm { film: ptr::null_mut(), memory: sizes.map(|size| vec![0; size.div_ceil(8)]) };
        let settings = PmcipSettings::from(Settings::new(SIDE, SIDE));
        let (memory, size) = lend(&mut made.memory[0]);
        // SAFETY: the film's memory lives as long as the film, and nobody else uses it.
        ok(unsafe { pmcip_capi::pmcip_film_create(memory, size, &settings, ptr::null(), &mut made.film) });
        made
    }

    fn begin(&mut self) {
        // SAFETY: a film, which no other call takes.
        ok(unsafe { pmcip_capi::pmcip_film_begin(self.film, SAMPLES) });
    }

    fn end(&mut self) {
        // SAFETY: a film, which no other call takes.
        ok(unsafe { pmcip_capi::pmcip_film_end(self.film, ptr::null_mut()) });
    }

    /// As [`by_core`].
    fn sample(&mut self, arrays: &mut Arrays) {
        let [_, of_jobs, of_job] = &mut self.memory;
        let Calls { jobs_begin, jobs_next, plan, points, deliver } = black_box(CALLS);
        let (mut jobs, mut job) = (ptr::null_mut(), ptr::null_mut());
        let (memory, size) = lend(of_jobs);
        // SAFETY: a film, which no other call takes until its jobs are done, and memory that outlives these.
        ok(unsafe { jobs_begin(self.film, memory, size, &mut jobs) });
        let (memory, size) = lend(of_job);
        // SAFETY: the jobs of the film; the job before this one is done.
        while unsafe { jobs_next(jobs, memory, size, &mut job) } == PmcipStatus::Ok {
            loop {
                let ([x, y, u, v], [index, key]) = (&mut arrays.floats, &mut arrays.words);
                let [x, y, u, v] = [x, y, u, v].map(|values| values.as_mut_ptr());
                let (room, mut samples) = (index.len(), 0);
                let [index, key] = [index, key].map(|values| values.as_mut_ptr());
                // SAFETY: a job, and arrays of `room` entries.
                ok(unsafe { plan(job, room, x, y, index, key, &mut samples) });
                if samples == 0 {
                    break;
                }
                // SAFETY: arrays of at least so many entries.
                ok(unsafe { points(1, samples, index.cast_const(), key.cast_const(), u, v) });
                arrays.shade(samples);
                // SAFETY: three floats for each of the samples.
                ok(unsafe { deliver(job, arrays.rgb.as_ptr().cast::<f32>(), samples) });
            }
        }
    }

    fn resolve(&mut self) -> Vec<f32> {
        let mut rgb = vec![0.0; 3 * PIXELS];
        let mut scratch = vec![0.0; pmcip_capi::pmcip_scratch_size(SIDE, SIDE)];
        let (floats, estimator) = (scratch.len(), PmcipEstimator::Balanced as u32);
        // SAFETY: a film, and arrays as long as they have to be.
        ok(unsafe {
            pmcip_capi::pmcip_film_resolve(
                self.film,
                estimator,
                scratch.as_mut_ptr(),
                floats,
                rgb.as_mut_ptr(),
            )
        });
        rgb
    }
}

fn lend(memory: &mut [u64]) -> (*mut c_void, usize) {
    (memory.as_mut_ptr().cast(), size_of_val(memory))
}

fn ok(status: PmcipStatus) {
    assert_eq!(status, PmcipStatus::Ok);
}
