//! Frames that learn from the ones before: what the core's [`predict`](pmcip_core::predict) needs from frame to frame.
//!
//! A [`Predictor`] goes along with a sequence of frames, as [`render::render_next`](crate::render::render_next) makes
//! them. Before a frame it carries what earlier ones have seen to where that is now; after the first iteration, of one
//! sample a pixel, this stands in for what the frame does not know yet; at the end it learns what the frame has seen.
//!
//! A frame starts uniformly, as if it were the first, if less than half of its pixels have been seen before (a cut), or
//! if the frame before was full of [surprises](pmcip_core::predict::Outlook::surprise): where rare bright samples make
//! the noise, or the light has changed, a look at the frame itself beats any memory.
//!
//! Memory: about 100 bytes a pixel.

use crate::error::Error;
use crate::motion::Motion;
use crate::render::zeros;
use crate::scene::{LoadedScene, Pose};
use crate::settings::{Method, Settings, Startup};
use pmcip_core::predict::{Belief, Filter, Outlook, Prior, carry};
use pmcip_core::sampler::Sampler;

/// Surprise from which on a frame is followed by a uniform start.
pub const MAX_SURPRISE: f32 = 0.3;
/// The part of the pixels that must have been seen before.
pub const MIN_KNOWN: f32 = 0.5;

/// What goes from frame to frame.
#[derive(Clone, Debug, Default)]
pub struct Predictor {
    last: Option<Last>,
    next: Option<Next>,
}

/// What the last frame left.
#[derive(Clone, Debug)]
struct Last {
    size: (u32, u32),
    pose: Pose,
    motion: Motion,
    beliefs: Vec<Belief>,
    alpha: Vec<f32>,
    surprise: f32,
}

/// What the frame at hand starts from.
#[derive(Clone, Debug)]
struct Next {
    pose: Pose,
    motion: Motion,
    beliefs: Vec<Belief>,
    /// The kernel itself, in the preset `paper`.
    alpha: Vec<f32>,
    trusted: bool,
}

impl Predictor {
    /// Forgets everything: the next frame starts uniformly.
    pub fn forget(&mut self) {
        *self = Predictor::default();
    }

    /// Whether the frame begun starts from a prediction.
    pub fn predicts(&self) -> bool {
        self.next.as_ref().is_some_and(|next| next.trusted)
    }

    /// What was predicted for the frame begun, row by row; nothing is known of any pixel if nothing was.
    pub fn beliefs(&self) -> &[Belief] {
        self.next.as_ref().map_or(&[], |next| &next.beliefs)
    }

    /// Begins a frame.
    ///
    /// # Errors
    /// [`Error::Setting`] if the core refuses scene or camera, [`Error::Work`] if memory is lacking.
    pub fn begin(&mut self, scene: &LoadedScene, settings: &Settings) -> Result<(), Error> {
        self.next = None;
        if settings.startup == Startup::Uniform || settings.method == Method::Uniform {
            self.last = None;
            return Ok(());
        }
        let (width, height) = (settings.sampler.width, settings.sampler.height);
        let pose = scene.pose(settings.view);
        let fits = |last: &&Last| {
            last.size == (width, height) && last.pose.placements.len() == pose.placements.len()
        };
        let last = self.last.as_ref().filter(fits);
        let before = last.map_or(&pose, |last| &last.pose);
        let motion = Motion::new(scene, &settings.view, before, width, height)?;
        let pixels = width as usize * height as usize;
        let (mut beliefs, mut alpha) = (zeros(pixels)?, Vec::new());
        let mut trusted = false;
        if let Some(last) = last {
            let positions = positions(&motion, &last.motion);
            let size = (width as usize, height as usize);
            carry(&last.beliefs, size.0, size.1, &positions, Belief::NONE, &mut beliefs).map_err(setting)?;
            if settings.method == Method::Paper {
                alpha = zeros(pixels)?;
                carry(&last.alpha, size.0, size.1, &positions, f32::NAN, &mut alpha).map_err(setting)?;
            }
            let known = beliefs.iter().filter(|belief| belief.usable().is_some()).count();
            let enough = known as f32 >= MIN_KNOWN * pixels as f32;
            trusted = enough && (last.surprise < MAX_SURPRISE || settings.method == Method::Paper);
        }
        self.next = Some(Next { pose, motion, beliefs, alpha, trusted });
        Ok(())
    }

    /// What the next iteration of the frame begun starts from, after so many iterations.
    pub fn prior(&self, iterations: u32) -> Prior<'_> {
        match &self.next {
            Some(next) if next.trusted && next.alpha.is_empty() => Prior::Beliefs(&next.beliefs),
            Some(next) if next.trusted && iterations == 1 => Prior::Alpha(&next.alpha),
            _ => Prior::Beliefs(&[]),
        }
    }

    /// Learns from the frame begun, which has been rendered.
    ///
    /// # Errors
    /// [`Error::Work`] if memory is lacking or the film has another size.
    pub fn end(&mut self, film: &Sampler<'_>) -> Result<(), Error> {
        let Some(next) = self.next.take() else { return Ok(()) };
        let core = film.settings();
        let (mut beliefs, mut seen) = (next.beliefs, zeros(next.motion.sights.len())?);
        let mut alpha: Vec<f32> = zeros(seen.len())?;
        film.beliefs(&mut seen).map_err(work)?;
        film.alpha(&mut alpha).map_err(work)?;
        let filter = Filter::new(core.cd_per_unit);
        let outlook = filter.update(core.width as usize, &mut beliefs, &seen).map_err(work)?;
        let Outlook { surprise, .. } = outlook;
        let size = (core.width, core.height);
        self.last = Some(Last { size, pose: next.pose, motion: next.motion, beliefs, alpha, surprise });
        Ok(())
    }
}

/// Where what each pixel shows was a frame ago; not a number where it was hidden or outside.
fn positions(now: &Motion, before: &Motion) -> Vec<[f32; 2]> {
    let sights = now.sights.iter().enumerate();
    let position = |(i, sight): (usize, &crate::motion::Sight)| {
        now.source(i, before).and(sight.before).unwrap_or([f32::NAN; 2])
    };
    sights.map(position).collect()
}

fn setting(error: impl std::error::Error) -> Error {
    Error::Setting(error.to_string())
}

fn work(error: impl std::error::Error) -> Error {
    Error::Work(error.to_string())
}
