//! What many machines gain: efficiency from 1 to 10,000 workers, by a formula and by a simulation of every event.
//!
//! `cargo run --release -p measure -- farm` prints two Markdown tables and what went into them. Measured in the run itself, on
//! one thread and pictures of 512×512 pixels, medians of five: seconds to open the scene `caustic` (a task's start), to render a
//! sample, to merge a film and to write the result, bytes of a film and of a frame's files. Stated: [`NETWORK`] and
//! [`STORAGE`], what is rendered, and how unequal it is. A worker is one core with its own way to a folder that all share.
//!
//! Efficiency is the time that one worker would render without starting, sending or waiting, divided by workers × time until the
//! last file is written. In the formulas W is the number of workers, S the start, F the bytes of a film, N and B the bytes a
//! second of a worker's network and of the storage, m the seconds that a film takes to merge, w those of writing the result:
//!
//! - Frames: T, the time of all of them, over W, and half a task, which is what the last ones lack at the end on average; or the
//!   longest task where that is more; or all files through the storage. Each task starts once.
//! - One merges: S + longest render + F/min(N, B/W) + S + W·(F/min(N, B) + m) + w: films are sent at once, read one after the
//!   other.
//!   With R, the time of all samples, R/W + W·(F/N + m) is least at W = √(R/(F/N + m)): more workers take longer.
//! - A tree of [`FAN`] films a merge, by the workers themselves: the same, but a level of n merges at once takes
//!   S + FAN·(F/min(N, B/n) + m) + w, and there are as many levels as it takes; what was merged is sent each time.

use crate::overhead::median;
use crate::queue::{Farm, Frames, Outcome, Seeds};
use pmcip::film::Film;
use pmcip::frame::render::{self, Frame};
use pmcip::frame::settings::{Method, Settings};
use pmcip::picture::frame_io;
use pmcip::scene::{Animation, LoadedScene};
use pmcip_core::sampler;
use pmcip_core::sampler::batch::{Batch8, Rgb8};
use pmcip_core::sampler::estimate::Estimator;
use std::fs;
use std::time::Instant;

/// Bytes a second of a worker's network: 10 Gbit/s.
pub const NETWORK: f64 = 1.25e9;
/// Bytes a second of the storage, all workers together.
pub const STORAGE: f64 = 1e10;
/// Films that one merge of a tree takes.
pub const FAN: usize = 16;

const WORKERS: [usize; 5] = [1, 10, 100, 1_000, 10_000];
const PIXELS: f64 = 1920.0 * 1080.0;
const FRAMES: usize = 20_000;
const FRAME_SPP: f64 = 256.0;
const SEEDS_SPP: f64 = 65_536.0;
const SIDE: u32 = 512;
const RUNS: usize = 5;

/// What the run has measured: seconds, bytes, each a pixel but for the start, and a sample.
struct Costs {
    start: f64,
    sample: f64,
    merge: f64,
    write: f64,
    film: f64,
    files: f64,
}

/// Prints the tables.
pub fn run(_arguments: &[String]) {
    let costs = measure();
    let Costs { start, sample, merge, write, film, files } = costs;
    println!(
        "Measured: start {:.1} ms, {:.2} µs a sample; a pixel: film {film:.0} bytes, files {files:.1} bytes, merging \
         {:.1} ns, writing the result {:.0} ns. Stated: {} GB/s a worker, {} GB/s of storage, 1920×1080 pixels.",
        1e3 * start,
        1e6 * sample,
        1e9 * merge,
        1e9 * write,
        NETWORK / 1e9,
        STORAGE / 1e9
    );
    println!("\n{FRAMES} frames of {FRAME_SPP} samples a pixel ± 50 %:\n");
    head("task");
    for chunk in [1, 10] {
        let frame = PIXELS * FRAME_SPP * sample;
        let frames = Frames { count: FRAMES, chunk, seconds: frame, bytes: PIXELS * files };
        let name = if chunk == 1 { "a frame".to_owned() } else { format!("{chunk} frames") };
        for workers in WORKERS {
            let farm = farm(workers, start);
            row(&name, workers, frames_formula(&frames, &farm), &frames.simulate(&farm));
        }
    }
    let each = film / NETWORK + merge;
    let most = (SEEDS_SPP * sample / each).sqrt();
    println!(
        "\nOne frame of {SEEDS_SPP} samples a pixel, machines ± 5 %; with one to merge, it is done soonest on {most:.0}:\n"
    );
    head("merged");
    for (name, fan) in [("by one", usize::MAX), ("as a tree", FAN)] {
        let seeds = Seeds {
            seconds: PIXELS * SEEDS_SPP * sample,
            film: PIXELS * film,
            merge: PIXELS * merge,
            write: PIXELS * write,
            fan,
        };
        for workers in WORKERS {
            let farm = farm(workers, start);
            row(name, workers, seeds_formula(&seeds, &farm), &seeds.simulate(&farm));
        }
    }
}

fn farm(workers: usize, start: f64) -> Farm {
    Farm { workers, start, network: NETWORK, storage: STORAGE }
}

fn head(first: &str) {
    println!(
        "| {first} | workers | efficiency, formula | simulated | sent, GB | all done after | waited, a worker |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- |");
}

fn row(name: &str, workers: usize, formula: f64, outcome: &Outcome) {
    println!(
        "| {name} | {workers} | {formula:.3} | {:.3} | {:.1} | {} | {} |",
        outcome.efficiency(workers),
        outcome.bytes / 1e9,
        time(outcome.seconds),
        time(outcome.waited(workers)),
    );
}

fn time(seconds: f64) -> String {
    match seconds {
        s if s < 100.0 => format!("{s:.1} s"),
        s if s < 36_000.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.0} h", s / 3600.0),
    }
}

/// See the head of this file.
fn frames_formula(frames: &Frames, farm: &Farm) -> f64 {
    let (workers, tasks) = (farm.workers as f64, (frames.count as f64 / frames.chunk as f64).ceil());
    let all = frames.count as f64 * frames.seconds;
    let sending = frames.bytes / farm.network.min(farm.storage);
    let task = farm.start + frames.chunk as f64 * (frames.seconds + sending);
    // Frames of a task differ independently of each other, each evenly within half of the mean.
    let longest = task + frames.seconds * 0.5 * (frames.chunk as f64).sqrt();
    let even = tasks * task / workers + if farm.workers > 1 { task / 2.0 } else { 0.0 };
    let stored = frames.count as f64 * frames.bytes / farm.storage;
    all / (workers * even.max(longest).max(stored))
}

/// See the head of this file.
fn seeds_formula(seeds: &Seeds, farm: &Farm) -> f64 {
    let workers = farm.workers as f64;
    let longest = if farm.workers > 1 { 1.05 } else { 1.0 };
    let send = |together: f64| seeds.film / farm.network.min(farm.storage / together);
    let mut time = farm.start + longest * seeds.seconds / workers + send(workers);
    let mut films = farm.workers;
    while films > 1 {
        let (merges, fan) = (films.div_ceil(seeds.fan), films.min(seeds.fan) as f64);
        time += farm.start + fan * (send(merges as f64) + seeds.merge) + seeds.write + send(merges as f64);
        films = merges;
    }
    seeds.seconds / (workers * time)
}

fn measure() -> Costs {
    let file = crate::scene_file("caustic");
    let open = || Animation::open(&file, &Default::default()).expect("the scene");
    let pixels = f64::from(SIDE * SIDE);
    let (start, scene) = timed(&mut || open().into_scene());
    let settings = Settings::new(&scene, Method::Pmc, Some(8), Some((SIDE, SIDE)));
    let frame = render::render(&scene, &settings, Some(1), &|_| ()).expect("a frame");
    let films = [0, 1].map(film_of);
    let [first, other] = &films;
    let (merge, mut film) = timed(&mut || {
        let mut film = Film::load(first).expect("a film");
        film.merge(other).expect("another seed");
        film
    });
    let (load, _) = timed(&mut || Film::load(first).expect("a film"));
    let (save, _) = timed(&mut || film.save().expect("bytes"));
    let (write, files) = timed(&mut || files(&mut film, &frame, &settings, &scene));
    Costs {
        start,
        sample: frame.seconds / frame.tally.samples as f64,
        // By pairs: every other film has to be one before it is merged, and every other result bytes.
        merge: (merge - load + (load + save) / 2.0) / pixels,
        write: write / pixels,
        film: first.len() as f64 / pixels,
        files: files / pixels,
    }
}

/// The median of the times of some runs, and what the last of them made.
fn timed<T>(run: &mut dyn FnMut() -> T) -> (f64, T) {
    let mut last = run();
    let times = (0..RUNS).map(|_| {
        let start = Instant::now();
        last = run();
        start.elapsed().as_secs_f64()
    });
    (median(times.collect()), last)
}

/// A film of two iterations.
fn film_of(seed: u32) -> Vec<u8> {
    let mut film =
        Film::new(sampler::Settings { seed, ..sampler::Settings::new(SIDE, SIDE) }).expect("memory");
    for _ in 0..2 {
        film.begin(film.pixels()).expect("samples");
        let noise = |batch: &Batch8| batch.point(1).0;
        film.render(&mut |batch: &Batch8| Rgb8 { r: noise(batch), g: noise(batch), b: noise(batch) })
            .expect("rendered");
        film.end().expect("an end");
    }
    film.save().expect("bytes")
}

/// Does what `merge` does with the merged film; bytes of a frame's files.
fn files(film: &mut Film, frame: &Frame, settings: &Settings, scene: &LoadedScene) -> f64 {
    let folder = tempfile::tempdir().expect("a folder");
    let [exr, png, bytes] = ["f.exr", "f.png", "f.film"].map(|name| folder.path().join(name));
    film.resolve(Estimator::Pooled).expect("a picture");
    fs::write(bytes, film.save().expect("bytes")).expect("written");
    let picture = frame.picture(settings, scene);
    frame_io::write_exr(&exr, &picture).expect("written");
    frame_io::write_png(&png, &picture, 0.0).expect("written");
    [exr, png].iter().map(|file| file.metadata().expect("there").len() as f64).sum()
}
