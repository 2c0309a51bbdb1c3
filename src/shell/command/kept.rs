//! A frame that leaves what there is of it on disk, and goes on from that.

use super::arguments::Render;
use super::common::{Failure, bad, blame, failed, note};
use super::progress::Progress;
use super::signals::Signals;
use super::viewer::Viewer;
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
    exr: &'a Path,
    /// What that will say.
    pub attributes: BTreeMap<String, String>,
    /// How.
    arguments: &'a Render,
    /// Whether there is a checkpoint on disk that has less than the frame.
    has_checkpoint: bool,
}

impl<'a> Kept<'a> {
    /// The frame of the file `exr`.
    pub fn new(exr: &'a Path, attributes: BTreeMap<String, String>, arguments: &'a Render) -> Self {
        Kept { exr, attributes, arguments, has_checkpoint: false }
    }

    /// The frame is on disk: writes its film if that is asked for, and else removes the checkpoint. A film that was not made on
    /// the way to this frame stays.
    pub fn finish(&self, frame: &Frame) -> Result<(), Failure> {
        let file = checkpoint::path(self.exr);
        match &frame.film {
            Some(film) => checkpoint::write(&file, &self.attributes, film).map_err(failed),
            None if self.has_checkpoint => {
                checkpoint::remove(self.exr);
                Ok(())
            }
            None => Ok(()),
        }
    }

    /// The film to go on from, if that is asked for. One that is in the way of checkpoints is an error.
    fn film(&self) -> Result<Option<Vec<u8>>, Failure> {
        let file = checkpoint::path(self.exr);
        match (self.arguments.resume, self.arguments.checkpoint) {
            (true, _) => checkpoint::read(&file, &self.attributes).map_err(blame),
            (false, Some(_)) if file.exists() => {
                let remedy = "--resume goes on from it, or remove it to begin anew";
                Err(bad(format!("{} is there already: {remedy}", file.display())))
            }
            _ => Ok(None),
        }
    }

    /// Renders the frame, from where it was left if that is asked for; what there is of it stays on disk if that is, or if
    /// somebody interrupts and there is no other film in its place.
    pub fn render(
        &mut self,
        scene: &LoadedScene,
        settings: &Settings,
        learner: &mut dyn Learner,
        signals: &Signals,
        progress: &Progress,
    ) -> Result<Frame, Failure> {
        let (file, film) = (checkpoint::path(self.exr), self.film()?);
        let saved = film.as_deref().map(Saved::new).transpose();
        let saved = saved.map_err(|why| bad(Error::read(&file, why)))?;
        let before = saved.map(|saved| saved.state().samples());
        let can_be_kept = settings.stands_alone() && (saved.is_some() || !file.exists());
        let mut keeper = Keeper::new(self.exr, &self.attributes, self.arguments.checkpoint);
        let Render { live, common, .. } = self.arguments;
        let mut viewer = Viewer::begin(live.as_deref(), self.exr, settings, common.quiet)?;
        let add = |samples| progress.add(samples);
        let mut estimate = |err| progress.estimate(err);
        let mut is_told = false;
        let mut go_on = |film: &Sampler<'_>| {
            if can_be_kept && let Err(why) = keeper.look(film) {
                // Hours of work do not end with a checkpoint that finds no room: the next one may.
                if film.is_running() {
                    return Err(why);
                }
                if !std::mem::replace(&mut is_told, true) {
                    note(common, format!("warning: no checkpoint: {why}"));
                }
            }
            viewer.look(film);
            Ok(true)
        };
        let run = Run {
            threads: common.threads,
            interrupted: signals.caught(),
            with_film: self.arguments.film,
            saved,
            estimates: if progress.is_told() { Some(&mut estimate) } else { None },
            ..Run::watched(&add, learner)
        };
        match render::render_while(scene, settings, run, &mut go_on) {
            Err(Error::Interrupted) if can_be_kept => {
                progress.clear();
                let file = keeper.path().display();
                Err(signals.end(format!("interrupted: {file} has what there is, --resume goes on from it")))
            }
            Err(Error::Interrupted) => Err(signals.end("interrupted".into())),
            done => {
                let frame = done.map_err(blame)?;
                viewer.show(&frame.rgb);
                let samples = frame.tally.samples + frame.tally.rejected;
                self.has_checkpoint = keeper.has_written() || before.is_some_and(|before| before < samples);
                Ok(frame)
            }
        }
    }
}
