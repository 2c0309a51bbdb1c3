//! Frames that learn from the ones before: what the core's [`predict`](pmcip_core::predict) needs from frame to frame.
//!
//! A [`Predictor`] goes along with a sequence of frames, as [`render::render_next`](crate::frame::render::render_next) makes
//! them. Before a frame it carries what earlier ones have seen to where that is now; after the first iteration, of one
//! sample a pixel, this stands in for what the frame does not know yet; at the end it learns what the frame has seen.
//! Where things are now is known by [`motion`](crate::animation::motion), or found in the pictures alone: [`Startup`]. The coarse
//! picture that is searched is that first iteration: it counts, and costs nothing.
//!
//! A frame starts uniformly, as if it were the first, if less than half of its pixels have been seen before (a cut), or
//! if the frame before was [predicted badly](pmcip_core::predict::Outlook::miss): where rare bright samples make the
//! noise, where edges creep by parts of a pixel, or where the light has changed, a look at the frame itself beats any
//! memory. The first two frames always start so: there is no prediction yet that could be judged.
//!
//! It also carries the [`history`](crate::animation::history) of filtered frames, if that is asked for.
//!
//! Memory: about 160 bytes a pixel, and what the history needs.

use crate::animation::history::History;
use crate::animation::motion::{Motion, Sight};
use crate::error::Error;
use crate::frame::guide::Filtered;
use crate::frame::memory::zeros;
use crate::frame::render::Learner;
use crate::frame::settings::{Method, Settings, Startup};
use crate::scene::{LoadedScene, Pose};
use pmcip_core::predict::{Belief, Filter, Outlook, Prior, carry};
use pmcip_core::sampler::Sampler;
use rayon::ThreadPool;
use std::time::Instant;

mod pictures;

/// [`Outlook::miss`] from which on a frame is followed by a uniform start.
pub const MAX_MISS: f32 = 0.5;
/// The part of the pixels that must have been seen before.
pub const MIN_KNOWN: f32 = 0.5;

/// What goes from frame to frame.
#[derive(Clone, Debug, Default)]
pub struct Predictor {
    last: Option<Last>,
    next: Option<Next>,
    /// Where what each pixel shows was a frame ago, if that is known.
    positions: Vec<[f32; 2]>,
    history: History,
    seconds: f64,
}

/// What was predicted for a frame, row by row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Prediction {
    /// What is believed of the pixels.
    pub beliefs: Vec<Belief>,
    /// The kernel itself, in the preset `paper`; not a number where nothing was predicted.
    pub alpha: Vec<f32>,
}

/// How to find what was where a frame ago.
#[derive(Clone, Debug)]
enum View {
    Motion { pose: Pose, motion: Motion },
    Pictures,
}

/// What the last frame left.
#[derive(Clone, Debug)]
struct Last {
    width: usize,
    height: usize,
    view: View,
    beliefs: Vec<Belief>,
    alpha: Vec<f32>,
    /// Display-coded luminance, if pictures are searched.
    picture: Vec<f32>,
    prediction: Prediction,
    trusted: bool,
    outlook: Outlook,
}

/// What the frame at hand starts from.
#[derive(Clone, Debug)]
struct Next {
    view: View,
    prediction: Prediction,
    /// Whether the first iteration is a short one.
    trusted: bool,
}

impl Predictor {
    /// Forgets everything: the next frame starts uniformly.
    pub fn forget(&mut self) {
        *self = Predictor::default();
    }

    /// What was predicted for the last frame, used or not; none for a first frame.
    pub fn prediction(&self) -> Option<&Prediction> {
        let prediction = self.last.as_ref().map(|last| &last.prediction);
        prediction.filter(|prediction| !prediction.beliefs.is_empty())
    }

    /// Whether the last frame started from what was predicted.
    pub fn predicted(&self) -> bool {
        self.last.as_ref().is_some_and(|last| last.trusted)
    }

    /// How well the last frame was predicted.
    pub fn outlook(&self) -> Option<Outlook> {
        self.last.as_ref().map(|last| last.outlook)
    }

    /// Seconds that the last frame's prediction took, learning from it included.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// Looks at where things are, if that is how the frame is predicted.
    fn look(
        &self,
        scene: &LoadedScene,
        settings: &Settings,
        pool: Option<&ThreadPool>,
    ) -> Result<View, Error> {
        if settings.startup == Startup::Homography {
            return Ok(View::Pictures);
        }
        let pose = scene.pose(settings.view);
        let before = match self.last.as_ref().map(|last| &last.view) {
            Some(View::Motion { pose, .. }) => pose,
            _ => &pose,
        };
        let core = &settings.sampler;
        let motion = Motion::new(scene, &settings.view, before, (core.width, core.height), pool)?;
        Ok(View::Motion { pose, motion })
    }
}

impl Learner for Predictor {
    fn begin(
        &mut self,
        scene: &LoadedScene,
        settings: &Settings,
        pool: Option<&ThreadPool>,
    ) -> Result<(), Error> {
        let start = Instant::now();
        self.next = None;
        self.seconds = 0.0;
        let kernel = settings.startup != Startup::Uniform && settings.method != Method::Uniform;
        self.positions.clear();
        self.history.begin(settings);
        if !kernel && !settings.history {
            self.last = None;
            return Ok(());
        }
        let size = (settings.sampler.width as usize, settings.sampler.height as usize);
        let objects = scene.placements.len();
        if self.last.as_ref().is_some_and(|last| !last.fits(size, objects, settings.startup)) {
            self.last = None;
        }
        let view = self.look(scene, settings, pool)?;
        let mut next = Next { view, prediction: Prediction::default(), trusted: false };
        if let Some(last) = &self.last {
            let tame = settings.method == Method::Paper || last.outlook.miss < MAX_MISS;
            next.trusted = match (&next.view, &last.view) {
                (View::Motion { motion, .. }, View::Motion { motion: before, .. }) => {
                    self.positions = positions(motion, before);
                    next.prediction = last.carried(&self.positions, settings.method)?;
                    kernel && tame && next.prediction.known() >= MIN_KNOWN
                }
                _ => kernel && tame,
            };
        }
        self.next = Some(next);
        self.seconds = start.elapsed().as_secs_f64();
        Ok(())
    }

    fn predicts(&self) -> bool {
        self.next.as_ref().is_some_and(|next| next.trusted)
    }

    fn prior(&self, iterations: u32) -> Prior<'_> {
        match &self.next {
            Some(next) if next.trusted && next.prediction.alpha.is_empty() => {
                Prior::Beliefs(&next.prediction.beliefs)
            }
            Some(next) if next.trusted && iterations == 1 => Prior::Alpha(&next.prediction.alpha),
            _ => Prior::Beliefs(&[]),
        }
    }

    fn see(&mut self, film: &Sampler<'_>, settings: &Settings) -> Result<(), Error> {
        let start = Instant::now();
        if let (Some(next), Some(last), 1) = (&mut self.next, &self.last, film.iterations())
            && matches!(next.view, View::Pictures)
        {
            let now = pictures::coded(film)?;
            let positions = pictures::positions(&now, &last.picture, &last.alpha, last.width, last.height)?;
            next.prediction = last.carried(&positions, settings.method)?;
            self.positions = positions;
        }
        self.seconds += start.elapsed().as_secs_f64();
        Ok(())
    }

    fn blend(&mut self, filtered: &mut Filtered<'_>) -> Result<(), Error> {
        let start = Instant::now();
        self.history.blend(&self.positions, filtered)?;
        self.seconds += start.elapsed().as_secs_f64();
        Ok(())
    }

    fn end(&mut self, film: &Sampler<'_>) -> Result<(), Error> {
        let start = Instant::now();
        let Some(Next { view, prediction, trusted }) = self.next.take() else { return Ok(()) };
        let core = film.settings();
        let (width, height) = (core.width as usize, core.height as usize);
        let (mut seen, mut alpha): (Vec<Belief>, Vec<f32>) = (zeros(width * height)?, zeros(width * height)?);
        film.beliefs(&mut seen).map_err(Error::work)?;
        film.alpha(&mut alpha).map_err(Error::work)?;
        let mut beliefs = prediction.beliefs.clone();
        beliefs.resize(seen.len(), Belief::NONE);
        let outlook =
            Filter::new(core.cd_per_unit).update(width, &mut beliefs, &seen).map_err(Error::work)?;
        let pictures = matches!(view, View::Pictures);
        let picture = if pictures { pictures::coded(film)? } else { Vec::new() };
        self.last = Some(Last { width, height, view, beliefs, alpha, picture, prediction, trusted, outlook });
        self.seconds += start.elapsed().as_secs_f64();
        Ok(())
    }
}

impl Last {
    /// Whether a frame can follow that has this size, so many objects and is predicted so.
    fn fits(&self, size: (usize, usize), objects: usize, startup: Startup) -> bool {
        let view = match &self.view {
            View::Motion { pose, .. } => startup != Startup::Homography && pose.placements.len() == objects,
            View::Pictures => startup == Startup::Homography,
        };
        view && size == (self.width, self.height)
    }

    /// What is known, carried to where it is now.
    fn carried(&self, positions: &[[f32; 2]], method: Method) -> Result<Prediction, Error> {
        let (width, height) = (self.width, self.height);
        let mut beliefs = zeros(positions.len())?;
        carry(&self.beliefs, width, height, positions, Belief::NONE, &mut beliefs).map_err(Error::work)?;
        let mut alpha = Vec::new();
        if method == Method::Paper {
            alpha = zeros(positions.len())?;
            carry(&self.alpha, width, height, positions, f32::NAN, &mut alpha).map_err(Error::work)?;
        }
        Ok(Prediction { beliefs, alpha })
    }
}

impl Prediction {
    /// The part of the pixels of which something is known.
    fn known(&self) -> f32 {
        let known = self.beliefs.iter().filter(|belief| belief.usable().is_some()).count();
        known as f32 / self.beliefs.len().max(1) as f32
    }
}

/// Where what each pixel shows was a frame ago; not a number where it was hidden or outside.
fn positions(now: &Motion, before: &Motion) -> Vec<[f32; 2]> {
    let position =
        |(i, sight): (usize, &Sight)| now.source(i, before).and(sight.before).unwrap_or([f32::NAN; 2]);
    now.sights.iter().enumerate().map(position).collect()
}
