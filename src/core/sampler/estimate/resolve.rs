//! A picture in parts, for machines of many cores.
//!
//! [`Sampler::resolve`](crate::sampler::Sampler::resolve) takes some nanoseconds a pixel of one thread. A [`Resolving`] is the
//! same, in steps whose parts, bands of rows, can be worked on by any threads in any order. Where energy is given back, what
//! cells have lost is summed, then it is spread; between the two one thread smooths over cells of 8 × 8 pixels. The bits are
//! the same whoever works on what. With labels these are two steps for each island that is large.
//!
//! A part that nobody has worked on is worked on where it is dropped, and so is all that is left of a picture.
//!
//! ```
//! use pmcip_core::sampler::{Estimator, Memory, Sampler, Settings};
//!
//! let (mut floats, mut words) = ([0.0; 8 * 64], [0; 3 * 64]); // as Sampler::required(8, 8) says
//! let sampler = Sampler::new(Settings::new(8, 8), Memory { floats: &mut floats, words: &mut words })?;
//! let (mut rgb, mut scratch) = ([1.0; 3 * 64], [[0.0; 16]; 6]); // as Sampler::resolve_scratch(8, 8) says
//! let mut resolving = sampler.resolving(Estimator::Balanced, &mut scratch, &mut rgb)?;
//! while let Some(parts) = resolving.parts() {
//!     std::thread::scope(|scope| {
//!         for mut part in parts {
//!             scope.spawn(move || part.work()); // or by the threads you have
//!         }
//!     });
//! }
//! drop(resolving);
//! assert_eq!(rgb, [0.0; 3 * 64]);
//! # Ok::<(), pmcip_core::sampler::Error>(())
//! ```

use super::picture::{gather, grids, plain, share, spread};
use super::smooth::Lanes;
use super::source::{Apart, Lent, Own, Source};
use crate::sampler::film::cell::Region;
use crate::sampler::film::island::{Among, Everyone, Island};
use crate::sampler::film::{Layout, TILE};
use core::ops::Range;

/// Most bands of a picture.
const BANDS: u32 = 64;
/// Tiles of an island that is not worth more than one thread.
const FEW: usize = 32;

/// What becomes a picture.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Kind<'r> {
    /// Three planes as they are.
    Plain(&'r [&'r mut [f32]; 3]),
    /// See [`Own`].
    Own(Own<'r>),
    /// See [`Lent`].
    Lent(Lent<'r>),
    /// See [`Apart`].
    Apart(Apart<'r>),
}

/// A picture on its way: see [`resolve`](self).
#[derive(Debug)]
pub struct Resolving<'r> {
    place: Place<'r>,
    radii: [u32; 3],
    scratch: &'r mut [Lanes],
    out: &'r mut [[f32; 3]],
    next: Step,
}

/// Of what a picture is made, and where.
#[derive(Clone, Debug)]
struct Place<'r> {
    layout: Layout,
    kind: Kind<'r>,
    /// The island whose turn it is; none if all pixels belong together.
    island: Option<Island<'r>>,
    region: Region,
}

/// What is to be done next.
#[derive(Clone, Copy, Debug)]
enum Step {
    Plain,
    Gather,
    Spread,
    /// The next island, if there is one.
    Turn,
    End,
}

/// What is done to all bands of a region at the same time.
#[derive(Clone, Copy, Debug)]
enum Task {
    Plain,
    Gather,
    Spread,
}

impl<'r> Resolving<'r> {
    /// Planes as they are; `out` is as long as they are.
    pub(crate) fn plain(layout: Layout, colours: &'r [&'r mut [f32]; 3], out: &'r mut [[f32; 3]]) -> Self {
        let (kind, region) = (Kind::Plain(colours), Region::all(&layout));
        let place = Place { layout, kind, island: None, region };
        Resolving { place, radii: [0; 3], scratch: &mut [], out, next: Step::Plain }
    }

    /// A guide with the energy of a whole over neighbourhoods of `radii`, in cells; of every island by itself, if there are
    /// `labels`, and black where there is none. `scratch` is [`scratch_len`](super::scratch_len) long.
    pub(crate) fn new(
        layout: Layout,
        labels: &'r [u32],
        kind: Kind<'r>,
        radii: [u32; 3],
        scratch: &'r mut [Lanes],
        out: &'r mut [[f32; 3]],
    ) -> Self {
        let place = Place { layout, kind, island: None, region: Region::all(&layout) };
        let mut resolving = Resolving { place, radii, scratch, out, next: Step::Gather };
        if !labels.is_empty() {
            resolving.out.fill([0.0; 3]);
            resolving.turn(Island::first(&layout, labels));
        }
        resolving
    }

    /// The next parts to be worked on, by any threads in any order, or none if there are no more: the picture is there.
    ///
    /// Before that it does itself what cannot be divided, given that the parts before are done.
    pub fn parts(&mut self) -> Option<Parts<'_>> {
        let task = self.advance()?;
        let bands = self.place.region.rows.len() as u32;
        Some(self.divided(task, bands.div_ceil(BANDS)))
    }

    /// Goes on until something can be divided.
    fn advance(&mut self) -> Option<Task> {
        loop {
            let task = match self.next {
                Step::Plain => {
                    self.next = Step::End;
                    Task::Plain
                }
                Step::Gather => {
                    self.next = Step::Spread;
                    Task::Gather
                }
                Step::Spread => {
                    let size = self.place.region.grid(&self.place.layout);
                    share(size, self.radii, grids(self.scratch, size.0 * size.1));
                    self.next = Step::Turn;
                    Task::Spread
                }
                Step::Turn => {
                    let next = self.place.island.and_then(|island| island.next(&self.place.layout));
                    self.turn(next);
                    continue;
                }
                Step::End => return None,
            };
            if !self.place.is_small() {
                return Some(task);
            }
            self.alone(task);
        }
    }

    /// Turns to an island, if there is one.
    fn turn(&mut self, island: Option<(Island<'r>, Region)>) {
        self.next = Step::End;
        if let Some((island, region)) = island {
            (self.place.island, self.place.region, self.next) = (Some(island), region, Step::Gather);
        }
    }

    /// Does all of a task.
    fn alone(&mut self, task: Task) {
        let rows = self.place.region.rows.len() as u32;
        drop(self.divided(task, rows));
    }

    /// A task in bands of so many rows of tiles.
    fn divided(&mut self, task: Task, band: u32) -> Parts<'_> {
        let Place { layout, region, .. } = &self.place;
        let (columns, rows) = region.grid(layout);
        let above = (TILE * region.rows.start) as usize * layout.width() as usize;
        let work = match task {
            Task::Plain => Work::Plain { out: self.out },
            Task::Gather => {
                let (taken, excess, _) = grids(self.scratch, columns * rows);
                Work::Gather { taken, excess }
            }
            Task::Spread => {
                let (_, excess, _) = grids(self.scratch, columns * rows);
                Work::Spread { excess, out: &mut self.out[above..] }
            }
        };
        Parts { place: self.place.clone(), rows: region.rows.clone(), band, work }
    }
}

impl Drop for Resolving<'_> {
    fn drop(&mut self) {
        while let Some(task) = self.advance() {
            self.alone(task);
        }
    }
}

impl Place<'_> {
    /// Whether it is an island that is not worth more than one thread.
    fn is_small(&self) -> bool {
        self.island.is_some() && self.region.rows.len() * self.region.columns.len() <= FEW
    }
}

/// What is to be written, and what is read beside the [`Place`].
#[derive(Debug)]
enum Work<'p> {
    Plain { out: &'p mut [[f32; 3]] },
    Gather { taken: &'p mut [f32], excess: &'p mut [[f32; 3]] },
    Spread { excess: &'p [[f32; 3]], out: &'p mut [[f32; 3]] },
}

impl<'p> Work<'p> {
    /// The first band, of so many pixels and cells, is taken off.
    fn take(&mut self, pixels: usize, cells: usize) -> Work<'p> {
        match self {
            Work::Plain { out } => Work::Plain { out: take(out, pixels) },
            Work::Gather { taken, excess } => {
                Work::Gather { taken: take(taken, cells), excess: take(excess, cells) }
            }
            Work::Spread { excess, out } => Work::Spread { excess, out: take(out, pixels) },
        }
    }
}

/// Takes off the first entries, all if there are not as many.
fn take<'p, T>(from: &mut &'p mut [T], length: usize) -> &'p mut [T] {
    let all = core::mem::take(from);
    let (first, rest) = all.split_at_mut(length.min(all.len()));
    *from = rest;
    first
}

/// Parts of a [`Resolving`] that can be worked on at the same time.
#[derive(Debug)]
pub struct Parts<'p> {
    place: Place<'p>,
    /// Rows of tiles that are left, and how many of them a band has.
    rows: Range<u32>,
    band: u32,
    work: Work<'p>,
}

impl<'p> Iterator for Parts<'p> {
    type Item = Part<'p>;

    fn next(&mut self) -> Option<Part<'p>> {
        if self.rows.is_empty() {
            return None;
        }
        let Place { layout, region, .. } = &self.place;
        let band = self.rows.start..self.rows.end.min(self.rows.start + self.band);
        self.rows.start = band.end;
        let pixels = (TILE as usize * band.len()) * layout.width() as usize;
        let cells = region.cell_rows(layout, &band).len() * region.grid(layout).0;
        let work = self.work.take(pixels, cells);
        Some(Part { place: self.place.clone(), band, work: Some(work) })
    }
}

impl Drop for Parts<'_> {
    fn drop(&mut self) {
        self.for_each(drop);
    }
}

/// A part of a picture. Can be sent to another thread.
#[derive(Debug)]
pub struct Part<'p> {
    place: Place<'p>,
    /// Rows of tiles.
    band: Range<u32>,
    /// What is to be done, if it is not done.
    work: Option<Work<'p>>,
}

impl Part<'_> {
    /// Does the work; a second time there is none.
    pub fn work(&mut self) {
        match self.place.kind {
            Kind::Plain(colours) => {
                if let Some(Work::Plain { out }) = self.work.take() {
                    plain(&self.place.layout, self.band.clone(), colours, out);
                }
            }
            Kind::Own(source) => self.work_with(source),
            Kind::Lent(source) => self.work_with(source),
            Kind::Apart(source) => self.work_with(source),
        }
    }

    fn work_with(&mut self, source: impl Source) {
        match self.place.island {
            None => self.work_among(Everyone, source),
            Some(island) => self.work_among(island, source),
        }
    }

    fn work_among(&mut self, among: impl Among, source: impl Source) {
        let Place { layout, region, .. } = &self.place;
        match self.work.take() {
            Some(Work::Gather { taken, excess }) => {
                gather(layout, (among, region), &self.band, source, taken, excess);
            }
            Some(Work::Spread { excess, out }) => {
                spread(layout, (among, region), &self.band, source, excess, out);
            }
            Some(Work::Plain { .. }) | None => {}
        }
    }
}

impl Drop for Part<'_> {
    fn drop(&mut self) {
        self.work();
    }
}
