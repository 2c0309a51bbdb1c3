//! The loop an embedder drives: adapt, allocate, sample, merge; then resolve.
//!
//! [`Sampler::begin`] turns the film into a kernel and the kernel into planned counts, [`Sampler::jobs`] divides
//! the iteration into runs of tiles that can be rendered by any thread in any order, [`Sampler::end`] checks
//! that all were. The same settings, samples and integrand give the same bits on any number of threads.
//!
//! Beginning and resolving are for one thread; where that is too slow, [`Sampler::beginning`] and [`Sampler::resolving`] hand
//! them out in parts, too: see [`begin`] and [`estimate::resolve`].
//!
//! ```
//! use pmcip_core::sampler::batch::{Batch8, Integrand, Rgb8};
//! use pmcip_core::sampler::{Memory, Sampler, Schedule, Settings, Workspace};
//!
//! struct Ramp;
//! impl Integrand for Ramp {
//!     fn radiance(&mut self, batch: &Batch8) -> Rgb8 {
//!         Rgb8 { r: batch.x, g: batch.y, b: batch.x * batch.y }
//!     }
//! }
//!
//! # fn main() -> Result<(), pmcip_core::sampler::Error> {
//! let (mut floats, mut words) = ([0.0; 8 * 64], [0; 3 * 64]); // as Sampler::required(8, 8) says
//! let mut sampler = Sampler::new(Settings::new(8, 8).for_frame(2, 16), Memory { floats: &mut floats, words: &mut words })?;
//! let (mut batches, mut radiance) = ([Batch8::default(); 16], [Rgb8::default(); 16]);
//! let mut work = Workspace::new(&mut batches, &mut radiance)?;
//! for samples in Schedule::new(64, 16, 2, 8) {
//!     sampler.begin(samples)?;
//!     for mut job in sampler.jobs() {
//!         job.render(&mut Ramp, &mut work);
//!     }
//!     sampler.end()?;
//! }
//! let (mut rgb, mut scratch) = ([0.0; 3 * 64], [[0.0; 16]; 6]); // as Sampler::resolve_scratch(8, 8) says
//! sampler.resolve(sampler.settings().estimator, &mut scratch, &mut rgb)?;
//! assert!((rgb[0] - 0.5).abs() < 0.2);
//! # Ok(())
//! # }
//! ```
#![doc = include_str!("defaults.md")]

use crate::maths::sobol::{PixelKeys, hash};
use crate::predict::Prior;
use crate::sampler::film::{Layout, Planes, WORDS};
use begin::Beginning;
use state::State;

pub mod allocate;
pub mod batch;
pub mod begin;
pub mod estimate;
mod fair;
pub mod film;
pub mod guide;
mod job;
pub mod kernel;
mod memory;
mod merge;
mod read;
pub mod saved;
mod schedule;
mod settings;
pub mod state;
pub mod wave;
pub use crate::sampler::estimate::Estimator;
pub use batch::MAX_RADIANCE;
pub use job::{Job, Jobs, Tally, Workspace};
pub use memory::{Memory, Required};
pub use schedule::Schedule;
pub use settings::{Error, Mode, Sequence, Settings};

/// A frame being sampled.
#[derive(Debug)]
pub struct Sampler<'a> {
    state: State,
    layout: Layout,
    planes: Planes<'a>,
}

impl<'a> Sampler<'a> {
    /// How much memory a film of this size takes: 44 bytes a pixel.
    pub fn required(width: u32, height: u32) -> Required {
        Required::of(width, height, false)
    }

    /// How much memory a film with labels takes: 48 bytes a pixel.
    pub fn required_with_labels(width: u32, height: u32) -> Required {
        Required::of(width, height, true)
    }

    /// An empty film on lent memory.
    ///
    /// # Errors
    /// If a setting is out of range or memory is short.
    pub fn new(settings: Settings, memory: Memory<'a>) -> Result<Self, Error> {
        let layout = settings.check()?;
        Self::empty(settings, layout.pixels(), memory, Sampler::required(settings.width, settings.height))
    }

    /// An empty film on lent memory, whose pixels do not all belong together: an atlas of textures, say.
    ///
    /// `labels`, row by row from the top, `u8` or `u16`, say to which island a pixel belongs, 0 to none: it has no samples,
    /// no weight, and no place in totals. No window, filter or smoothing looks from one island into another, and each has the
    /// energy of its own samples. They are copied: memory as [`required_with_labels`](Self::required_with_labels) says.
    ///
    /// Reading out takes two passes over the labels for every island: with thousands of them on millions of pixels, seconds.
    ///
    /// ```
    /// use pmcip_core::sampler::{Memory, Sampler, Settings};
    ///
    /// let labels = [1u8, 1, 0, 2, 2, 0]; // two islands of two pixels
    /// let (mut floats, mut words) = ([0.0; 8 * 6], [0; 4 * 6]); // as Sampler::required_with_labels(6, 1) says
    /// let memory = Memory { floats: &mut floats, words: &mut words };
    /// let mut sampler = Sampler::with_labels(Settings::new(6, 1), memory, &labels)?;
    /// assert_eq!(sampler.pixels(), 4);
    /// sampler.begin(8)?;
    /// assert_eq!(sampler.jobs().map(|job| job.samples()).sum::<u64>(), 8);
    /// # Ok::<(), pmcip_core::sampler::Error>(())
    /// ```
    ///
    /// # Errors
    /// If a setting is out of range, memory is short, or `labels` are of another number than pixels or all 0.
    pub fn with_labels<L: Copy + Into<u16>>(
        settings: Settings,
        memory: Memory<'a>,
        labels: &[L],
    ) -> Result<Self, Error> {
        let layout = settings.check()?;
        let used = labels.iter().filter(|label| (**label).into() != 0).count();
        if used == 0 || labels.len() != layout.pixels() {
            return Err(Error::Labels);
        }
        let required = Sampler::required_with_labels(settings.width, settings.height);
        let words = memory.words.get_mut(..required.words).ok_or(Error::Memory)?;
        let plane = &mut words[WORDS * layout.pixels()..];
        layout.for_each_run(|run, raster| {
            plane[run].iter_mut().zip(&labels[raster..]).for_each(|(to, label)| *to = (*label).into().into());
        });
        let mut sampler = Self::empty(settings, used, memory, required)?;
        let planes = &mut sampler.planes;
        for (drawn, label) in planes.drawn.iter_mut().zip(planes.label) {
            *drawn = if *label == 0 { u32::MAX } else { 0 };
        }
        Ok(sampler)
    }

    /// A film without samples; what is in memory beyond [`WORDS`] words a pixel stays as it is.
    fn empty(settings: Settings, used: usize, memory: Memory<'a>, required: Required) -> Result<Self, Error> {
        let layout = settings.check()?;
        let floats = memory.floats.get_mut(..required.floats).ok_or(Error::Memory)?;
        let words = memory.words.get_mut(..required.words).ok_or(Error::Memory)?;
        floats.fill(0.0);
        words[..WORDS * layout.pixels()].fill(0);
        let planes = Planes::new(floats, words, layout.pixels()).ok_or(Error::Memory)?;
        Ok(Sampler { state: State::new(settings, used, !planes.label.is_empty()), layout, planes })
    }

    /// The settings the sampler was made with.
    pub fn settings(&self) -> &Settings {
        &self.state.settings
    }

    /// Number of pixels that get samples: all, or those of a label other than 0.
    pub fn pixels(&self) -> usize {
        self.state.used
    }

    /// Number of iterations that have ended.
    pub fn iterations(&self) -> u32 {
        self.state.iteration
    }

    /// Whether an iteration has begun and not ended.
    pub fn is_running(&self) -> bool {
        self.state.running > 0
    }

    /// Number of samples drawn in the iterations that have ended, rejected ones included.
    pub fn samples(&self) -> u64 {
        self.state.samples
    }

    /// Begins an iteration of `samples` samples: adapts the kernel and plans every pixel's count.
    ///
    /// The first iteration is uniform.
    ///
    /// # Errors
    /// If an iteration is running already, or `samples` is 0 or above 2^32 − 1.
    pub fn begin(&mut self, samples: u64) -> Result<(), Error> {
        self.begin_predicted(samples, Prior::Beliefs(&[]))
    }

    /// Begins an iteration as [`begin`](Self::begin) does, with what earlier frames tell.
    ///
    /// With beliefs the first iteration is uniform all the same: one sample a pixel is enough, and no pixel is ever left without.
    /// With [`Prior::Alpha`] every iteration follows it, and a pixel of α = 0 gets nothing in it, not even of what is given to
    /// all alike. A frame that begins so should have [`Settings::for_frame`] with a pilot of 0, so that fair samples are
    /// promised to all. `prior` must not stem from this frame's samples, or the picture is biased.
    ///
    /// # Errors
    /// As `begin`, and [`Error::Prior`] if `prior` has not one entry a pixel or none.
    pub fn begin_predicted(&mut self, samples: u64, prior: Prior<'_>) -> Result<(), Error> {
        self.beginning(samples, prior).map(drop)
    }

    /// [`begin_predicted`](Self::begin_predicted) in parts that can be worked on by any threads: see [`begin`].
    ///
    /// The iteration has begun when what is returned is gone.
    ///
    /// # Errors
    /// As `begin_predicted`.
    pub fn beginning<'s>(&'s mut self, samples: u64, prior: Prior<'s>) -> Result<Beginning<'s>, Error> {
        Beginning::new(&mut self.state, self.layout, self.planes.reborrow(), samples, prior)
    }

    /// The jobs of the running iteration, as far as their samples are not in the film yet; none if none is running.
    ///
    /// Each begins where the last one ends. Who wants flat arrays instead, or radiances that come back later, sees [`wave`].
    pub fn jobs(&mut self) -> Jobs<'_> {
        let context = self.context();
        let tiles = if self.state.running > 0 { self.layout.tiles() } else { 0 };
        Jobs { rest: self.planes.reborrow(), context, next_tile: 0, tiles }
    }

    /// [`jobs`](Self::jobs) that last as long as the memory, for who [resumes](Self::resume) the sampler when they are done.
    pub fn into_jobs(self) -> Jobs<'a> {
        let context = self.context();
        let tiles = if self.state.running > 0 { self.layout.tiles() } else { 0 };
        Jobs { rest: self.planes, context, next_tile: 0, tiles }
    }

    /// What the jobs of the running iteration have in common.
    fn context(&self) -> job::Context {
        job::Context {
            layout: self.layout,
            keys: PixelKeys::new(self.state.settings.seed, self.state.settings.frame),
            iteration: hash(self.state.iteration),
            sequence: self.state.settings.sequence,
            fair: self.state.fair,
            estimator: self.state.settings.estimator,
            share: self.state.running as f32
                / self.state.samples.saturating_add(self.state.running).max(1) as f32,
        }
    }

    /// Ends the iteration and returns what has been sampled since the first one.
    ///
    /// # Errors
    /// If no iteration is running, or not all of its samples have been taken: it goes on running, and
    /// [`jobs`](Self::jobs) has what is left.
    pub fn end(&mut self) -> Result<Tally, Error> {
        if self.state.running == 0 {
            return Err(Error::NotBegun);
        }
        // A thousand at a time, so that they are read as vectors.
        let mut planned = self.planes.planned.chunks(1024);
        if planned.any(|chunk| chunk.iter().fold(0, |all, n| all | n) > 0) {
            return Err(Error::Unfinished);
        }
        self.state.samples = self.state.samples.saturating_add(self.state.running);
        self.state.iteration = self.state.iteration.saturating_add(1);
        self.state.running = 0;
        Ok(self.tally())
    }

    /// What has been sampled in the iterations that have ended; while one is running its samples count, too, as far as they are
    /// taken, and what was rejected is not known.
    pub fn tally(&self) -> Tally {
        let samples = self.planes.count.iter().map(|n| u64::from(*n)).sum::<u64>();
        Tally { samples, rejected: self.state.samples.saturating_sub(samples) }
    }

    /// That no iteration is running: what there is would be the half of one.
    fn at_rest(&self) -> Result<(), Error> {
        if self.state.running > 0 { Err(Error::Running) } else { Ok(()) }
    }
}
