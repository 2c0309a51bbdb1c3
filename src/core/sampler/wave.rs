//! A wavefront: the sample positions of an iteration in flat arrays, radiances handed back later in pieces.
//!
//! For renderers that want all rays at once: on a graphics card, in another process, in another language. [`Sampler::plan`]
//! writes as many samples as fit, all of an iteration if the arrays are as long as [`Sampler::begin`] was told, and says
//! which [`Piece`] of the film they are. [`Sampler::deliver`] takes the radiances of a piece. Pieces may come back in any
//! order, [split](Sampler::split) where a pixel ends if they come back in parts, and wherever one ends, the picture has the
//! same bits.
//!
//! A sample is a place and a sequence. `x` and `y` are in pixels from the upper left corner, already placed inside the pixel
//! (⌊x⌋, ⌊y⌋). `index` and `key` name the pixel's sequence of points: [`points`] writes those of any set, two dimensions
//! each. Set 0 has been used for `x` and `y`. Take set 1 for the lens, set 2 for time and wavelength, and one set for every
//! further pair of decisions along a path, always the same set for the same decision. Who has random numbers of his own
//! seeds them by hashing `key` and `index`, and loses the stratification of all but `x` and `y`.
//!
//! ```
//! use pmcip_core::sampler::wave::{Wave, points};
//! use pmcip_core::sampler::{Memory, Sampler, Settings};
//!
//! let (mut floats, mut words) = ([0.0; 8 * 64], [0; 3 * 64]); // as Sampler::required(8, 8) says
//! let mut sampler = Sampler::new(Settings::new(8, 8), Memory { floats: &mut floats, words: &mut words })?;
//! let ([mut x, mut y, mut u, mut v], [mut index, mut key]) = ([[0.0; 100]; 4], [[0; 100]; 2]);
//! sampler.begin(256)?;
//! let mut first = 0;
//! while first < 64 {
//!     let mut wave = Wave { x: &mut x, y: &mut y, index: &mut index, key: &mut key };
//!     let piece = sampler.plan(first, &mut wave)?;
//!     points(1, &index[..piece.samples], &key, &mut u, &mut v);
//!     let radiance: Vec<[f32; 3]> = (0..piece.samples).map(|i| [x[i], y[i], u[i]]).collect(); // your renderer
//!     sampler.deliver(piece, &radiance)?;
//!     first = piece.end;
//! }
//! assert_eq!(sampler.end()?.samples, 256);
//! # Ok::<(), pmcip_core::sampler::Error>(())
//! ```

use super::job::{Job, Tally};
use super::{Error, Sampler};

pub use super::batch::{Wave, points};

/// A part of the film whose samples were planned together: pixels in storage order, and how many samples they get.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Piece {
    /// The first pixel.
    pub first: usize,
    /// One after the last pixel: where the next piece begins, the number of the film's pixels if there is none.
    pub end: usize,
    /// Samples planned.
    pub samples: usize,
}

impl Sampler<'_> {
    /// Writes the samples of the running iteration from pixel `first` on (0, or the end of a [`Piece`]), as many pixels as fit
    /// whole, and says which they are. Nothing changes by it; what has been delivered has no samples any more.
    ///
    /// # Errors
    /// If no iteration is running, or not even one pixel's samples fit: [`Error::Wave`].
    pub fn plan(&mut self, first: usize, wave: &mut Wave<'_>) -> Result<Piece, Error> {
        let piece = self.piece(first, wave.len())?;
        if let Some(mut job) = self.part(piece) {
            job.plan(wave);
        }
        Ok(piece)
    }

    /// Takes the radiances of a piece: linear RGB, in the order of its samples. Returns what of it was usable.
    ///
    /// # Errors
    /// [`Error::Piece`] if the piece was delivered already or stems from another iteration, or `radiance` has not as many
    /// entries as it has samples; then nothing has changed. [`Error::NotBegun`] if no iteration is running.
    pub fn deliver(&mut self, piece: Piece, radiance: &[[f32; 3]]) -> Result<Tally, Error> {
        if radiance.len() != self.undelivered(piece)?.samples {
            return Err(Error::Piece);
        }
        Ok(self.part(piece).map_or(Tally::default(), |job| job.delivered(radiance)))
    }

    /// Parts a piece: the pixels whose samples all are among its first `samples`, and those after them. For hosts that plan an
    /// iteration at once and are handed its radiances in portions of their own: what is cut in the middle of a pixel waits for
    /// the rest of it. ([`Job::deliver`] takes portions that end anywhere.)
    ///
    /// # Errors
    /// As [`deliver`](Self::deliver).
    pub fn split(&self, piece: Piece, samples: usize) -> Result<(Piece, Piece), Error> {
        let Piece { first, end, samples: all } = self.undelivered(piece)?;
        let (mut middle, mut before) = (first, 0);
        for planned in &self.planes.planned[first..end] {
            if *planned as usize > samples - before {
                break;
            }
            (middle, before) = (middle + 1, before + *planned as usize);
        }
        let (head, tail) = ((first, middle, before), (middle, end, all - before));
        Ok([head, tail].map(|(first, end, samples)| Piece { first, end, samples }).into())
    }

    /// The piece, if it is one of the running iteration that has not been delivered.
    fn undelivered(&self, piece: Piece) -> Result<Piece, Error> {
        if self.state.running == 0 {
            return Err(Error::NotBegun);
        }
        let planned = self.planes.planned.get(piece.first..piece.end).ok_or(Error::Piece)?;
        let samples = planned.iter().map(|n| u64::from(*n)).sum::<u64>();
        if piece.samples as u64 == samples { Ok(piece) } else { Err(Error::Piece) }
    }

    /// Pixels from `first` on whose samples fit into `room`.
    fn piece(&self, first: usize, room: usize) -> Result<Piece, Error> {
        if self.state.running == 0 {
            return Err(Error::NotBegun);
        }
        let (mut samples, mut end) = (0, first);
        for planned in self.planes.planned.iter().skip(first) {
            let Some(more) = room.checked_sub(samples).filter(|room| *planned as usize <= *room) else {
                break;
            };
            (samples, end) = (room - more + *planned as usize, end + 1);
        }
        if end == first && first < self.layout.pixels() {
            return Err(Error::Wave);
        }
        Ok(Piece { first, end, samples })
    }

    /// The job of a piece; none if there is nothing to do.
    fn part(&mut self, piece: Piece) -> Option<Job<'_>> {
        if piece.samples == 0 {
            return None;
        }
        let (context, place) = (self.context(), self.layout.place(piece.first));
        let planes = self.planes.reborrow().split_at(piece.end).0.split_at(piece.first).1;
        Some(Job::new(planes, context, place, piece.samples as u64))
    }
}
