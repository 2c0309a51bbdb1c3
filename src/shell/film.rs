//! A film that owns its memory: the core's sampler for programs that have an allocator.
//!
//! [`Film`] is `'static` and [`Send`]: it can live in a struct, go to another thread, and its work can go to threads that
//! outlive the frame, as [`Plan`]s. What [`Film`] does itself it does on the threads of the `rayon` pool that the caller is in, or
//! the global one, with the same bits for any number of them.
//!
//! ```
//! use pmcip::film::Film;
//! use pmcip_core::sampler::{Schedule, Settings};
//!
//! let mut film = Film::new(Settings::new(64, 48).for_frame(2, 16))?;
//! for samples in Schedule::new(film.pixels(), 16, 2, 8) {
//!     film.begin(samples)?;
//!     let plans: Vec<_> = film.plans(2048)?;
//!     let done = plans.into_iter().map(|plan| std::thread::spawn(move || {
//!         let radiance: Vec<_> = plan.x.iter().zip(&plan.y).map(|(x, y)| [*x, *y, 1.0]).collect(); // your renderer
//!         (plan.piece, radiance)
//!     }));
//!     for (piece, radiance) in done.collect::<Vec<_>>().into_iter().map(|thread| thread.join().unwrap()) {
//!         film.deliver(piece, &radiance)?;
//!     }
//!     film.end()?;
//! }
//! let picture = film.guided(&[])?;
//! assert!((picture[63][0] - 63.5).abs() < 0.5);
//! # Ok::<(), pmcip::error::Error>(())
//! ```

use crate::error::Error;
use crate::frame::memory::zeros;
use crate::frame::threads::{begin_on_all, resolve_on_all};
use pmcip_core::predict::Prior;
use pmcip_core::sampler::batch::{Integrand, Rgb8};
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::guide::{Feature, Filter};
use pmcip_core::sampler::saved::Saved;
use pmcip_core::sampler::state::State;
use pmcip_core::sampler::wave::{Piece, Wave};
use pmcip_core::sampler::{Error as CoreError, Memory, Required, Sampler, Settings, Tally, Workspace};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// Batches that [`Film::render`] hands an integrand at once.
const BATCHES: usize = 64;
/// Rows that a thread writes at once.
const ROWS: usize = 8;

/// A sampler and its memory.
#[derive(Clone, Debug)]
pub struct Film {
    state: State,
    floats: Vec<f32>,
    words: Vec<u32>,
}

/// Samples of an iteration that can be taken anywhere: entries of the four arrays belong together, see
/// [`wave`](pmcip_core::sampler::wave).
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The part of the film: for [`Film::deliver`].
    pub piece: Piece,
    /// Horizontal positions, in pixels.
    pub x: Vec<f32>,
    /// Vertical positions, in pixels.
    pub y: Vec<f32>,
    /// Numbers of the samples in their pixels' sequences.
    pub index: Vec<u32>,
    /// Keys of these sequences.
    pub key: Vec<u32>,
}

impl Film {
    /// An empty film.
    ///
    /// # Errors
    /// If a setting is out of range or memory is lacking.
    pub fn new(settings: Settings) -> Result<Film, Error> {
        Film::made(Sampler::required(settings.width, settings.height), |memory| {
            Sampler::new(settings, memory)
        })
    }

    /// An empty film of islands; see [`Sampler::with_labels`].
    ///
    /// # Errors
    /// As [`new`](Self::new), and if labels do not fit.
    pub fn with_labels<L: Copy + Into<u16>>(settings: Settings, labels: &[L]) -> Result<Film, Error> {
        let required = Sampler::required_with_labels(settings.width, settings.height);
        Film::made(required, |memory| Sampler::with_labels(settings, memory, labels))
    }

    /// A film from bytes that [`save`](Self::save) returned.
    ///
    /// # Errors
    /// If they are no film of this version, or memory is lacking.
    pub fn load(bytes: &[u8]) -> Result<Film, Error> {
        let saved = Saved::new(bytes).map_err(Error::setting)?;
        Film::made(saved.state().required(), |memory| saved.restore(memory))
    }

    fn made(
        required: Required,
        make: impl FnOnce(Memory<'_>) -> Result<Sampler<'_>, CoreError>,
    ) -> Result<Film, Error> {
        let (mut floats, mut words) = (zeros(required.floats)?, zeros(required.words)?);
        let memory = Memory { floats: &mut floats, words: &mut words };
        let state = make(memory).map_err(Error::setting)?.state();
        Ok(Film { state, floats, words })
    }

    /// Does anything with the core's sampler.
    ///
    /// # Errors
    /// What `work` returns.
    pub fn with<T>(
        &mut self,
        work: impl FnOnce(&mut Sampler<'_>) -> Result<T, CoreError>,
    ) -> Result<T, Error> {
        let memory = Memory { floats: &mut self.floats, words: &mut self.words };
        let mut sampler = Sampler::resume(self.state, memory).map_err(Error::setting)?;
        let done = work(&mut sampler);
        self.state = sampler.state();
        done.map_err(Error::setting)
    }

    /// The settings it was made with.
    pub fn settings(&self) -> &Settings {
        self.state.settings()
    }

    /// Number of pixels that get samples.
    pub fn pixels(&self) -> u64 {
        self.state.pixels() as u64
    }

    /// Begins an iteration of `samples` samples, on all threads: [`Sampler::begin`].
    ///
    /// # Errors
    /// As the core.
    pub fn begin(&mut self, samples: u64) -> Result<(), Error> {
        self.begin_predicted(samples, Prior::Beliefs(&[]))
    }

    /// Begins one with what earlier frames tell, on all threads: [`Sampler::begin_predicted`].
    ///
    /// # Errors
    /// As the core.
    pub fn begin_predicted(&mut self, samples: u64, prior: Prior<'_>) -> Result<(), Error> {
        self.with(|sampler| begin_on_all(sampler, samples, prior))
    }

    /// Takes all samples of the running iteration on this thread.
    ///
    /// # Errors
    /// As the core.
    pub fn render(&mut self, integrand: &mut (impl Integrand + ?Sized)) -> Result<(), Error> {
        self.with(|sampler| {
            let (mut batches, mut radiance) =
                (vec![Default::default(); BATCHES], vec![Rgb8::default(); BATCHES]);
            let mut work = Workspace::new(&mut batches, &mut radiance)?;
            sampler.jobs().for_each(|mut job| {
                job.render(integrand, &mut work);
            });
            Ok(())
        })
    }

    /// Samples of the running iteration from pixel `first` on, whole pixels of up to `most` samples together; all that are
    /// left if there are not as many.
    ///
    /// # Errors
    /// If no iteration is running, a pixel has more samples than `most`, or memory is lacking.
    pub fn plan(&mut self, first: usize, most: usize) -> Result<Plan, Error> {
        let most = most.min(self.state.running().try_into().unwrap_or(usize::MAX)).max(1);
        let (mut x, mut y, mut index, mut key) = (zeros(most)?, zeros(most)?, zeros(most)?, zeros(most)?);
        let mut wave = Wave { x: &mut x, y: &mut y, index: &mut index, key: &mut key };
        let piece = self.with(|sampler| sampler.plan(first, &mut wave))?;
        [&mut x, &mut y].into_iter().for_each(|v| v.truncate(piece.samples));
        [&mut index, &mut key].into_iter().for_each(|v| v.truncate(piece.samples));
        Ok(Plan { piece, x, y, index, key })
    }

    /// All samples of the running iteration, in plans of up to `most` samples, or of one pixel where that has more.
    ///
    /// # Errors
    /// If no iteration is running or memory is lacking.
    pub fn plans(&mut self, most: usize) -> Result<Vec<Plan>, Error> {
        let (mut plans, mut first, all) = (Vec::new(), 0, self.area());
        while first < all {
            let plan = self.plan(first, most).or_else(|_| self.plan(first, usize::MAX))?;
            first = plan.piece.end;
            plans.extend((plan.piece.samples > 0).then_some(plan));
        }
        Ok(plans)
    }

    /// Parts a piece where a pixel ends, among its first `samples`: [`Sampler::split`].
    ///
    /// # Errors
    /// As the core.
    pub fn split(&mut self, piece: Piece, samples: usize) -> Result<(Piece, Piece), Error> {
        self.with(|sampler| sampler.split(piece, samples))
    }

    /// Takes the radiances of a plan: [`Sampler::deliver`].
    ///
    /// # Errors
    /// As the core.
    pub fn deliver(&mut self, piece: Piece, radiance: &[[f32; 3]]) -> Result<Tally, Error> {
        self.with(|sampler| sampler.deliver(piece, radiance))
    }

    /// Ends the iteration: [`Sampler::end`].
    ///
    /// # Errors
    /// As the core.
    pub fn end(&mut self) -> Result<Tally, Error> {
        self.with(|sampler| sampler.end())
    }

    /// The picture, rows from the top, on all threads: [`Sampler::resolve`].
    ///
    /// # Errors
    /// As the core, or if memory is lacking.
    pub fn resolve(&mut self, estimator: Estimator) -> Result<Vec<[f32; 3]>, Error> {
        let (mut rgb, mut scratch) = (zeros(self.area())?, self.scratch()?);
        self.with(|sampler| {
            sampler.resolving(estimator, &mut scratch, rgb.as_flattened_mut()).map(resolve_on_all)
        })?;
        Ok(rgb)
    }

    /// Any picture with the energy of the film, on all threads: [`Sampler::resolve_guided`].
    ///
    /// # Errors
    /// As the core, or if memory is lacking.
    pub fn resolve_guided(&mut self, guide: &[[f32; 3]]) -> Result<Vec<[f32; 3]>, Error> {
        let (mut rgb, mut scratch) = (zeros(self.area())?, self.scratch()?);
        self.with(|sampler| sampler.resolving_guided(guide, &mut scratch, &mut rgb).map(resolve_on_all))?;
        Ok(rgb)
    }

    /// The filtered picture with the energy of the film, on all threads; `features` are one a pixel or none.
    ///
    /// # Errors
    /// As the core, or if memory is lacking.
    pub fn guided(&mut self, features: &[Feature]) -> Result<Vec<[f32; 3]>, Error> {
        let (width, height) = (self.settings().width, self.settings().height);
        let mut floats = zeros(Filter::required_with_labels(width, height))?;
        let (mut guide, mut level) = (zeros(self.area())?, zeros(self.area())?);
        let mut scratch = self.scratch()?;
        self.with(|sampler| {
            let mut filter = Filter::new(sampler, features, &mut floats)?;
            for _ in 0..Filter::PASSES {
                let bands: Vec<_> = filter.bands().collect();
                bands.into_par_iter().for_each(|mut band| band.filter());
                filter.next();
            }
            let parts = guide.chunks_mut(ROWS * width as usize).enumerate().collect::<Vec<_>>();
            parts.into_par_iter().try_for_each(|(part, rows)| filter.write_rows(part * ROWS, rows))?;
            sampler.leveling(&guide, &mut scratch, &mut level).map(resolve_on_all)
        })?;
        self.resolve_guided(&level)
    }

    /// Variance of every pixel's mean luminance: [`Sampler::variance`].
    ///
    /// # Errors
    /// If an iteration is running or memory is lacking.
    pub fn variance(&mut self) -> Result<Vec<f32>, Error> {
        self.plane(|sampler, out| sampler.variance(out))
    }

    /// Samples of every pixel: [`Sampler::count`].
    ///
    /// # Errors
    /// If an iteration is running or memory is lacking.
    pub fn count(&mut self) -> Result<Vec<u32>, Error> {
        self.plane(|sampler, out| sampler.count(out))
    }

    /// The kernel: [`Sampler::alpha`].
    ///
    /// # Errors
    /// If memory is lacking.
    pub fn alpha(&mut self) -> Result<Vec<f32>, Error> {
        self.plane(|sampler, out| sampler.alpha(out))
    }

    /// The film as bytes, also in the middle of an iteration, to go on another day or on another machine.
    ///
    /// # Errors
    /// If memory is lacking.
    pub fn save(&mut self) -> Result<Vec<u8>, Error> {
        let mut bytes = zeros(self.with(|sampler| Ok(sampler.saved_len()))?)?;
        self.with(|sampler| sampler.save(&mut bytes))?;
        Ok(bytes)
    }

    /// Takes in a film of the same frame with another seed, as [`save`](Self::save) wrote it: [`Sampler::merge`].
    ///
    /// # Errors
    /// If it is no film of this version, or of another frame.
    pub fn merge(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let saved = Saved::new(bytes).map_err(Error::setting)?;
        self.with(|sampler| sampler.merge(&saved))
    }

    fn plane<T: Clone + Default>(
        &mut self,
        read: impl FnOnce(&Sampler<'_>, &mut [T]) -> Result<(), CoreError>,
    ) -> Result<Vec<T>, Error> {
        let mut out = zeros(self.area())?;
        self.with(|sampler| read(sampler, &mut out))?;
        Ok(out)
    }

    /// Pixels of the picture.
    fn area(&self) -> usize {
        self.settings().width as usize * self.settings().height as usize
    }

    fn scratch(&self) -> Result<Vec<[f32; 16]>, Error> {
        zeros(Sampler::resolve_scratch(self.settings().width, self.settings().height))
    }
}
