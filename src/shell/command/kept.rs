//! A frame that leaves what there is of it on disk, and goes on from that.

use super::arguments::Render;
use super::common::{Failure, bad, blame, failed};
use super::signals::Signals;
use super::viewer::Viewer;
use indicatif::ProgressBar;
use pmcip::compare::reference::fingerprint;
use pmcip::error::Error;
use pmcip::frame::attributes;
use pmcip::frame::checkpoint::{self, Keeper};
use pmcip::frame::render::{self, Frame, Learner, Run};
use pmcip::frame::settings::Settings;
use pmcip::scene::LoadedScene;
use pmcip_core::sampler::Sampler;
use pmcip_core::sampler::saved::Saved;
use std::collections::BTreeMap;
use std::path::Path;

/// What the file of a frame says: its settings, and the hash of the scene as it is in this frame.
pub fn attributes(scene: &LoadedScene, settings: &Settings) -> BTreeMap<String, String> {
    let mut attributes = attributes::attributes(scene, settings);
    attributes.insert("scene_hash".into(), fingerprint(scene, settings));
    attributes
}

/// A frame to render.
pub struct Kept<'a> {
    /// Its file.
    pub exr: &'a Path,
    /// What that will say.
    pub attributes: BTreeMap<String, String>,
    /// How.
    pub arguments: &'a Render,
}

impl Kept<'_> {
    /// The frame is complete: keeps its film if that is asked for, and else removes what there was of it.
    pub fn finish(&self, frame: &Frame) -> Result<(), Failure> {
        match &frame.film {
            Some(film) => {
                checkpoint::write(&checkpoint::path(self.exr), &self.attributes, film).map_err(failed)
            }
            None => {
                checkpoint::remove(self.exr);
                Ok(())
            }
        }
    }

    /// Renders the frame, from where it was left if that is asked for; what there is of it stays on disk if that is, or if
    /// somebody interrupts.
    pub fn render(
        &self,
        scene: &LoadedScene,
        settings: &Settings,
        learner: &mut dyn Learner,
        signals: &Signals,
        bar: &ProgressBar,
    ) -> Result<Frame, Failure> {
        let film = match self.arguments.resume {
            true => checkpoint::read(&checkpoint::path(self.exr), &self.attributes).map_err(blame)?,
            false => None,
        };
        let saved = film.as_deref().map(Saved::new).transpose();
        let saved = saved.map_err(|why| bad(Error::read(&checkpoint::path(self.exr), why)))?;
        let can_be_kept = settings.stands_alone();
        let mut keeper = Keeper::new(self.exr, &self.attributes, self.arguments.checkpoint);
        let Render { live, common, .. } = self.arguments;
        let mut viewer = Viewer::begin(live.as_deref(), self.exr, settings, common.quiet)?;
        let progress = |samples| bar.inc(samples);
        let mut go_on = |film: &Sampler<'_>| {
            if can_be_kept {
                keeper.look(film)?;
            }
            viewer.look(film);
            Ok(true)
        };
        let run = Run {
            threads: common.threads,
            interrupted: signals.caught(),
            with_film: self.arguments.film,
            saved,
            ..Run::watched(&progress, learner)
        };
        match render::render_while(scene, settings, run, &mut go_on) {
            Err(Error::Interrupted) if can_be_kept => {
                bar.finish_and_clear();
                let file = keeper.path().display();
                Err(signals.end(format!("interrupted: {file} has what there is, --resume goes on from it")))
            }
            Err(Error::Interrupted) => Err(signals.end("interrupted".into())),
            done => {
                let frame = done.map_err(blame)?;
                viewer.show(&frame.rgb);
                Ok(frame)
            }
        }
    }
}
