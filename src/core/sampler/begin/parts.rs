//! What is done to parts of a film when an iteration begins: in runs of tiles, then in runs of pixels.

use crate::predict::Prior;
use crate::sampler::allocate::open::CLOSED;
use crate::sampler::allocate::{Before, Shares, words};
use crate::sampler::fair::Fair;
use crate::sampler::film::{Layout, Seen};
use crate::sampler::kernel::{Kernel, UNKNOWN};
use core::ops::Range;

/// Tiles whose weights are a part.
pub(super) const TILES: u32 = 32;
/// Pixels whose counts are a part: whole runs of an allocation.
const PIXELS: usize = 8192;

/// What is done to parts of the planes `target` and `planned`.
#[derive(Clone, Copy, Debug)]
pub(super) enum Task<'p> {
    /// Weights come to be, and what their pixels lack is kept in the part's first words.
    Weigh(Weighing<'p>),
    /// Sums of weights are kept.
    Sum(Shares),
    /// Weights become counts.
    Count(Counting),
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Weighing<'p> {
    pub kernel: Kernel,
    pub layout: Layout,
    pub prior: Prior<'p>,
    /// What is promised to the pixels.
    pub promised: Fair,
}

impl Weighing<'_> {
    /// Writes the weights of some tiles, calls `done` with those of each, unless the kernel is lent, and returns how many
    /// samples their pixels lack.
    pub fn weigh(
        &self,
        tiles: Range<u32>,
        seen: &Seen<'_>,
        target: &mut [f32],
        done: impl FnMut(&[f32]),
    ) -> u64 {
        let first = self.layout.start(tiles.start);
        let missing = self.promised.total(first, &seen.drawn[first..first + target.len()]);
        match self.prior {
            Prior::Beliefs(beliefs) => self.kernel.adapt(&self.layout, tiles, seen, target, beliefs, done),
            Prior::Alpha([]) => self.kernel.adapt(&self.layout, tiles, seen, target, &[], done),
            Prior::Alpha(alpha) => self.layout.for_each_run_of(tiles, |run, raster| {
                let target = &mut target[run.start - first..run.end - first];
                target.iter_mut().zip(&alpha[raster..]).for_each(|(target, alpha)| *target = lent(*alpha));
            }),
        }
        missing
    }
}

/// The weight that a lent kernel gives.
fn lent(alpha: f32) -> f32 {
    match alpha {
        0.0 => CLOSED,
        alpha if alpha.is_finite() && alpha > 0.0 => alpha,
        _ => UNKNOWN,
    }
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Counting {
    pub shares: Shares,
    /// What comes before the pixels.
    pub before: Before,
    /// Whether every pixel of the film gets something.
    pub for_all: bool,
    /// What is promised to the pixels, if they lack any of it.
    pub fair: Option<Fair>,
}

impl Counting {
    /// Makes counts of the weights of pixels from the `first` on.
    pub fn count(&self, first: usize, seen: &Seen<'_>, target: &mut [f32], planned: &mut [u32]) {
        match self.for_all {
            true => self.shares.divide(self.before, target, planned),
            false => self.shares.divide_open(self.before, target, planned),
        }
        let Some(fair) = self.fair else { return };
        let pixels = planned.iter_mut().zip(target).zip(&seen.drawn[first..]);
        for (k, ((planned, target), drawn)) in pixels.enumerate() {
            *planned += if *target == CLOSED { 0 } else { fair.missing(first + k, *drawn) };
        }
    }
}

/// Parts of a [`Beginning`](super::Beginning) that can be worked on at the same time.
#[derive(Debug)]
pub struct Parts<'p> {
    task: Task<'p>,
    layout: Layout,
    seen: Seen<'p>,
    /// The next tile, and the next pixel.
    tile: u32,
    first: usize,
    target: &'p mut [f32],
    planned: &'p mut [u32],
}

impl<'p> Parts<'p> {
    /// The parts of a task, of what all may see and the planes `target` and `planned`.
    pub(super) fn new(
        task: Task<'p>,
        layout: Layout,
        (seen, target, planned): (Seen<'p>, &'p mut [f32], &'p mut [u32]),
    ) -> Self {
        Parts { task, layout, seen, tile: 0, first: 0, target, planned }
    }
}

impl<'p> Iterator for Parts<'p> {
    type Item = Part<'p>;

    fn next(&mut self) -> Option<Part<'p>> {
        if self.target.is_empty() {
            return None;
        }
        let (task, first, tiles) =
            (self.task, self.first, self.tile..self.layout.tiles().min(self.tile + TILES));
        let pixels = match task {
            Task::Weigh(_) => self.layout.start(tiles.end) - first,
            Task::Sum(_) | Task::Count(_) => PIXELS.min(self.target.len()),
        };
        let (target, rest) = core::mem::take(&mut self.target).split_at_mut(pixels);
        self.target = rest;
        let (planned, rest) = core::mem::take(&mut self.planned).split_at_mut(pixels);
        self.planned = rest;
        (self.tile, self.first) = (tiles.end, first + pixels);
        if let Task::Count(Counting { shares, before, for_all, .. }) = &mut self.task {
            *before = if *for_all { before.and_runs(planned) } else { before.and_open(shares, target) };
        }
        Some(Part { task: Some(task), seen: self.seen, tiles, first, target, planned })
    }
}

impl Drop for Parts<'_> {
    fn drop(&mut self) {
        self.for_each(drop);
    }
}

/// A part of the beginning. Can be sent to another thread.
#[derive(Debug)]
pub struct Part<'p> {
    /// What is to be done, if it is not done.
    task: Option<Task<'p>>,
    seen: Seen<'p>,
    tiles: Range<u32>,
    first: usize,
    target: &'p mut [f32],
    planned: &'p mut [u32],
}

impl Part<'_> {
    /// Does the work; a second time there is none.
    pub fn work(&mut self) {
        match self.task.take() {
            Some(Task::Weigh(weighing)) => {
                let missing = weighing.weigh(self.tiles.clone(), &self.seen, self.target, |_| ());
                words::keep(self.planned, missing);
            }
            Some(Task::Sum(shares)) => shares.sum_runs(self.target, self.planned),
            Some(Task::Count(counting)) => counting.count(self.first, &self.seen, self.target, self.planned),
            None => {}
        }
    }
}

impl Drop for Part<'_> {
    fn drop(&mut self) {
        self.work();
    }
}
