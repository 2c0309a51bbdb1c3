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

use super::estimate::{self, Energy, Estimator, Lanes};
use super::{Error, Sampler};

impl Sampler<'_> {
    /// Writes `guide`, given the energy that the fair samples have in every neighbourhood: linear RGB, row by row.
    ///
    /// `guide` is any picture F of this size, rows from the top: filtered samples, another denoiser's work, a blend with
    /// earlier frames. C = F + a·G((D − F)/Gᵀa) sums to what D sums to, whatever F is (see [`estimate`]); with the mean of
    /// all samples as F it is [`Estimator::Balanced`], bit by bit. Where a colour of F is not finite or beyond
    /// [`MAX_RADIANCE`](crate::sampler::MAX_RADIANCE), the pixel's own mean stands in. Scratch as for
    /// [`resolve`](Self::resolve).
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
        self.give(guide, Energy::All, scratch, out)
    }

    fn give(
        &self,
        guide: &[[f32; 3]],
        energy: Energy,
        scratch: &mut [Lanes],
        out: &mut [[f32; 3]],
    ) -> Result<(), Error> {
        self.at_rest()?;
        let needed = Self::resolve_scratch(self.state.settings.width, self.state.settings.height);
        let scratch = scratch.get_mut(..needed).ok_or(Error::Scratch)?;
        if guide.len() != self.layout.pixels() {
            return Err(Error::Guide);
        }
        if out.len() != self.layout.pixels() {
            return Err(Error::Output);
        }
        estimate::lent(&self.layout, &self.planes, guide, energy, scratch, out);
        Ok(())
    }
}
