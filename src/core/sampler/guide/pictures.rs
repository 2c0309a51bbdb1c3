//! Energy for a picture when the film is gone: everything lent row by row.

use crate::sampler::Error;
use crate::sampler::estimate::resolve::Kind;
use crate::sampler::estimate::{self, Apart, Lanes, MAX_RADIUS, Resolving, radii};
use crate::sampler::film::Layout;

/// A guide and what a film has left, all of one size: linear RGB, row by row from the top.
///
/// ```
/// use pmcip_core::sampler::Sampler;
/// use pmcip_core::sampler::guide::Pictures;
///
/// let (guide, unbiased) = ([[0.5; 3]; 6], [[1.0, 2.0, 3.0]; 6]);
/// let pictures =
///     Pictures { width: 3, height: 2, balance_radius: 96, guide: &guide, unbiased: &unbiased, mean: &unbiased };
/// let (mut scratch, mut out) = ([[0.0; 16]; 6], [[0.0; 3]; 6]); // as Sampler::resolve_scratch(3, 2) says
/// pictures.restore(&mut scratch, &mut out)?;
/// assert!((out[0][1] - 2.0).abs() < 1e-5);
/// # Ok::<(), pmcip_core::sampler::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Pictures<'a> {
    /// Columns, 1 to 16384.
    pub width: u32,
    /// Rows, 1 to 16384.
    pub height: u32,
    /// [`Settings::balance_radius`](crate::sampler::Settings::balance_radius) of the film.
    pub balance_radius: u32,
    /// F, a picture from anywhere.
    pub guide: &'a [[f32; 3]],
    /// D, the film by [`Estimator::Difference`](crate::sampler::estimate::Estimator::Difference). Finite.
    pub unbiased: &'a [[f32; 3]],
    /// Q, the mean of all samples, or nearly: it stands in where a guide is no colour, and says where a black guide has
    /// changed anything. Finite.
    pub mean: &'a [[f32; 3]],
}

impl Pictures<'_> {
    /// Writes the guide with the energy that `unbiased` has in every neighbourhood, row by row: what
    /// [`Sampler::resolve_guided`](crate::sampler::Sampler::resolve_guided) writes, bit by bit. Scratch as for
    /// [`Sampler::resolve`](crate::sampler::Sampler::resolve).
    ///
    /// # Errors
    /// If size or radius are out of range, or a slice has the wrong length.
    pub fn restore(&self, scratch: &mut [Lanes], out: &mut [[f32; 3]]) -> Result<(), Error> {
        let layout = Layout::new(self.width, self.height).ok_or(Error::Size)?;
        if self.balance_radius > MAX_RADIUS {
            return Err(Error::BalanceRadius);
        }
        let pictures = [self.guide, self.unbiased, self.mean];
        if pictures.iter().any(|picture| picture.len() != layout.pixels()) {
            return Err(Error::Guide);
        }
        if out.len() != layout.pixels() {
            return Err(Error::Output);
        }
        let needed = estimate::scratch_len(self.width, self.height);
        let scratch = scratch.get_mut(..needed).ok_or(Error::Scratch)?;
        let kind = Kind::Apart(Apart { pictures, width: self.width as usize });
        drop(Resolving::new(layout, &[], kind, radii(self.balance_radius), scratch, out));
        Ok(())
    }
}
