//! What can be read of a film between two iterations: pictures, and what it knows of its pixels.

use super::allocate::open::CLOSED;
use super::estimate::resolve::Kind;
use super::estimate::{self, Lanes, Own, Resolving, radii};
use super::{Error, Estimator, Sampler};
use crate::predict::Belief;

impl Sampler<'_> {
    /// Length of the scratch [`resolve`](Self::resolve) needs.
    pub fn resolve_scratch(width: u32, height: u32) -> usize {
        estimate::scratch_len(width, height)
    }

    /// Writes the picture: interleaved linear RGB, row by row.
    ///
    /// Any estimator for which [`Settings::estimator`](super::Settings::estimator) [serves](Estimator::serves) may be asked for, but for
    /// [`Estimator::Guided`], which takes a picture: see [`resolve_guided`](Self::resolve_guided).
    ///
    /// # Errors
    /// If an iteration is running, the film has not accumulated for `estimator`, or `out` or `scratch` have the wrong
    /// length.
    pub fn resolve(&self, estimator: Estimator, scratch: &mut [Lanes], out: &mut [f32]) -> Result<(), Error> {
        self.resolving(estimator, scratch, out).map(drop)
    }

    /// [`resolve`](Self::resolve) in parts that can be worked on by any threads: see [`resolve`](estimate::resolve).
    ///
    /// The picture is there when what is returned is gone.
    ///
    /// # Errors
    /// As `resolve`.
    pub fn resolving<'r>(
        &'r self,
        estimator: Estimator,
        scratch: &'r mut [Lanes],
        out: &'r mut [f32],
    ) -> Result<Resolving<'r>, Error> {
        let (width, height) = (self.state.settings.width, self.state.settings.height);
        self.at_rest()?;
        if !self.state.settings.estimator.serves(estimator) {
            return Err(Error::Estimator);
        }
        let scratch = scratch.get_mut(..Self::resolve_scratch(width, height)).ok_or(Error::Scratch)?;
        if out.len() != 3 * self.layout.pixels() {
            return Err(Error::Output);
        }
        let (out, _) = out.as_chunks_mut();
        let (layout, planes) = (self.layout, &self.planes);
        match estimator {
            Estimator::Pooled => Ok(Resolving::plain(layout, &planes.mean, out)),
            Estimator::Subframe | Estimator::Difference => Ok(Resolving::plain(layout, &planes.fair, out)),
            Estimator::Balanced => {
                let radii = radii(self.state.settings.balance_radius);
                Ok(Resolving::new(layout, planes.label, Kind::Own(Own { planes }), radii, scratch, out))
            }
            Estimator::Guided => Err(Error::Guide),
        }
    }

    /// Writes the variance of every pixel's mean luminance, as far as its own samples know it, row by row.
    ///
    /// 0 where there are fewer than two samples.
    ///
    /// # Errors
    /// If an iteration is running, or `out` is not as long as the picture has pixels.
    pub fn variance(&self, out: &mut [f32]) -> Result<(), Error> {
        self.at_rest()?;
        self.read_out(out, |i| self.planes.variance_of_mean(i))
    }

    /// Writes how many samples every pixel has, row by row.
    ///
    /// # Errors
    /// If an iteration is running, or `out` is not as long as the picture has pixels.
    pub fn count(&self, out: &mut [u32]) -> Result<(), Error> {
        self.at_rest()?;
        self.read_out(out, |i| self.planes.count[i])
    }

    /// Writes the kernel α that divided the current or last iteration, beyond what was promised, row by row; it sums to one.
    ///
    /// # Errors
    /// If `out` is not as long as the picture has pixels.
    pub fn alpha(&self, out: &mut [f32]) -> Result<(), Error> {
        let pixels = self.state.open as f64;
        let samples = self.state.mixture.samples as f64;
        let floor = f64::from(self.state.mixture.floor).min(samples / pixels);
        let rest = samples - floor * pixels;
        self.read_out(out, |i| match self.planes.target[i] {
            CLOSED => 0.0,
            target if rest > 0.0 => ((f64::from(target) - floor) / rest).max(0.0) as f32,
            _ => (1.0 / pixels) as f32,
        })
    }

    /// Writes what the frame has seen of every pixel, by the kernel's window, row by row.
    ///
    /// # Errors
    /// If an iteration is running, or `out` is not as long as the picture has pixels.
    pub fn beliefs(&self, out: &mut [Belief]) -> Result<(), Error> {
        self.at_rest()?;
        if out.len() != self.layout.pixels() {
            return Err(Error::Output);
        }
        self.state.settings.kernel().observe(&self.layout, &self.planes.seen(), out);
        Ok(())
    }

    fn read_out<T>(&self, out: &mut [T], value: impl Fn(usize) -> T) -> Result<(), Error> {
        if out.len() != self.layout.pixels() {
            return Err(Error::Output);
        }
        self.layout.for_each_run(|run, raster| {
            let length = run.len();
            run.zip(&mut out[raster..raster + length]).for_each(|(i, out)| *out = value(i));
        });
        Ok(())
    }
}
