//! Pictures that guide the estimator: any picture, put on the energy of the fair samples.
//!
//! [`Sampler::resolve_guided`] takes a picture from anywhere; [`Filter`] makes one of the film itself. Where the film is
//! gone, [`Pictures`] that were read from it do.

mod among;
mod average;
mod feature;
mod filter;
pub mod history;
mod neighbours;
mod noise;
mod pictures;
mod rows;
pub use feature::Feature;
pub use filter::{Band, Filter};
pub use pictures::Pictures;

use super::estimate::resolve::Kind;
use super::estimate::{Energy, Estimator, Lanes, Lent, Resolving};
use super::{Error, Sampler};

impl Sampler<'_> {
    /// Writes `guide`, given the energy that the fair samples have in every neighbourhood: linear RGB, row by row.
    ///
    /// `guide` is any picture F of this size, rows from the top: filtered samples, another denoiser's work, a blend with
    /// earlier frames. C = F + a·G((D − F)/Gᵀa) sums to what D sums to, whatever F is (see
    /// [`estimate`](super::estimate)); with the mean of all samples as F it is [`Estimator::Balanced`], bit by bit. Where a
    /// colour of F is not finite or beyond [`MAX_RADIANCE`](crate::sampler::MAX_RADIANCE), the pixel's own mean stands in.
    /// Scratch as for [`resolve`](Self::resolve).
    ///
    /// # Errors
    /// If an iteration is running, the film has not accumulated for [`Estimator::Balanced`], or a slice has the wrong
    /// length.
    pub fn resolve_guided(
        &self,
        guide: &[[f32; 3]],
        scratch: &mut [Lanes],
        out: &mut [[f32; 3]],
    ) -> Result<(), Error> {
        self.resolving_guided(guide, scratch, out).map(drop)
    }

    /// [`resolve_guided`](Self::resolve_guided) in parts that can be worked on by any threads: see
    /// [`resolve`](crate::sampler::estimate::resolve).
    ///
    /// # Errors
    /// As `resolve_guided`.
    pub fn resolving_guided<'r>(
        &'r self,
        guide: &'r [[f32; 3]],
        scratch: &'r mut [Lanes],
        out: &'r mut [[f32; 3]],
    ) -> Result<Resolving<'r>, Error> {
        if !self.state.settings.estimator.serves(Estimator::Balanced) {
            return Err(Error::Estimator);
        }
        self.give(guide, Energy::Fair(self.state.settings.balance_radius), scratch, out)
    }

    /// Writes `guide`, given the energy that all samples together have around every pixel: as
    /// [`resolve_guided`](Self::resolve_guided), with Q instead of D, over about ten pixels.
    ///
    /// What a filter has carried over a border goes back where it was seen. Q is less noisy than D, so that this can be
    /// done over smaller neighbourhoods; the little that it lacks itself `resolve_guided` gives back afterwards.
    ///
    /// # Errors
    /// If an iteration is running, or a slice has the wrong length.
    pub fn level(
        &self,
        guide: &[[f32; 3]],
        scratch: &mut [Lanes],
        out: &mut [[f32; 3]],
    ) -> Result<(), Error> {
        self.leveling(guide, scratch, out).map(drop)
    }

    /// [`level`](Self::level) in parts that can be worked on by any threads: see
    /// [`resolve`](crate::sampler::estimate::resolve).
    ///
    /// # Errors
    /// As `level`.
    pub fn leveling<'r>(
        &'r self,
        guide: &'r [[f32; 3]],
        scratch: &'r mut [Lanes],
        out: &'r mut [[f32; 3]],
    ) -> Result<Resolving<'r>, Error> {
        self.give(guide, Energy::All, scratch, out)
    }

    fn give<'r>(
        &'r self,
        guide: &'r [[f32; 3]],
        energy: Energy,
        scratch: &'r mut [Lanes],
        out: &'r mut [[f32; 3]],
    ) -> Result<Resolving<'r>, Error> {
        self.at_rest()?;
        let needed = Self::resolve_scratch(self.state.settings.width, self.state.settings.height);
        let scratch = scratch.get_mut(..needed).ok_or(Error::Scratch)?;
        if guide.len() != self.layout.pixels() {
            return Err(Error::Guide);
        }
        if out.len() != self.layout.pixels() {
            return Err(Error::Output);
        }
        let width = self.layout.width() as usize;
        let lent = Lent { planes: &self.planes, picture: guide, width, energy };
        let (labels, kind) = (self.planes.label, Kind::Lent(lent));
        Ok(Resolving::new(self.layout, labels, kind, energy.radii(), scratch, out))
    }
}
