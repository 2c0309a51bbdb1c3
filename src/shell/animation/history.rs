//! Filtered frames blended with those before them: what the core's [`history`](pmcip_core::sampler::guide::history) needs
//! from frame to frame.
//!
//! Memory: 108 bytes a pixel while a frame is blended, 44 from frame to frame.

use crate::error::Error;
use crate::frame::guide::Filtered;
use crate::frame::memory::zeros;
use crate::frame::settings::Settings;
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::guide::history::{Blend, Past, carry};

/// What filtered frames have shown.
#[derive(Clone, Debug, Default)]
pub struct History {
    asked_for: bool,
    size: (u32, u32),
    past: Vec<Past>,
}

impl History {
    /// A frame begins; one of another size, or without history or filter, forgets what was before.
    pub fn begin(&mut self, settings: &Settings) {
        let size = (settings.sampler.width, settings.sampler.height);
        let asked_for = settings.history && settings.sampler.estimator == Estimator::Guided;
        if !asked_for || size != self.size {
            self.past.clear();
        }
        (self.asked_for, self.size) = (asked_for, size);
    }

    /// Blends a filtered frame with what is known from before at `positions`, and keeps it for the next one. Nothing is
    /// known if there are no positions.
    ///
    /// # Errors
    /// [`Error::Work`] if memory is lacking.
    pub fn blend(&mut self, positions: &[[f32; 2]], filtered: &mut Filtered<'_>) -> Result<(), Error> {
        if !self.asked_for {
            return Ok(());
        }
        let width = filtered.size.0 as usize;
        let pixels = filtered.rgb.len();
        let mut carried = zeros(pixels)?;
        carried.fill(Past::NONE);
        if self.past.len() == pixels && positions.len() == pixels {
            carry(&self.past, width, positions, filtered.features, &[], &mut carried).map_err(Error::work)?;
        }
        if self.past.len() != pixels {
            self.past = zeros(pixels)?;
        }
        let (mut work, mut out) = (zeros(pixels)?, zeros(pixels)?);
        let blend = Blend {
            width,
            filtered: &filtered.rgb,
            variance: &filtered.variance,
            features: filtered.features,
            carried: &carried,
            labels: &[],
        };
        blend.run(&mut work, &mut self.past, &mut out).map_err(Error::work)?;
        filtered.rgb = out;
        Ok(())
    }
}
