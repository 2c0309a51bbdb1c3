//! A run of tiles to be sampled by one thread.

use super::fair::Fair;
use super::settings::{Error, Sequence};
use crate::maths::eight::{read_rgb8, write8};
use crate::maths::sobol::{self, PixelKeys};
use crate::sampler::batch::{Batch8, Integrand, MAX_RADIANCE, Rgb8, Wave};
use crate::sampler::estimate::Estimator;
use crate::sampler::film::arrivals::{Arrivals, GROUP, Sample, Sums, samples};
use crate::sampler::film::{Layout, Planes, Tile};
use core::ops::Range;
use wide::{f32x8, u32x8};

/// Samples a job has at least, the last one of an iteration excepted.
const JOB_SAMPLES: u64 = 4096;

/// Memory a thread lends to the jobs it renders.
#[derive(Debug)]
pub struct Workspace<'a> {
    batches: &'a mut [Batch8],
    radiance: &'a mut [Rgb8],
}

impl<'a> Workspace<'a> {
    /// A workspace of any size; the shorter slice says how many batches an integrand is handed at once.
    ///
    /// # Errors
    /// If a slice is empty.
    pub fn new(batches: &'a mut [Batch8], radiance: &'a mut [Rgb8]) -> Result<Self, Error> {
        if batches.is_empty() || radiance.is_empty() {
            return Err(Error::Workspace);
        }
        Ok(Workspace { batches, radiance })
    }
}

/// Samples taken, and samples that were not usable.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Samples that entered the film.
    pub samples: u64,
    /// Samples left out because a component was not finite or beyond [`MAX_RADIANCE`].
    pub rejected: u64,
}

impl core::ops::AddAssign for Tally {
    fn add_assign(&mut self, other: Tally) {
        self.samples += other.samples;
        self.rejected += other.rejected;
    }
}

/// What all jobs of an iteration have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct Context {
    pub layout: Layout,
    pub keys: PixelKeys,
    /// Key of the iteration.
    pub iteration: u32,
    pub sequence: Sequence,
    pub fair: Fair,
    pub estimator: Estimator,
    /// Part of the iteration in all samples, itself included.
    pub share: f32,
}

impl Context {
    /// Keys of the sequences of the pixels at `place`, a row in the upper and a column in the lower half.
    #[inline(always)]
    fn keys(&self, place: u32x8) -> u32x8 {
        let key = self.keys.at(place);
        match self.sequence {
            Sequence::Continued => key,
            Sequence::Fresh => sobol::hash8(key ^ u32x8::splat(self.iteration)),
        }
    }

    /// Number of the next point of a pixel's sequence.
    #[inline(always)]
    fn index(&self, drawn: u32) -> u32 {
        if self.sequence == Sequence::Continued { drawn } else { 0 }
    }

    /// How many of a pixel's `planned` samples, the first ones, its estimator's own mean is made of.
    #[inline(always)]
    fn own(&self, planned: u32, drawn: u32) -> u32 {
        match self.estimator {
            Estimator::Pooled => 0,
            Estimator::Subframe => planned,
            Estimator::Difference | Estimator::Balanced | Estimator::Guided => {
                self.fair.among(planned, drawn)
            }
        }
    }

    /// How far `taken` such samples move that mean.
    #[inline(always)]
    fn own_share(&self, taken: u32, drawn: u32) -> f32 {
        match self.estimator {
            Estimator::Subframe => self.share,
            _ => taken as f32 / (drawn as f32 + taken as f32),
        }
    }
}

/// The jobs of an iteration, in storage order.
///
/// Where one ends and the next begins depends on the planned counts only, so results are the same bits for any
/// number of threads and any order.
#[derive(Debug)]
pub struct Jobs<'a> {
    pub(super) rest: Planes<'a>,
    pub(super) context: Context,
    pub(super) next_tile: u32,
    pub(super) tiles: u32,
}

impl<'a> Iterator for Jobs<'a> {
    type Item = Job<'a>;

    fn next(&mut self) -> Option<Job<'a>> {
        let (first, mut samples, mut pixels) = (self.next_tile, 0, 0);
        while samples < JOB_SAMPLES && self.next_tile < self.tiles {
            let tile = self.context.layout.tile(self.next_tile);
            let planned = &self.rest.planned[pixels..pixels + tile.pixels()];
            samples += planned.iter().map(|n| u64::from(*n)).sum::<u64>();
            pixels += tile.pixels();
            self.next_tile += 1;
        }
        if first == self.next_tile {
            return None;
        }
        let rest = core::mem::replace(&mut self.rest, Planes::empty());
        let (planes, rest) = rest.split_at(pixels);
        self.rest = rest;
        Some(Job::new(planes, self.context, (first, 0, 0), samples))
    }
}

/// A run of tiles and the samples planned for it. Can be sent to another thread.
///
/// [`render`](Self::render) does all of it. A caller with a loop of his own asks [`fill`](Self::fill) for
/// batches and hands the radiances back to [`accept`](Self::accept), until `fill` returns 0.
#[derive(Debug)]
pub struct Job<'a> {
    planes: Planes<'a>,
    context: Context,
    first_tile: u32,
    samples: u64,
    filled: u64,
    accepted: u64,
    next: Place,
    last: Accepting,
    arrivals: Arrivals,
}

/// The pixel whose samples are being accepted.
#[derive(Clone, Copy, Debug)]
struct Accepting {
    pixel: usize,
    /// Samples planned that are still to come, and how many are when those end that the estimator's own mean is made of.
    left: u32,
    fair_end: u32,
    sums: Sums,
    rejected: u64,
}

/// The pixel whose samples are being handed out.
#[derive(Clone, Copy, Debug)]
struct Place {
    pixel: usize,
    /// Number of the next sample in this iteration, and how many are planned.
    number: u32,
    planned: u32,
    tile: Tile,
    tile_number: u32,
    dx: u32,
    dy: u32,
    /// Number of the iteration's first point in the pixel's sequence.
    index: u32,
}

impl<'a> Job<'a> {
    /// A job of pixels that follow each other, the first of which is at a [place](Layout::place).
    pub(super) fn new(
        planes: Planes<'a>,
        context: Context,
        (tile_number, dx, dy): (u32, u32, u32),
        samples: u64,
    ) -> Self {
        let tile = context.layout.tile(tile_number);
        let (planned, index) = (planes.planned[0], context.index(planes.drawn[0]));
        let next = Place { pixel: 0, number: 0, planned, tile, tile_number, dx, dy, index };
        let mut last = Accepting { pixel: 0, left: 0, fair_end: 0, sums: Sums::default(), rejected: 0 };
        last.start(&context, &planes, 0);
        let arrivals = Arrivals::NONE;
        let first_tile = tile_number;
        Job { planes, context, first_tile, samples, filled: 0, accepted: 0, next, last, arrivals }
    }

    /// Number of samples planned.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// The tiles whose pixels it has, by their [numbers](Layout::tile): other ones in every job, rising from job to job.
    pub fn tiles(&self) -> Range<u32> {
        let (mut end, mut pixels) = (self.first_tile, 0);
        while pixels < self.planes.count.len() {
            pixels += self.context.layout.tile(end).pixels();
            end += 1;
        }
        self.first_tile..end
    }

    /// Columns and rows of the smallest rectangle that holds all its pixels.
    pub fn bounds(&self) -> (Range<u32>, Range<u32>) {
        let nothing = Range { start: u32::MAX, end: 0 };
        self.tiles().map(|t| self.context.layout.tile(t)).fold(
            (nothing.clone(), nothing),
            |(columns, rows), tile| {
                (
                    columns.start.min(tile.x0)..columns.end.max(tile.x0 + tile.width),
                    rows.start.min(tile.y0)..rows.end.max(tile.y0 + tile.height),
                )
            },
        )
    }

    /// Takes all samples. The integrand can be a closure, or a `&mut dyn Integrand`.
    pub fn render(&mut self, integrand: &mut (impl Integrand + ?Sized), work: &mut Workspace<'_>) -> Tally {
        let room = work.batches.len().min(work.radiance.len());
        loop {
            let used = self.fill(&mut work.batches[..room]);
            if used == 0 {
                return self.tally();
            }
            integrand.stream(&work.batches[..used], &mut work.radiance[..used]);
            self.accept(&work.radiance[..used]);
        }
    }

    /// Fills batches with the next samples, in storage order of their pixels, and returns how many were filled.
    ///
    /// Only the last batch of the job can have unused lanes.
    pub fn fill(&mut self, batches: &mut [Batch8]) -> usize {
        let left = (self.samples - self.filled).div_ceil(8);
        let used = batches.len().min(usize::try_from(left).unwrap_or(usize::MAX));
        for batch in &mut batches[..used] {
            *batch = self.fill_lanes((self.samples - self.filled).min(8) as usize);
        }
        used
    }

    fn fill_lanes(&mut self, lanes: usize) -> Batch8 {
        let (mut index, mut place) = ([0; 8], [0; 8]);
        let mut lane = 0;
        while lane < lanes {
            self.seek();
            let run = lanes.min(lane + (self.next.planned - self.next.number) as usize);
            let (x, y) = (self.next.tile.x0 + self.next.dx, self.next.tile.y0 + self.next.dy);
            let at = y << 16 | x;
            let first = self.next.index.wrapping_add(self.next.number);
            for k in lane..run {
                (index[k], place[k]) = (first.wrapping_add((k - lane) as u32), at);
            }
            self.next.number += (run - lane) as u32;
            lane = run;
        }
        for k in lanes..8 {
            (index[k], place[k]) = (index[lanes - 1], place[lanes - 1]);
        }
        self.filled += lanes as u64;
        let (index, place) = (u32x8::from(index), u32x8::from(place));
        let key = self.context.keys(place);
        let (u, v) = sobol::point(index, key, 0);
        let (x, y) = (place & u32x8::splat(0xffff), place >> 16);
        Batch8 { lanes: lanes as u32, x: inside(x, u), y: inside(y, v), index, key }
    }

    /// Moves to the next pixel that has a sample left to hand out. There must be one.
    #[inline(always)]
    fn seek(&mut self) {
        let next = &mut self.next;
        if next.number < next.planned {
            return;
        }
        while next.number >= next.planned {
            next.step(&self.context.layout);
            next.planned = self.planes.planned[next.pixel];
        }
        next.index = self.context.index(self.planes.drawn[next.pixel]);
    }

    /// Writes the next samples into flat arrays, as many as fit, and returns how many: as [`fill`](Self::fill), for
    /// [`deliver`](Self::deliver). A job is driven by one of the two pairs.
    pub fn plan(&mut self, wave: &mut Wave<'_>) -> usize {
        let left = usize::try_from(self.samples - self.filled).unwrap_or(usize::MAX);
        let (room, mut at) = (wave.len().min(left), 0);
        while at < room {
            let lanes = (room - at).min(8);
            let batch = self.fill_lanes(lanes);
            let (index, key) = (batch.index.to_array(), batch.key.to_array());
            write8(&mut wave.x[at..at + lanes], batch.x);
            write8(&mut wave.y[at..at + lanes], batch.y);
            wave.index[at..at + lanes].copy_from_slice(&index[..lanes]);
            wave.key[at..at + lanes].copy_from_slice(&key[..lanes]);
            at += lanes;
        }
        room
    }

    /// Takes the radiances of the next of the samples that [`plan`](Self::plan) has written, in the same order; superfluous
    /// ones are ignored.
    pub fn deliver(&mut self, radiance: &[[f32; 3]]) {
        let due = usize::try_from(self.filled - self.accepted).unwrap_or(usize::MAX);
        for rgb in radiance[..due.min(radiance.len())].chunks(8) {
            let [r, g, b] = read_rgb8(rgb);
            let eight = Rgb8 { r, g, b };
            self.accept_batch(&samples(&eight)[..rgb.len()], usable(&eight));
            self.accepted += rgb.len() as u64;
        }
        self.finish();
    }

    /// What becomes of a new job if `radiance` are those of all its samples.
    pub(super) fn delivered(mut self, radiance: &[[f32; 3]]) -> Tally {
        self.filled = self.samples;
        self.deliver(radiance);
        self.tally()
    }

    /// Takes the radiances of the samples handed out, in the same order; superfluous ones are ignored.
    pub fn accept(&mut self, radiance: &[Rgb8]) {
        for rgb in radiance {
            let lanes = (self.filled - self.accepted).min(8) as usize;
            self.accept_batch(&samples(rgb)[..lanes], usable(rgb));
            self.accepted += lanes as u64;
        }
        self.finish();
    }

    /// Lets the last pixels into the film, if all samples have been accepted.
    fn finish(&mut self) {
        if self.accepted == self.samples {
            self.merge_before((self.last.pixel / GROUP + 1) * GROUP);
        }
    }

    /// Takes samples, of which those with a bit in `usable` enter the film.
    #[inline(always)]
    fn accept_batch(&mut self, samples: &[Sample], usable: u32) {
        let (mut samples, mut usable) = (samples, usable);
        let sound = usable & !(!0 << samples.len()) == !(!0 << samples.len());
        while !samples.is_empty() {
            while self.last.left == 0 {
                self.accept_next();
            }
            // All that are of this pixel and, if they are, of the estimator's own mean.
            let last = &mut self.last;
            let due = if last.left > last.fair_end { last.left - last.fair_end } else { last.left };
            let (run, others) = samples.split_at((due as usize).min(samples.len()));
            if sound {
                last.sums.extend(run);
            } else {
                last.rejected += u64::from(last.sums.extend_by_bits(run, usable));
                usable >>= run.len();
            }
            last.left -= run.len() as u32;
            if last.left == last.fair_end || last.left == 0 {
                self.arrive();
            }
            samples = others;
        }
    }

    /// Lets the samples of a pixel so far into the estimator's own mean, all of them into its moments.
    #[inline(always)]
    fn arrive(&mut self) {
        let last = &self.last;
        let (i, planned, moments) =
            (last.pixel % GROUP, self.planes.planned[last.pixel], last.sums.moments());
        if last.left == last.fair_end {
            let taken = planned - last.fair_end;
            let share = self.context.own_share(taken, self.planes.drawn[last.pixel]);
            self.arrivals.set_fair(i, moments.mean_of(taken), share);
        }
        if last.left == 0 {
            self.arrivals.set(i, &moments, planned);
        }
    }

    /// Goes on to the next pixel.
    #[inline(always)]
    fn accept_next(&mut self) {
        let next = self.last.pixel + 1;
        if next.is_multiple_of(GROUP) {
            self.merge_before(next);
        }
        self.last.start(&self.context, &self.planes, next);
    }

    /// Merges the group of pixels that ends before `end` into the film.
    fn merge_before(&mut self, end: usize) {
        let has_own = self.context.estimator != Estimator::Pooled;
        self.arrivals.merge(&mut self.planes, end - GROUP, has_own);
        self.arrivals = Arrivals::NONE;
    }

    /// Samples accepted so far.
    pub fn tally(&self) -> Tally {
        Tally { samples: self.accepted - self.last.rejected, rejected: self.last.rejected }
    }
}

impl Accepting {
    /// Brings it before the first sample of `pixel`.
    #[inline(always)]
    fn start(&mut self, context: &Context, planes: &Planes<'_>, pixel: usize) {
        (self.pixel, self.left) = (pixel, planes.planned[pixel]);
        self.fair_end = self.left - context.own(self.left, planes.drawn[pixel]);
        self.sums.clear();
    }
}

impl Place {
    /// The next pixel in storage order.
    #[inline]
    fn step(&mut self, layout: &Layout) {
        self.pixel += 1;
        self.number = 0;
        self.dx += 1;
        if self.dx == self.tile.width {
            (self.dx, self.dy) = (0, self.dy + 1);
        }
        if self.dy == self.tile.height {
            self.tile_number += 1;
            (self.tile, self.dy) = (layout.tile(self.tile_number), 0);
        }
    }
}

/// A bit for every lane whose radiance can enter the film.
#[inline(always)]
fn usable(rgb: &Rgb8) -> u32 {
    let limit = f32x8::splat(MAX_RADIANCE);
    let fits = |colour: f32x8| colour.abs().simd_le(limit);
    (fits(rgb.r) & fits(rgb.g) & fits(rgb.b)).to_bitmask()
}

/// `pixel + offset`, kept below `pixel + 1` where the sum would be rounded up to it.
#[inline(always)]
fn inside(pixel: u32x8, offset: f32x8) -> f32x8 {
    let pixel = f32x8::from_i32x8(bytemuck::cast(pixel));
    let end: u32x8 = bytemuck::cast(pixel + f32x8::ONE);
    let last: f32x8 = bytemuck::cast(end - u32x8::splat(1));
    (pixel + offset).fast_min(last)
}
