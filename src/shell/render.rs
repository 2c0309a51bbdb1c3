//! Renders a frame of a scene with all the processor's threads.
//!
//! The core divides an iteration into jobs that touch disjoint parts of the film. Each thread takes the next one
//! until none is left; which thread takes which does not matter, so a frame has the same bits for any number of
//! threads. Memory: 44 bytes a pixel for the film, 24 for the result, and a scratch area for each thread.

use crate::error::Error;
use crate::frame_io::Picture;
use crate::guide::{self, Sight};
use crate::photons::{Order, Photons, Shot};
use crate::predict::Predictor;
use crate::scene::LoadedScene;
use crate::settings::{Integrator, Settings};
use crate::stop::{self, Judge};
use pmcip_core::sampler::batch::{Batch8, Integrand, Rgb8};
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::{Jobs, Memory, Sampler, Tally, Workspace};
use pmcip_core::tracer::camera::Camera;
use pmcip_core::tracer::scene::Scene;
use pmcip_core::tracer::shade::direct::{DirectLighting, Samples};
use pmcip_core::tracer::shade::gather::{Gather, Maps};
use pmcip_core::tracer::shade::path::{Packet, PathTracer, Traffic};
use rayon::{ThreadPool, ThreadPoolBuilder};
use serde_json::Value;
use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// Batches a thread works on at once.
const BATCHES: usize = 256;

/// A finished frame; planes are rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Linear radiance.
    pub rgb: Vec<[f32; 3]>,
    /// Variance of the pixel's mean, luminance.
    pub variance: Vec<f32>,
    /// Samples of the pixel.
    pub count: Vec<u32>,
    /// The kernel of the last iteration; sums to one.
    pub alpha: Vec<f32>,
    /// Samples accepted and rejected.
    pub tally: Tally,
    /// Photon maps that were shot, if any were.
    pub photons: Option<Shot>,
    /// Mean part of a ray packet's lanes that carried a ray, 0 to 1.
    pub lane_occupancy: f64,
    /// Threads that worked.
    pub threads: usize,
    /// Wall time of the render, without loading and writing.
    pub seconds: f64,
    /// Err by the estimate of [`stop`], if the frame had a target.
    pub estimated_err: Option<f64>,
}

impl Frame {
    /// Samples a pixel that were drawn.
    pub fn spp(&self) -> f64 {
        (self.tally.samples + self.tally.rejected) as f64 / self.rgb.len() as f64
    }

    /// What became of a frame that could end early, by name.
    fn outcome(&self) -> impl Iterator<Item = (String, String)> {
        let spent =
            move |err: f64| [("estimated_err", err.to_string()), ("spent_spp", self.spp().to_string())];
        let list = self.estimated_err.map(spent).into_iter().flatten();
        list.map(|(name, value)| (name.to_owned(), value))
    }

    /// The frame as it goes to disk: the planes `variance`, `count`, `alpha`, and every setting by name.
    pub fn picture(&self, settings: &Settings, scene: &LoadedScene) -> Picture {
        let count = self.count.iter().map(|n| *n as f32).collect();
        let planes = [("variance", self.variance.clone()), ("count", count), ("alpha", self.alpha.clone())];
        Picture {
            width: settings.sampler.width,
            height: settings.sampler.height,
            rgb: self.rgb.clone(),
            planes: planes.into_iter().map(|(name, plane)| (name.to_owned(), plane)).collect(),
            attributes: self.outcome().chain(attributes(scene, settings)).collect(),
        }
    }
}

/// Every setting of a frame by name, as its file has them, and the scene's name.
pub fn attributes(scene: &LoadedScene, settings: &Settings) -> BTreeMap<String, String> {
    let mut settings_by_name = settings.list();
    settings_by_name.insert("scene".into(), Value::String(scene.name.clone()));
    settings_by_name.into_iter().map(|(name, value)| (name, plain(value))).collect()
}

/// A setting as the command line takes it: no quotes, no brackets.
fn plain(value: Value) -> String {
    match value {
        Value::String(text) => text,
        Value::Array(parts) => parts.into_iter().map(plain).collect::<Vec<_>>().join(","),
        other => other.to_string(),
    }
}

/// Renders a frame on `threads` threads, on all there are if that is `None`.
///
/// `progress` is called from any of them with the number of samples just drawn.
///
/// # Errors
/// [`Error::Setting`] if the core refuses the scene, the camera or a setting, [`Error::Work`] if threads or
/// memory are lacking.
pub fn render(
    scene: &LoadedScene,
    settings: &Settings,
    threads: Option<usize>,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Frame, Error> {
    render_next(scene, settings, threads, progress, &mut Predictor::default())
}

/// Renders a frame as [`render`] does, from what `predictor` has learnt of the frames before, and lets it learn from
/// this one.
///
/// # Errors
/// As [`render`]. The predictor then knows nothing of this frame.
pub fn render_next(
    scene: &LoadedScene,
    settings: &Settings,
    threads: Option<usize>,
    progress: &(dyn Fn(u64) + Sync),
    predictor: &mut Predictor,
) -> Result<Frame, Error> {
    let Some(target) = settings.target else {
        return render_while(scene, settings, threads, progress, predictor, &mut |_| Ok(true));
    };
    let core = &settings.sampler;
    let mut judge = Judge::new(core.width, core.height, core.cd_per_unit)?;
    let mut estimated = None;
    let least = stop::LEAST_SPP * settings.pixels();
    let frame = render_while(scene, settings, threads, progress, predictor, &mut |film| {
        estimated = judge.look(film)?;
        let good = estimated.is_some_and(|err| err < f64::from(target.err));
        Ok(!(good && film.samples() >= least))
    })?;
    Ok(Frame { estimated_err: estimated, ..frame })
}

/// Renders a frame as [`render_next`] does, until `go_on`, which is shown the film after every iteration, says no.
///
/// Iterations end at the same samples for any number of threads, so that a decision from the film alone keeps the
/// frame's bits the same.
///
/// # Errors
/// As [`render`], and what `go_on` returns.
pub fn render_while(
    scene: &LoadedScene,
    settings: &Settings,
    threads: Option<usize>,
    progress: &(dyn Fn(u64) + Sync),
    predictor: &mut Predictor,
    go_on: &mut dyn FnMut(&Sampler<'_>) -> Result<bool, Error>,
) -> Result<Frame, Error> {
    let start = Instant::now();
    let pool = start_threads(threads)?;
    let photons = shoot(scene, settings, pool.as_ref())?;
    let maps = photons.as_ref().map(Photons::maps).transpose()?;
    let crew = Crew::new(scene, settings, maps, pool)?;
    let (width, height) = (settings.sampler.width, settings.sampler.height);
    let required = Sampler::required(width, height);
    let (mut floats, mut words) = (zeros(required.floats)?, zeros(required.words)?);
    let memory = Memory { floats: &mut floats, words: &mut words };
    predictor.begin(scene, settings)?;
    let film = if predictor.predicts() { settings.predicted_film() } else { settings.film() };
    let mut sampler = Sampler::new(film, memory).map_err(setting)?;
    let mut tally = Tally::default();
    let predicted = predictor.predicts().then(|| settings.predicted_schedule());
    let plain = predicted.is_none().then(|| settings.schedule());
    for samples in predicted.into_iter().flatten().chain(plain.into_iter().flatten()) {
        let prior = predictor.prior(sampler.iterations());
        sampler.begin_predicted(samples, prior).map_err(setting)?;
        crew.work(sampler.jobs(), progress);
        tally = sampler.end().map_err(|error| Error::Work(error.to_string()))?;
        predictor.see(&sampler, settings)?;
        if !go_on(&sampler)? {
            break;
        }
    }
    predictor.end(&sampler)?;
    let mut frame = read_out(&sampler, settings)?;
    if settings.sampler.estimator == Estimator::Guided {
        let sight = Sight { scene: crew.scene, camera: crew.camera, max_depth: settings.max_depth };
        guide::resolve(&sampler, sight, crew.pool.as_ref(), &mut frame.rgb)?;
    }
    (frame.tally, frame.lane_occupancy) = (tally, crew.lane_occupancy());
    frame.photons = photons.as_ref().map(Photons::shot);
    (frame.threads, frame.seconds) = (crew.workers.len(), start.elapsed().as_secs_f64());
    Ok(frame)
}

/// Threads for `threads`; none for a single one, which is the caller's.
fn start_threads(threads: Option<usize>) -> Result<Option<ThreadPool>, Error> {
    let build = || ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build();
    let pool = (threads != Some(1)).then(build).transpose();
    pool.map_err(|error| Error::Work(format!("cannot start threads: {error}")))
}

/// The photon maps that the integrator needs.
fn shoot(
    scene: &LoadedScene,
    settings: &Settings,
    pool: Option<&ThreadPool>,
) -> Result<Option<Photons>, Error> {
    let Integrator::Gather { photons, photon_seed } = settings.integrator else { return Ok(None) };
    let (max_depth, frame) = (settings.max_depth, settings.sampler.frame);
    let order = Order { photons, max_depth, seed: photon_seed, frame };
    Photons::shoot(Scene::new(scene.data()).map_err(setting)?, &order, pool).map(Some)
}

/// Fetches the film's planes.
fn read_out(sampler: &Sampler<'_>, settings: &Settings) -> Result<Frame, Error> {
    let (width, height) = (settings.sampler.width, settings.sampler.height);
    let pixels = width as usize * height as usize;
    let mut frame = Frame {
        rgb: zeros(pixels)?,
        variance: zeros(pixels)?,
        count: zeros(pixels)?,
        alpha: zeros(pixels)?,
        tally: Tally::default(),
        photons: None,
        lane_occupancy: 0.0,
        threads: 0,
        seconds: 0.0,
        estimated_err: None,
    };
    let mut scratch = zeros(Sampler::resolve_scratch(width, height))?;
    let estimator = match settings.sampler.estimator {
        Estimator::Guided => Estimator::Balanced,
        other => other,
    };
    sampler.resolve(estimator, &mut scratch, frame.rgb.as_flattened_mut()).map_err(setting)?;
    sampler.variance(&mut frame.variance).map_err(setting)?;
    sampler.count(&mut frame.count).map_err(setting)?;
    sampler.alpha(&mut frame.alpha).map_err(setting)?;
    Ok(frame)
}

fn setting(error: impl std::error::Error) -> Error {
    Error::Setting(error.to_string())
}

/// Memory, or an error instead of an abort: a film can be larger than the machine.
pub(crate) fn zeros<T: Clone + Default>(length: usize) -> Result<Vec<T>, Error> {
    let mut memory = Vec::new();
    memory.try_reserve_exact(length).map_err(|_| Error::Work("not enough memory for the film".into()))?;
    memory.resize(length, T::default());
    Ok(memory)
}

/// Threads, each with what it needs to trace paths.
struct Crew<'a> {
    scene: Scene<'a>,
    camera: Camera,
    integrator: Integrator,
    /// What [`Integrator::Gather`] looks up.
    maps: Option<Maps<'a>>,
    max_depth: u32,
    /// None for a single worker, which works on the caller's thread.
    pool: Option<ThreadPool>,
    workers: Vec<Mutex<Worker>>,
}

/// What belongs to one thread; the lock is never contended.
struct Worker {
    packets: Vec<Packet>,
    batches: Vec<Batch8>,
    radiance: Vec<Rgb8>,
    traffic: Traffic,
}

impl<'a> Crew<'a> {
    fn new(
        scene: &'a LoadedScene,
        settings: &Settings,
        maps: Option<Maps<'a>>,
        pool: Option<ThreadPool>,
    ) -> Result<Self, Error> {
        let view = &settings.view;
        let (width, height) = (settings.sampler.width, settings.sampler.height);
        let camera = Camera::new(view.from, view.at, view.up, view.fov, width, height).map_err(setting)?;
        let count = pool.as_ref().map_or(1, ThreadPool::current_num_threads);
        let workers = (0..count).map(|_| Mutex::new(Worker::new())).collect();
        let scene = Scene::new(scene.data()).map_err(setting)?;
        Ok(Crew {
            scene,
            camera,
            integrator: settings.integrator,
            maps,
            max_depth: settings.max_depth,
            pool,
            workers,
        })
    }

    /// Renders all jobs of an iteration.
    fn work(&self, jobs: Jobs<'_>, progress: &(dyn Fn(u64) + Sync)) {
        let jobs = Mutex::new(jobs);
        match &self.pool {
            Some(pool) => drop(pool.broadcast(|thread| self.work_as(thread.index(), &jobs, progress))),
            None => self.work_as(0, &jobs, progress),
        }
    }

    /// Renders jobs as worker number `index` until none is left.
    fn work_as(&self, index: usize, jobs: &Mutex<Jobs<'_>>, progress: &(dyn Fn(u64) + Sync)) {
        let worker = &mut *lock(&self.workers[index]);
        let Ok(mut work) = Workspace::new(&mut worker.batches, &mut worker.radiance) else { return };
        let (scene, camera, depth, memory) = (self.scene, self.camera, self.max_depth, &mut worker.packets);
        let traffic = match self.integrator {
            Integrator::Path => {
                let mut tracer = PathTracer::new(scene, camera, depth, memory);
                drain(jobs, &mut tracer, &mut work, progress);
                tracer.traffic()
            }
            Integrator::Direct { light_samples, bsdf_samples } => {
                let samples = Samples { light: light_samples, bsdf: bsdf_samples };
                let mut tracer = DirectLighting::new(scene, camera, depth, samples, memory);
                drain(jobs, &mut tracer, &mut work, progress);
                tracer.traffic()
            }
            Integrator::Gather { .. } => {
                let Some(maps) = self.maps else { return };
                let mut tracer = Gather::new(scene, camera, depth, maps, memory);
                drain(jobs, &mut tracer, &mut work, progress);
                tracer.traffic()
            }
        };
        worker.traffic = sum(worker.traffic, traffic);
    }

    /// Rays traced over lanes of the packets traced.
    fn lane_occupancy(&self) -> f64 {
        let traffic = self.workers.iter().map(|worker| lock(worker).traffic).fold(Traffic::default(), sum);
        let lanes = 8 * (traffic.packets + traffic.shadow_packets);
        (traffic.rays + traffic.shadow_rays) as f64 / lanes.max(1) as f64
    }
}

impl Worker {
    fn new() -> Worker {
        Worker {
            packets: vec![Packet::default(); PathTracer::required(8 * BATCHES)],
            batches: vec![Batch8::default(); BATCHES],
            radiance: vec![Rgb8::default(); BATCHES],
            traffic: Traffic::default(),
        }
    }
}

/// Renders jobs until none is left.
fn drain(
    jobs: &Mutex<Jobs<'_>>,
    integrand: &mut impl Integrand,
    work: &mut Workspace<'_>,
    progress: &(dyn Fn(u64) + Sync),
) {
    loop {
        // A statement of its own, so that the lock is released before the work begins.
        let next = lock(jobs).next();
        let Some(mut job) = next else { break };
        job.render(integrand, work);
        progress(job.samples());
    }
}

/// A lock whose data no panic can leave half done.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn sum(a: Traffic, b: Traffic) -> Traffic {
    Traffic {
        packets: a.packets + b.packets,
        rays: a.rays + b.rays,
        shadow_packets: a.shadow_packets + b.shadow_packets,
        shadow_rays: a.shadow_rays + b.shadow_rays,
    }
}
