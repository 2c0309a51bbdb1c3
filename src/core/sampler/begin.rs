//! The beginning of an iteration in parts, for machines of many cores.
//!
//! [`Sampler::begin`](super::Sampler::begin) takes some ten nanoseconds a pixel of one thread. A [`Beginning`] is the same, in
//! steps whose parts can be worked on by any threads in any order: weights of the pixels, their sums over runs of 64, and
//! counts. Between steps there is a little that one thread does: it adds all weights, in the order of a single thread, so that
//! the counts have the same bits whoever worked on what.
//!
//! A part that nobody has worked on is worked on where it is dropped, and so is all that is left of a beginning: an iteration
//! has begun when its beginning is gone.
//!
//! ```
//! use pmcip_core::predict::Prior;
//! use pmcip_core::sampler::{Memory, Sampler, Settings};
//!
//! let (mut floats, mut words) = ([0.0; 8 * 64], [0; 3 * 64]); // as Sampler::required(8, 8) says
//! let mut sampler = Sampler::new(Settings::new(8, 8), Memory { floats: &mut floats, words: &mut words })?;
//! let mut beginning = sampler.beginning(256, Prior::Beliefs(&[]))?;
//! while let Some(parts) = beginning.parts() {
//!     std::thread::scope(|scope| {
//!         for mut part in parts {
//!             scope.spawn(move || part.work()); // or by the threads you have
//!         }
//!     });
//! }
//! drop(beginning);
//! assert_eq!(sampler.jobs().map(|job| job.samples()).sum::<u64>(), 256);
//! # Ok::<(), pmcip_core::sampler::Error>(())
//! ```
//!
//! Where not all pixels get something, by labels or by a lent kernel, one thread also adds the weights before each part.

use super::allocate::open::CLOSED;
use super::allocate::{self, Before, Known, Mixture, Shares, words};
use super::estimate::Estimator;
use super::fair::Fair;
use super::film::{Layout, Planes};
use super::kernel::UNKNOWN;
use super::settings::{Error, Mode};
use super::state::State;
use crate::maths::sobol::{frame_key, hash};
use crate::predict::Prior;
use parts::{Counting, TILES, Task, Weighing};

mod parts;
pub use parts::{Part, Parts};

/// An iteration on its way: see [`begin`](self).
#[derive(Debug)]
pub struct Beginning<'s> {
    state: &'s mut State,
    layout: Layout,
    planes: Planes<'s>,
    prior: Prior<'s>,
    /// Whether samples follow weights.
    adaptive: bool,
    /// The state of the sampler when the iteration has begun.
    ahead: State,
    /// What is promised to the pixels, unless that is more than there is.
    promised: Fair,
    /// Samples that they lack of it.
    missing: u64,
    next: Step,
}

/// What is to be done next.
#[derive(Clone, Copy, Debug)]
enum Step {
    Weights,
    /// Weights are there: who gets which share?
    Shares,
    Counts(Shares),
    End,
}

impl<'s> Beginning<'s> {
    pub(super) fn new(
        state: &'s mut State,
        layout: Layout,
        planes: Planes<'s>,
        samples: u64,
        prior: Prior<'s>,
    ) -> Result<Self, Error> {
        let entries = match prior {
            Prior::Beliefs(beliefs) => beliefs.len(),
            Prior::Alpha(alpha) => alpha.len(),
        };
        if entries != 0 && entries != layout.pixels() {
            return Err(Error::Prior);
        }
        if state.running > 0 {
            return Err(Error::Begun);
        }
        if samples == 0 || samples > allocate::MAX_SAMPLES {
            return Err(Error::Samples);
        }
        let settings = &state.settings;
        let adaptive = settings.mode == Mode::Adaptive && (state.iteration > 0 || is_lent(prior));
        // m, samples that every pixel expects at least in an adaptive iteration, beyond what was promised.
        let floor = if settings.estimator == Estimator::Subframe { 1.0 } else { 0.0 };
        let mixture = match adaptive {
            true => Mixture { samples, floor, epsilon: settings.epsilon },
            false => Mixture { samples, floor: 0.0, epsilon: 1.0 },
        };
        allocate::check(layout.pixels(), &mixture)?;
        let mut ahead = State { mixture, running: samples, ..*state };
        if state.iteration == 0 {
            let count = if settings.mode == Mode::Uniform { u32::MAX } else { settings.fair };
            let given = if adaptive { 0 } else { (samples / state.used as u64) as u32 };
            ahead.fair = Fair::new(count, given);
        }
        let each = f64::from(settings.defensive) * samples as f64 / state.used as f64;
        let promised = ahead.fair.promise(each);
        Ok(Beginning {
            state,
            layout,
            planes,
            prior,
            adaptive,
            ahead,
            promised,
            missing: 0,
            next: Step::Weights,
        })
    }

    /// The next parts to be worked on, by any threads in any order, or none if there are no more: the iteration has begun.
    ///
    /// Before that it does itself what cannot be divided, given that the parts before are done.
    pub fn parts(&mut self) -> Option<Parts<'_>> {
        match self.next {
            Step::Weights if self.adaptive => {
                self.next = Step::Shares;
                let task = Task::Weigh(self.weighing());
                Some(self.divided(task))
            }
            Step::Weights | Step::Shares => {
                self.missing = self.missing_of_parts();
                let shares = self.share(None);
                let every_one = self.is_for_all();
                if every_one { Some(self.divided(Task::Sum(shares))) } else { self.parts() }
            }
            Step::Counts(shares) => {
                self.next = Step::End;
                let task = Task::Count(self.counting(shares));
                Some(self.divided(task))
            }
            Step::End => {
                *self.state = self.ahead;
                None
            }
        }
    }

    /// Does all that is left: the weights are summed while they are at hand, and no sums are kept.
    fn finish(&mut self) {
        let known = match self.next {
            Step::Weights if self.adaptive => Some(self.weigh()),
            Step::Shares => {
                self.missing = self.missing_of_parts();
                None
            }
            _ => None,
        };
        if let Step::Weights | Step::Shares = self.next {
            self.share(known);
        }
        if let Step::Counts(shares) = self.next {
            let counting = self.counting(shares);
            let (seen, target, planned) = self.planes.apart();
            counting.count(0, &seen, target, planned);
        }
        *self.state = self.ahead;
    }

    /// The planes, to be divided into the parts of a task.
    fn divided<'p>(&'p mut self, task: Task<'p>) -> Parts<'p> {
        Parts::new(task, self.layout, self.planes.apart())
    }

    fn weighing(&self) -> Weighing<'s> {
        let kernel = self.state.settings.kernel();
        Weighing { kernel, layout: self.layout, prior: self.prior, promised: self.promised }
    }

    fn counting(&self, shares: Shares) -> Counting {
        let fair = (self.missing > 0).then_some(self.ahead.fair);
        Counting { shares, before: Before::default(), for_all: self.is_for_all(), fair }
    }

    /// Whether every pixel gets something.
    fn is_for_all(&self) -> bool {
        self.ahead.open == self.layout.pixels()
    }

    /// Weighs all pixels, counts what they lack, and returns the sum of the weights as [`known`](Self::known) does.
    fn weigh(&mut self) -> Known {
        let (weighing, tiles, mut known) = (self.weighing(), 0..self.layout.tiles(), Known::default());
        let (seen, target, _) = self.planes.apart();
        self.missing = weighing.weigh(tiles, &seen, target, |weights| known.add(weights));
        known
    }

    /// What the parts have counted that the pixels lack.
    fn missing_of_parts(&self) -> u64 {
        let firsts = (0..self.layout.tiles()).step_by(TILES as usize).map(|tile| self.layout.start(tile));
        let ends = (TILES..).step_by(TILES as usize).map(|tile| self.layout.start(tile));
        firsts.zip(ends).map(|(first, end)| words::kept(&self.planes.planned[first..end])).sum()
    }

    /// Decides who gets which share; `known` is the sum of the weights tile by tile, if somebody has it already.
    fn share(&mut self, known: Option<Known>) -> Shares {
        let lent = self.adaptive && is_lent(self.prior);
        self.ahead.open = self.close(lent);
        self.promise(lent);
        self.ahead.mixture.samples -= self.missing;
        let known = match (self.adaptive, known) {
            (false, _) => Known::default(),
            (true, Some(known)) if self.is_for_all() && !lent => known,
            (true, _) => self.known(lent),
        };
        let settings = &self.state.settings;
        let offset = hash(frame_key(!settings.seed, settings.frame) ^ self.state.iteration);
        let shares = Shares::new(&self.ahead.mixture, self.ahead.open, &known, offset);
        self.next = Step::Counts(shares);
        shares
    }

    /// The sum of the weights: tile by tile, or of all at once where they are `lent` or some pixels are closed.
    fn known(&self, lent: bool) -> Known {
        let (mut known, target) = (Known::default(), &*self.planes.target);
        match self.is_for_all() && !lent {
            true => {
                let tiles = (0..self.layout.tiles()).map(|t| self.layout.tile(t));
                tiles.for_each(|tile| known.add(&target[tile.first..tile.first + tile.pixels()]));
            }
            false => known.add(target),
        }
        known
    }

    /// Closes the pixels that are not there, and returns how many get samples; a `lent` kernel closes others, too.
    fn close(&mut self, lent: bool) -> usize {
        let Planes { target, label, .. } = &mut self.planes;
        let outside = target.iter_mut().zip(*label).filter(|(_, label)| **label == 0);
        outside.for_each(|(target, _)| *target = CLOSED);
        if !lent {
            return self.state.used;
        }
        match target.iter().filter(|target| **target != CLOSED).count() {
            // A kernel that gives nobody anything says nothing.
            0 => {
                let inside = target.iter_mut().enumerate().filter(|(i, _)| label.get(*i) != Some(&0));
                inside.for_each(|(_, target)| *target = UNKNOWN);
                self.state.used
            }
            open => open,
        }
    }

    /// Promises fair samples with the iteration, as far as it has enough; a `lent` kernel takes some pixels out.
    fn promise(&mut self, lent: bool) {
        if !self.adaptive {
            self.missing = 0;
            return;
        }
        if lent {
            self.missing = self.lacking(self.promised);
        }
        // What is due to few pixels cannot always be rounded to fewer samples than there are.
        let samples = self.ahead.running;
        if self.missing > samples {
            // After films have been merged even what was promised before can be more: it waits.
            self.missing =
                Some(self.lacking(self.ahead.fair)).filter(|missing| *missing <= samples).unwrap_or(0);
        } else {
            self.ahead.fair = self.promised;
        }
    }

    /// How many samples the pixels lack together that can get some.
    fn lacking(&self, fair: Fair) -> u64 {
        let Planes { drawn, target, .. } = &self.planes;
        let closed = match self.ahead.open == self.ahead.used {
            true => 0,
            false => {
                let closed = target.iter().enumerate().filter(|(_, target)| **target == CLOSED);
                closed.map(|(i, _)| u64::from(fair.missing(i, drawn[i]))).sum()
            }
        };
        fair.total(0, drawn) - closed
    }
}

impl Drop for Beginning<'_> {
    fn drop(&mut self) {
        self.finish();
    }
}

/// Whether it is a kernel that takes the place of the frame's own.
fn is_lent(prior: Prior<'_>) -> bool {
    matches!(prior, Prior::Alpha(alpha) if !alpha.is_empty())
}
