//! Threads, each with what it needs to trace paths.

use super::memory::lock;
use super::settings::{Integrator, Settings};
use crate::error::Error;
use pmcip_core::predict::Prior;
use pmcip_core::sampler::batch::{Batch8, Integrand, Rgb8};
use pmcip_core::sampler::estimate::Resolving;
use pmcip_core::sampler::{Error as CoreError, Job, Jobs, Sampler, Workspace};
use pmcip_core::tracer::camera::Camera;
use pmcip_core::tracer::scene::Scene;
use pmcip_core::tracer::shade::direct::{DirectLighting, Samples};
use pmcip_core::tracer::shade::gather::{Gather, Maps};
use pmcip_core::tracer::shade::irradiance::{Irradiance, Unwrapped};
use pmcip_core::tracer::shade::path::{Packet, PathTracer, Traffic};
use rayon::iter::{IntoParallelIterator, ParallelBridge, ParallelIterator};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// Batches a thread works on at once.
const BATCHES: usize = 256;

/// Threads for `threads`; none for a single one, which is the caller's.
pub(crate) fn start_threads(threads: Option<usize>) -> Result<Option<ThreadPool>, Error> {
    let build = || ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build();
    let pool = (threads != Some(1)).then(build).transpose();
    pool.map_err(|error| Error::Work(format!("cannot start threads: {error}")))
}

/// Works on all parts, on all threads of `pool`, on the caller's if there is none.
pub(crate) fn each<T: Send>(pool: Option<&ThreadPool>, parts: Vec<T>, work: impl Fn(T) + Send + Sync) {
    match pool {
        Some(pool) => pool.install(|| parts.into_par_iter().for_each(work)),
        None => parts.into_iter().for_each(work),
    }
}

/// Begins an iteration on all threads of `pool`, on the caller's if there is none.
pub(crate) fn begin(
    pool: Option<&ThreadPool>,
    film: &mut Sampler<'_>,
    samples: u64,
    prior: Prior<'_>,
) -> Result<(), CoreError> {
    match pool {
        Some(pool) => pool.install(|| begin_on_all(film, samples, prior)),
        None => film.begin_predicted(samples, prior),
    }
}

/// Begins an iteration on all threads of the pool that the caller is in.
pub(crate) fn begin_on_all(film: &mut Sampler<'_>, samples: u64, prior: Prior<'_>) -> Result<(), CoreError> {
    let mut beginning = film.beginning(samples, prior)?;
    while let Some(parts) = beginning.parts() {
        parts.par_bridge().for_each(|mut part| part.work());
    }
    Ok(())
}

/// Makes a picture on all threads of `pool`, on the caller's if there is none.
pub(crate) fn resolve(pool: Option<&ThreadPool>, resolving: Resolving<'_>) {
    match pool {
        Some(pool) => pool.install(|| resolve_on_all(resolving)),
        None => drop(resolving),
    }
}

/// Makes a picture on all threads of the pool that the caller is in.
pub(crate) fn resolve_on_all(mut resolving: Resolving<'_>) {
    while let Some(parts) = resolving.parts() {
        parts.par_bridge().for_each(|mut part| part.work());
    }
}

/// Threads, each with what it needs to trace paths.
pub(crate) struct Crew<'a> {
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
    pub fn new(
        scene: Scene<'a>,
        settings: &Settings,
        maps: Option<Maps<'a>>,
        pool: Option<ThreadPool>,
    ) -> Result<Self, Error> {
        let camera = settings.camera().map_err(Error::setting)?;
        let count = pool.as_ref().map_or(1, ThreadPool::current_num_threads);
        let workers = (0..count).map(|_| Mutex::new(Worker::new())).collect();
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

    /// Renders all jobs of an iteration, or those that are begun before the work is `interrupted`.
    pub fn work(&self, jobs: Jobs<'_>, interrupted: &AtomicBool, progress: &(dyn Fn(u64) + Sync)) {
        let queue = Queue { jobs: Mutex::new(jobs), interrupted };
        self.all(|worker| self.work_as(worker, &queue, progress));
    }

    /// Renders all jobs of an iteration of a lightmap.
    pub fn bake(&self, jobs: Jobs<'_>, plane: &(impl Unwrapped + Sync), progress: &(dyn Fn(u64) + Sync)) {
        let queue = Queue { jobs: Mutex::new(jobs), interrupted: &AtomicBool::new(false) };
        self.all(|Worker { packets, batches, radiance, .. }| {
            let Ok(mut work) = Workspace::new(batches, radiance) else { return };
            drain(
                &queue,
                &mut Irradiance::new(self.scene, plane, self.max_depth, packets),
                &mut work,
                progress,
            );
        });
    }

    /// Works as all workers at once.
    fn all(&self, work: impl Fn(&mut Worker) + Sync) {
        match &self.pool {
            Some(pool) => drop(pool.broadcast(|thread| work(&mut lock(&self.workers[thread.index()])))),
            None => work(&mut lock(&self.workers[0])),
        }
    }

    /// Renders jobs as one of the workers until there are no more.
    fn work_as(&self, worker: &mut Worker, queue: &Queue<'_>, progress: &(dyn Fn(u64) + Sync)) {
        let Ok(mut work) = Workspace::new(&mut worker.batches, &mut worker.radiance) else { return };
        let (scene, camera, depth, memory) = (self.scene, self.camera, self.max_depth, &mut worker.packets);
        let traffic = match self.integrator {
            Integrator::Path => {
                let mut tracer = PathTracer::new(scene, camera, depth, memory);
                drain(queue, &mut tracer, &mut work, progress);
                tracer.traffic()
            }
            Integrator::Direct { light_samples, bsdf_samples } => {
                let samples = Samples { light: light_samples, bsdf: bsdf_samples };
                let mut tracer = DirectLighting::new(scene, camera, depth, samples, memory);
                drain(queue, &mut tracer, &mut work, progress);
                tracer.traffic()
            }
            Integrator::Gather { .. } => {
                let Some(maps) = self.maps else { return };
                let mut tracer = Gather::new(scene, camera, depth, maps, memory);
                drain(queue, &mut tracer, &mut work, progress);
                tracer.traffic()
            }
        };
        worker.traffic = sum(worker.traffic, traffic);
    }

    /// The frame's camera.
    pub fn camera(&self) -> Camera {
        self.camera
    }

    /// The threads; none for the caller's alone.
    pub fn pool(&self) -> Option<&ThreadPool> {
        self.pool.as_ref()
    }

    /// How many work.
    pub fn len(&self) -> usize {
        self.workers.len()
    }

    /// Rays traced over lanes of the packets traced.
    pub fn lane_occupancy(&self) -> f64 {
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

/// The jobs of an iteration that nobody has begun yet.
struct Queue<'q> {
    jobs: Mutex<Jobs<'q>>,
    /// Once it is set there are no more.
    interrupted: &'q AtomicBool,
}

impl<'q> Queue<'q> {
    fn next(&self) -> Option<Job<'q>> {
        if self.interrupted.load(Ordering::Relaxed) { None } else { lock(&self.jobs).next() }
    }
}

/// Renders jobs until there are no more.
fn drain(
    queue: &Queue<'_>,
    integrand: &mut impl Integrand,
    work: &mut Workspace<'_>,
    progress: &(dyn Fn(u64) + Sync),
) {
    while let Some(mut job) = queue.next() {
        job.render(integrand, work);
        progress(job.samples());
    }
}

fn sum(a: Traffic, b: Traffic) -> Traffic {
    Traffic {
        packets: a.packets + b.packets,
        rays: a.rays + b.rays,
        shadow_packets: a.shadow_packets + b.shadow_packets,
        shadow_rays: a.shadow_rays + b.shadow_rays,
    }
}
