//! Renders a frame of a scene with all the processor's threads.
//!
//! The core divides an iteration into jobs that touch disjoint parts of the film. Each thread takes the next one
//! until none is left; which thread takes which does not matter, so a frame has the same bits for any number of
//! threads. Memory: 44 bytes a pixel for the film, 24 for the result, 4 for each further channel of its layers, and a
//! scratch area for each thread.

use super::attributes::attributes;
use super::features::{Seen, Sight};
use super::guide::Filtered;
use super::memory::zeros;
use super::photons::{Order, Photons, Shot};
use super::schedule::{Clock, LEAST_SPP, Target};
use super::settings::{Integrator, Layer, Settings};
use super::stop::Judge;
use super::threads::{self, Crew, start_threads};
use super::{budget, checkpoint, guide, layers};
use crate::error::Error;
use crate::picture::frame_io::Picture;
use crate::scene::LoadedScene;
use pmcip_core::predict::Prior;
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::saved::Saved;
use pmcip_core::sampler::{self, Memory, Sampler, Tally};
use pmcip_core::tracer::scene::Scene;
use rayon::ThreadPool;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// What a frame starts from, and who learns from it. `()` starts from nothing and learns nothing.
pub trait Learner {
    /// A frame begins; the threads of `pool` are there to work for it, the caller's alone if there is none.
    ///
    /// # Errors
    /// [`Error::Setting`] if the core refuses scene or camera, [`Error::Work`] if memory is lacking.
    fn begin(
        &mut self,
        _scene: &LoadedScene,
        _settings: &Settings,
        _pool: Option<&ThreadPool>,
    ) -> Result<(), Error> {
        Ok(())
    }

    /// Whether the frame begun starts from a prediction.
    fn predicts(&self) -> bool {
        false
    }

    /// What the next iteration of the frame begun starts from, after so many iterations.
    fn prior(&self, _iterations: u32) -> Prior<'_> {
        Prior::Beliefs(&[])
    }

    /// Is shown the frame begun after an iteration.
    ///
    /// # Errors
    /// [`Error::Work`] if memory is lacking or the film has another size.
    fn see(&mut self, _film: &Sampler<'_>, _settings: &Settings) -> Result<(), Error> {
        Ok(())
    }

    /// Changes the filtered picture of the frame begun by what earlier ones have shown, after [`end`](Self::end).
    ///
    /// # Errors
    /// [`Error::Work`] if memory is lacking.
    fn blend(&mut self, _filtered: &mut Filtered<'_>) -> Result<(), Error> {
        Ok(())
    }

    /// Learns from the frame begun, which has been rendered.
    ///
    /// # Errors
    /// [`Error::Work`] if memory is lacking or the film has another size.
    fn end(&mut self, _film: &Sampler<'_>) -> Result<(), Error> {
        Ok(())
    }
}

impl Learner for () {}

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
    /// Planes of further layers by channel name, as far as [`Settings::layers`] asks for them; [`Layer::Motion`] is added by
    /// who knows the frame before.
    pub layers: BTreeMap<String, Vec<f32>>,
    /// The film as bytes, if it was asked for.
    pub film: Option<Vec<u8>>,
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
    /// Err by the estimate of [`stop`](super::stop), if the frame had a target.
    pub estimated_err: Option<f64>,
}

impl Frame {
    /// Samples a pixel that were drawn.
    pub fn spp(&self) -> f64 {
        (self.tally.samples + self.tally.rejected) as f64 / self.rgb.len() as f64
    }

    /// What became of a frame that could end early, by name.
    fn outcome(&self, settings: &Settings) -> impl Iterator<Item = (String, String)> {
        let err = self.estimated_err.map(|err| ("estimated_err", err));
        let spent = settings.grows().then(|| ("spent_spp", self.spp()));
        err.into_iter().chain(spent).map(|(name, value)| (name.to_owned(), value.to_string()))
    }

    /// The frame as it goes to disk: with the layers asked for, and every setting by name.
    pub fn picture(&self, settings: &Settings, scene: &LoadedScene) -> Picture {
        let counted = [Layer::Variance, Layer::Count, Layer::Kernel].into_iter();
        let counted = counted.filter(|layer| settings.layers.contains(*layer));
        let counted = counted.map(|layer| (layer.channels()[0].to_owned(), self.counted(layer)));
        Picture {
            width: settings.sampler.width,
            height: settings.sampler.height,
            rgb: self.rgb.clone(),
            planes: self.layers.clone().into_iter().chain(counted).collect(),
            attributes: self.outcome(settings).chain(attributes(scene, settings)).collect(),
        }
    }

    /// The plane of a layer that every frame has.
    fn counted(&self, layer: Layer) -> Vec<f32> {
        match layer {
            Layer::Count => self.count.iter().map(|n| *n as f32).collect(),
            Layer::Kernel => self.alpha.clone(),
            _ => self.variance.clone(),
        }
    }
}

/// Renders a frame on `threads` threads, on all there are if that is `None`.
///
/// `progress` is called from any of them with the number of samples just drawn.
///
/// # Errors
/// [`Error::Setting`] if the core refuses the scene, the camera or a setting or the estimator does not serve a layer,
/// [`Error::Work`] if threads or memory are lacking.
pub fn render(
    scene: &LoadedScene,
    settings: &Settings,
    threads: Option<usize>,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Frame, Error> {
    render_next(scene, settings, threads, progress, &mut ())
}

/// Renders a frame as [`render`] does, from what `learner` has learnt of the frames before, and lets it learn from
/// this one.
///
/// # Errors
/// As [`render`]. The learner then knows nothing of this frame.
pub fn render_next(
    scene: &LoadedScene,
    settings: &Settings,
    threads: Option<usize>,
    progress: &(dyn Fn(u64) + Sync),
    learner: &mut dyn Learner,
) -> Result<Frame, Error> {
    let run = Run { threads, ..Run::watched(progress, learner) };
    render_while(scene, settings, run, &mut |_| Ok(true))
}

/// How a frame is rendered, beyond its settings.
pub struct Run<'r> {
    /// Threads that work, all there are if that is `None`.
    pub threads: Option<usize>,
    /// Called from any of them with the number of samples just drawn.
    pub progress: &'r (dyn Fn(u64) + Sync),
    /// What the frame starts from, and who learns from it.
    pub learner: &'r mut dyn Learner,
    /// Once it is set the run ends with [`Error::Interrupted`] as soon as every thread has done its job: some thousand samples.
    pub interrupted: &'r AtomicBool,
    /// Whether the finished frame shall have its [film](Frame::film).
    pub with_film: bool,
    /// A film of the same frame, to go on from.
    pub saved: Option<Saved<'r>>,
    /// Hears the frame's Err by the estimate of [`stop`](super::stop): after every iteration of a frame with a target, of
    /// others [as far as that is cheap](Judge::seldom).
    pub estimates: Option<&'r mut dyn FnMut(f64)>,
}

impl<'r> Run<'r> {
    /// On all threads, from the beginning to the end.
    pub fn watched(progress: &'r (dyn Fn(u64) + Sync), learner: &'r mut dyn Learner) -> Self {
        static NEVER: AtomicBool = AtomicBool::new(false);
        let interrupted = &NEVER;
        Run { threads: None, progress, learner, interrupted, with_film: false, saved: None, estimates: None }
    }
}

/// Renders a frame until it is good enough, its time is over, its samples are spent, or `go_on` says no, which is shown the
/// film after every iteration.
///
/// Iterations end at the same samples for any number of threads, so that a decision from the film alone keeps the frame's
/// bits the same. If the run is interrupted `go_on` is shown the film once more, in the middle of an iteration.
///
/// # Errors
/// As [`render`]; [`Error::Interrupted`]; [`Error::Setting`] if the saved film is of another frame; and what `go_on` returns.
pub fn render_while(
    scene: &LoadedScene,
    settings: &Settings,
    mut run: Run<'_>,
    go_on: &mut dyn FnMut(&Sampler<'_>) -> Result<bool, Error>,
) -> Result<Frame, Error> {
    let core = &settings.sampler;
    let mut estimates = run.estimates.take();
    let mut judge = match (settings.target, &estimates) {
        (Some(_), _) => Some(Judge::new(core.width, core.height, core.cd_per_unit)?),
        // Nobody is refused a frame for want of an estimate.
        (None, Some(_)) if budget::require(settings, true).is_ok() => {
            Judge::seldom(core.width, core.height, core.cd_per_unit)?
        }
        (None, _) => None,
    };
    let clock = Clock::new(settings.seconds);
    let (mut estimated, least) = (None, LEAST_SPP * settings.pixels());
    let frame = render_iterations(scene, settings, run, &mut |film| {
        if film.is_running() {
            return go_on(film);
        }
        if let Some(judge) = &mut judge {
            estimated = judge.look(film)?;
        }
        if let (Some(estimates), Some(err)) = (&mut estimates, estimated) {
            estimates(err);
        }
        let good = |target: Target| estimated.is_some_and(|err| err < f64::from(target.err));
        let is_done = settings.target.is_some_and(good) && film.samples() >= least;
        Ok(go_on(film)? && !is_done && clock.leaves_time(film.samples()))
    })?;
    Ok(Frame { estimated_err: settings.target.and(estimated), ..frame })
}

/// Renders a frame until its samples are spent or `go_on` says no.
fn render_iterations(
    scene: &LoadedScene,
    settings: &Settings,
    run: Run<'_>,
    go_on: &mut dyn FnMut(&Sampler<'_>) -> Result<bool, Error>,
) -> Result<Frame, Error> {
    let Run { threads, progress, learner, interrupted, with_film, saved, .. } = run;
    let start = Instant::now();
    layers::check(settings)?;
    budget::require(settings, settings.target.is_some())?;
    let pool = start_threads(threads)?;
    let view = Scene::new(scene.data()).map_err(Error::setting)?;
    let photons = shoot(view, settings, pool.as_ref())?;
    let maps = photons.as_ref().map(Photons::maps).transpose()?;
    let crew = Crew::new(view, settings, maps, pool)?;
    let (width, height) = (settings.sampler.width, settings.sampler.height);
    let required = Sampler::required(width, height);
    let (mut floats, mut words) = (zeros(required.floats)?, zeros(required.words)?);
    let memory = Memory { floats: &mut floats, words: &mut words };
    learner.begin(scene, settings, crew.pool())?;
    let film = if learner.predicts() { settings.predicted_film() } else { settings.film() };
    let mut sampler = match &saved {
        Some(saved) => go_on_from(saved, film, memory)?,
        None => Sampler::new(film, memory).map_err(Error::setting)?,
    };
    progress(sampler.samples());
    let mut tally = sampler.tally();
    let predicted = learner.predicts().then(|| settings.predicted_schedule());
    let plain = predicted.is_none().then(|| settings.schedule());
    let schedule = predicted.into_iter().flatten().chain(plain.into_iter().flatten());
    for samples in schedule.skip(sampler.iterations() as usize) {
        if !sampler.is_running() {
            let prior = learner.prior(sampler.iterations());
            threads::begin(crew.pool(), &mut sampler, samples, prior).map_err(Error::setting)?;
        }
        crew.work(sampler.jobs(), interrupted, progress);
        if interrupted.load(Ordering::Relaxed) {
            go_on(&sampler)?;
            return Err(Error::Interrupted);
        }
        tally = sampler.end().map_err(Error::work)?;
        learner.see(&sampler, settings)?;
        if !go_on(&sampler)? {
            break;
        }
    }
    learner.end(&sampler)?;
    let mut frame = read_out(&sampler)?;
    frame.film = with_film.then(|| checkpoint::bytes(&sampler)).transpose()?;
    let sight =
        Sight { scene: view, camera: crew.camera(), max_depth: settings.max_depth, size: (width, height) };
    let seen = see(sight, settings, crew.pool())?;
    let sky = scene.sky.as_ref().is_some_and(|sky| sky.visible);
    frame.layers = layers::planes(&sampler, &seen, sky, settings.layers, crew.pool())?;
    match settings.sampler.estimator {
        Estimator::Guided => {
            let mut blend = |filtered: &mut Filtered<'_>| learner.blend(filtered);
            guide::resolve(&sampler, &seen.features, crew.pool(), &mut blend, &mut frame.rgb)?;
        }
        estimator => layers::resolve(&sampler, estimator, crew.pool(), &mut frame.rgb)?,
    }
    (frame.tally, frame.lane_occupancy) = (tally, crew.lane_occupancy());
    frame.photons = photons.as_ref().map(Photons::shot);
    (frame.threads, frame.seconds) = (crew.len(), start.elapsed().as_secs_f64());
    Ok(frame)
}

/// A saved film on its memory, if it is of the frame whose film this is.
fn go_on_from<'a>(
    saved: &Saved<'_>,
    film: sampler::Settings,
    memory: Memory<'a>,
) -> Result<Sampler<'a>, Error> {
    let sampler = saved.restore(memory).map_err(Error::setting)?;
    match *sampler.settings() == film {
        true => Ok(sampler),
        false => Err(Error::Setting("the saved film is of a frame of other settings".into())),
    }
}

/// The photon maps that the integrator needs.
fn shoot(scene: Scene<'_>, settings: &Settings, pool: Option<&ThreadPool>) -> Result<Option<Photons>, Error> {
    let Integrator::Gather { photons, photon_seed } = settings.integrator else { return Ok(None) };
    let (max_depth, frame) = (settings.max_depth, settings.sampler.frame);
    let order = Order { photons, max_depth, seed: photon_seed, frame };
    Photons::shoot(scene, &order, pool).map(Some)
}

/// What the scene shows without light, as far as filter and layers need it.
fn see(sight: Sight<'_>, settings: &Settings, pool: Option<&ThreadPool>) -> Result<Seen, Error> {
    let guided = settings.sampler.estimator == Estimator::Guided;
    match guided || layers::need_features(settings.layers) {
        true => sight.look(layers::need_coverage(settings.layers), pool),
        false => Ok(Seen::default()),
    }
}

/// Fetches what the film knows of the pixels; the picture is black.
fn read_out(sampler: &Sampler<'_>) -> Result<Frame, Error> {
    let pixels = sampler.settings().width as usize * sampler.settings().height as usize;
    let mut frame = Frame {
        rgb: zeros(pixels)?,
        variance: zeros(pixels)?,
        count: zeros(pixels)?,
        alpha: zeros(pixels)?,
        layers: BTreeMap::new(),
        film: None,
        tally: Tally::default(),
        photons: None,
        lane_occupancy: 0.0,
        threads: 0,
        seconds: 0.0,
        estimated_err: None,
    };
    sampler.variance(&mut frame.variance).map_err(Error::setting)?;
    sampler.count(&mut frame.count).map_err(Error::setting)?;
    sampler.alpha(&mut frame.alpha).map_err(Error::setting)?;
    Ok(frame)
}
