//! A viewer that shows the frame while it is rendered.

use super::common::{Failure, bad};
use pmcip::frame::settings::Settings;
use pmcip::picture::live::Live;
use pmcip_core::sampler::Sampler;
use pmcip_core::sampler::estimate::{Estimator, Lanes};
use std::path::Path;

/// The viewer, if there is one and as long as it takes what it is shown.
pub struct Viewer {
    live: Option<Live>,
    quiet: bool,
    scratch: Vec<Lanes>,
    rgb: Vec<[f32; 3]>,
}

impl Viewer {
    /// Shows the frame of the file `exr` in the viewer at `address`, if there is one.
    pub fn begin(
        address: Option<&str>,
        exr: &Path,
        settings: &Settings,
        quiet: bool,
    ) -> Result<Self, Failure> {
        let Some(address) = address else {
            return Ok(Viewer { live: None, quiet, scratch: Vec::new(), rgb: Vec::new() });
        };
        let size = (settings.sampler.width, settings.sampler.height);
        let name = exr.file_name().unwrap_or_default().to_string_lossy();
        let live = Live::begin(address, &name, size);
        let live = live.map_err(|why| bad(format!("--live {address}: {why}")))?;
        let scratch = vec![[0.0; 16]; Sampler::resolve_scratch(size.0, size.1)];
        Ok(Viewer { live: Some(live), quiet, scratch, rgb: vec![[0.0; 3]; settings.pixels() as usize] })
    }

    /// Shows the film after an iteration, now and then.
    pub fn look(&mut self, film: &Sampler<'_>) {
        if film.is_running() || !self.live.as_ref().is_some_and(Live::is_due) {
            return;
        }
        let estimator = match film.settings().estimator {
            Estimator::Guided => Estimator::Balanced,
            other => other,
        };
        if film.resolve(estimator, &mut self.scratch, self.rgb.as_flattened_mut()).is_ok() {
            let rgb = std::mem::take(&mut self.rgb);
            self.show(&rgb);
            self.rgb = rgb;
        }
    }

    /// Shows a picture. A viewer that does not take it is shown no more.
    pub fn show(&mut self, rgb: &[[f32; 3]]) {
        let Some(live) = &mut self.live else { return };
        if let Err(why) = live.show(rgb) {
            self.live = None;
            if !self.quiet {
                eprintln!("warning: the viewer is gone: {why}");
            }
        }
    }
}
