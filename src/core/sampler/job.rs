//! A run of tiles to be sampled by one thread.

use super::settings::{Error, Sequence};
use crate::batch::{Batch8, Integrand, Rgb8};
use crate::estimate::{Estimator, Weight};
use crate::film::{Layout, Moments, Planes, Tile};
use crate::sobol::{self, hash};
use wide::{f32x8, u32x8};

/// Samples a job has at least, the last one of an iteration excepted.
const JOB_SAMPLES: u64 = 4096;
/// Radiances beyond this are rejected like those that are not finite: their squares would overflow.
pub const MAX_RADIANCE: f32 = 1e15;

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
    pub seed: u32,
    pub frame: u32,
    pub sequence: Sequence,
    pub iteration: u32,
    pub estimator: Estimator,
    pub weight: Weight,
}

impl Context {
    /// Key of a pixel's sequence and the number of its next point.
    #[inline]
    fn start(&self, x: u32, y: u32, drawn: u32) -> (u32, u32) {
        let key = sobol::pixel_key(self.seed, self.frame, x, y);
        match self.sequence {
            Sequence::Continued => (key, drawn),
            Sequence::Fresh => (hash(key ^ hash(self.iteration)), 0),
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
        Some(Job::new(planes, self.context, first, samples))
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
    samples: u64,
    filled: u64,
    accepted: u64,
    rejected: u64,
    next: Place,
    /// Pixel whose samples are being accepted, how many of them were, and what is known of them.
    pixel: usize,
    taken: u32,
    partial: Moments,
}

/// The pixel whose samples are being handed out.
#[derive(Clone, Copy, Debug)]
struct Place {
    pixel: usize,
    number: u32,
    tile: Tile,
    tile_number: u32,
    dx: u32,
    dy: u32,
    key: u32,
    index: u32,
}

impl<'a> Job<'a> {
    fn new(planes: Planes<'a>, context: Context, tile_number: u32, samples: u64) -> Self {
        let tile = context.layout.tile(tile_number);
        let (key, index) = context.start(tile.x0, tile.y0, planes.drawn[0]);
        let next = Place { pixel: 0, number: 0, tile, tile_number, dx: 0, dy: 0, key, index };
        let partial = Moments::default();
        Job {
            planes,
            context,
            samples,
            filled: 0,
            accepted: 0,
            rejected: 0,
            next,
            pixel: 0,
            taken: 0,
            partial,
        }
    }

    /// Number of samples planned.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Takes all samples.
    pub fn render(&mut self, integrand: &mut impl Integrand, work: &mut Workspace<'_>) -> Tally {
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
            *batch = self.fill_one();
        }
        used
    }

    fn fill_one(&mut self) -> Batch8 {
        let lanes = (self.samples - self.filled).min(8) as usize;
        let (mut x, mut y) = ([0.0; 8], [0.0; 8]);
        let (mut index, mut key) = ([0; 8], [0; 8]);
        for lane in 0..8 {
            if lane < lanes {
                self.seek();
                (index[lane], key[lane]) = (self.next.index.wrapping_add(self.next.number), self.next.key);
                x[lane] = (self.next.tile.x0 + self.next.dx) as f32;
                y[lane] = (self.next.tile.y0 + self.next.dy) as f32;
                self.next.number += 1;
            } else {
                (x[lane], y[lane]) = (x[lanes - 1], y[lanes - 1]);
                (index[lane], key[lane]) = (index[lanes - 1], key[lanes - 1]);
            }
        }
        self.filled += lanes as u64;
        let (index, key) = (u32x8::from(index), u32x8::from(key));
        let (u, v) = sobol::point(index, key, 0);
        Batch8 { lanes: lanes as u32, x: inside(x.into(), u), y: inside(y.into(), v), index, key }
    }

    /// Moves to the next pixel that has a sample left to hand out. There must be one.
    #[inline]
    fn seek(&mut self) {
        let next = &mut self.next;
        if next.number < self.planes.planned[next.pixel] {
            return;
        }
        while next.number >= self.planes.planned[next.pixel] {
            next.step(&self.context.layout);
        }
        let (x, y) = (next.tile.x0 + next.dx, next.tile.y0 + next.dy);
        (next.key, next.index) = self.context.start(x, y, self.planes.drawn[next.pixel]);
    }

    /// Takes the radiances of the samples handed out, in the same order; superfluous ones are ignored.
    pub fn accept(&mut self, radiance: &[Rgb8]) {
        for rgb in radiance {
            let lanes = (self.filled - self.accepted).min(8) as usize;
            let usable = usable(rgb);
            let (r, g, b) = (rgb.r.to_array(), rgb.g.to_array(), rgb.b.to_array());
            (0..lanes).for_each(|lane| self.accept_one([r[lane], g[lane], b[lane]], usable >> lane & 1 == 1));
            self.accepted += lanes as u64;
        }
    }

    #[inline(always)]
    fn accept_one(&mut self, rgb: [f32; 3], usable: bool) {
        while self.taken == self.planes.planned[self.pixel] {
            (self.pixel, self.taken, self.partial) = (self.pixel + 1, 0, Moments::default());
        }
        if usable {
            self.partial.add(rgb);
        } else {
            self.rejected += 1;
        }
        self.taken += 1;
        if self.taken == self.planes.planned[self.pixel] {
            let mut pixel = self.planes.pixel(self.pixel);
            self.context.estimator.arrive(&mut pixel, &self.partial, self.taken, self.context.weight);
            pixel.merge(&self.partial, self.taken);
        }
    }

    /// Samples accepted so far.
    pub fn tally(&self) -> Tally {
        Tally { samples: self.accepted - self.rejected, rejected: self.rejected }
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
fn inside(pixel: f32x8, offset: f32x8) -> f32x8 {
    let end: u32x8 = bytemuck::cast(pixel + f32x8::ONE);
    let last: f32x8 = bytemuck::cast(end - u32x8::splat(1));
    (pixel + offset).fast_min(last)
}
