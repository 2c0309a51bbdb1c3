//! The command `render --frames`: frame after frame, kept, resumed, and made into a video.

use super::arguments::Render;
use super::common::{Failure, admit, bad, blame, eye, failed, look, note, say};
use super::kept::{Kept, attributes};
use super::load::load;
use super::print::Rendered;
use super::progress::Progress;
use super::render::{output_name, render_settings};
use super::signals::Signals;
use pmcip::animation::motion;
use pmcip::animation::sequence::{self, List, State};
use pmcip::animation::startup::Predictor;
use pmcip::animation::video::{self, Video};
use pmcip::frame::settings::{Layer, Settings};
use pmcip::picture::frame_io;
use pmcip::picture::output;
use pmcip::scene::{Animation, Pose};
use pmcip_core::sampler::Tally;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// A frame, as a line of JSON.
#[derive(Serialize)]
struct Line<'a> {
    frame: u32,
    /// Whether it was there already.
    kept: bool,
    /// Seconds that the hierarchy took, if an object has moved.
    rebuild_seconds: Option<f64>,
    files: &'a [PathBuf; 2],
    #[serde(flatten)]
    rendered: Option<Rendered<'a>>,
}

/// Times of the frames rendered.
#[derive(Default)]
struct Total {
    rendered: u32,
    kept: u32,
    seconds: f64,
    /// Samples a pixel.
    spp: f64,
    tally: Tally,
    rebuilds: u32,
    rebuild_seconds: f64,
}

/// How a frame is rendered.
struct Task {
    settings: Settings,
    /// What its file will say.
    attributes: BTreeMap<String, String>,
    /// Seconds that the hierarchy took, if an object has moved.
    rebuild_seconds: Option<f64>,
}

/// A sequence being rendered.
struct Sequence<'a> {
    arguments: &'a Render,
    animation: Animation,
    /// The files' name without a number.
    name: PathBuf,
    /// In order, at least one.
    frames: Vec<u32>,
    /// Samples a pixel that the frame before took, if frames can end early.
    spent_spp: Option<u32>,
    /// What the frames before have told.
    predictor: Predictor,
    total: Total,
    signals: Signals,
}

/// Renders the frames of `list` that are not there, and the video; or says which are not there.
pub fn render_frames(arguments: &Render, list: &List) -> Result<(), Failure> {
    let animation = load(&arguments.common, arguments.exposure)?;
    let frames = list.within(animation.frames().map(|f| (f.first, f.last))).map_err(bad)?;
    if arguments.video.is_some() && frames.windows(2).any(|pair| pair[0] + 1 < pair[1]) {
        return Err(bad("--video needs frames without gaps"));
    }
    let name = output_name(arguments, animation.scene());
    let mut sequence = Sequence {
        arguments,
        animation,
        name,
        frames,
        spent_spp: None,
        predictor: Predictor::default(),
        total: Total::default(),
        signals: Signals::catch(),
    };
    if arguments.missing {
        sequence.say_missing();
        return Ok(());
    }
    let kept = sequence.find_kept()?;
    sequence.prepare()?;
    let settings = render_settings(sequence.animation.scene(), arguments)?;
    let missing = sequence.frames.len() - kept.len();
    let progress = Progress::new(
        arguments.watch.form(arguments.json, arguments.common.quiet),
        (&settings).into(),
        missing,
    );
    for frame in sequence.frames.clone() {
        let is_there = kept.contains(&frame) && sequence.keep(frame)?;
        if !is_there {
            sequence.render(frame, &progress)?;
        }
    }
    progress.clear();
    let video = sequence.make_video();
    if !arguments.json && !arguments.common.quiet {
        say(&sequence.summary(&settings, video.is_ok()));
    }
    video.and_then(|()| admit(arguments.common.quiet, sequence.total.tally))
}

impl Sequence<'_> {
    fn first(&self) -> u32 {
        self.frames[0]
    }

    fn last(&self) -> u32 {
        self.frames[self.frames.len() - 1]
    }

    /// Lists the frames that are not there, as `--frames` takes them.
    fn say_missing(&self) {
        let there = |frame: u32| frame_io::read_exr(&self.files(frame)[0]).is_ok();
        let missing: Vec<u32> = self.frames.iter().copied().filter(|frame| !there(*frame)).collect();
        if self.arguments.json {
            say(&serde_json::json!({ "missing": missing }).to_string());
        } else {
            say(&sequence::compact(&missing));
        }
    }

    fn files(&self, frame: u32) -> [PathBuf; 2] {
        let exr = sequence::path(&self.name, frame);
        let png = exr.with_extension("png");
        [exr, png]
    }

    /// Brings the scene to a frame, and says how that is rendered.
    fn seek(&mut self, frame: u32) -> Result<Task, Failure> {
        let change = self.animation.seek(frame).map_err(bad)?;
        let scene = self.animation.scene();
        let mut settings = render_settings(scene, self.arguments)?;
        settings.sampler.frame = frame;
        if let Some(target) = &mut settings.target {
            target.expected_spp = self.spent_spp;
        }
        let attributes = attributes(scene, &settings);
        Ok(Task { settings, attributes, rebuild_seconds: change.geometry })
    }

    /// The frames that are complete; one that was made otherwise is an error unless it may be overwritten.
    fn find_kept(&mut self) -> Result<BTreeSet<u32>, Failure> {
        let mut kept = BTreeSet::new();
        for frame in self.frames.clone() {
            let [exr, _] = self.files(frame);
            if !exr.exists() {
                continue;
            }
            match sequence::state(&exr, &self.seek(frame)?.attributes) {
                State::Complete => _ = kept.insert(frame),
                State::Other(why) if !self.arguments.overwrite => {
                    let remedy = "give another name with -o, or --overwrite";
                    return Err(bad(format!("{} is another frame: {why}; {remedy}", exr.display())));
                }
                State::Damaged(why) => self.note_damaged(frame, &why),
                State::Other(_) | State::Missing => {}
            }
        }
        Ok(kept)
    }

    /// Makes sure that files can be written and that the camera sees something, before hours of work depend on it.
    fn prepare(&mut self) -> Result<(), Failure> {
        let first = self.first();
        let video = self.arguments.video.as_slice();
        self.files(first).iter().chain(video).try_for_each(|path| output::check(path)).map_err(bad)?;
        if !video.is_empty() && !video::available() && !self.arguments.common.quiet {
            eprintln!("warning: {}; the frames are rendered all the same", video::MISSING);
        }
        let settings = self.seek(first)?.settings;
        look(self.animation.scene(), &settings, &self.arguments.common)
    }

    /// Brightness of the PNGs in stops.
    fn exposure(&self) -> f32 {
        self.arguments.exposure.unwrap_or(self.animation.scene().exposure)
    }

    fn note_damaged(&self, frame: u32, why: &str) {
        let file = &self.files(frame)[0];
        note(&self.arguments.common, format!("{} is damaged ({why}): it is rendered again", file.display()));
    }

    /// Passes over a frame that is complete; its PNG follows the exposure asked for now. What its samples were like is
    /// not on disk: the next frame starts uniformly. False if it turns out to be damaged.
    fn keep(&mut self, frame: u32) -> Result<bool, Failure> {
        self.predictor.forget();
        let files = self.files(frame);
        let picture = match frame_io::read_exr(&files[0]) {
            Ok(picture) => picture,
            Err(error) => {
                self.note_damaged(frame, &error.to_string());
                return Ok(false);
            }
        };
        frame_io::write_png(&files[1], &picture, self.exposure()).map_err(failed)?;
        let spent = picture.attributes.get("spent_spp").and_then(|spp| spp.parse::<f64>().ok());
        self.spent_spp = spent.map(|spp| spp as u32);
        self.total.kept += 1;
        self.print(&Line { frame, kept: true, rebuild_seconds: None, files: &files, rendered: None });
        Ok(true)
    }

    fn render(&mut self, frame: u32, progress: &Progress) -> Result<(), Failure> {
        let Task { settings, attributes, rebuild_seconds } = self.seek(frame)?;
        let scene = self.animation.scene();
        scene.require_light().map_err(bad)?;
        let files = self.files(frame);
        let mut kept = Kept::new(&files[0], attributes, self.arguments);
        progress.begin(Some(frame));
        let mut done = kept.render(scene, &settings, &mut self.predictor, &self.signals, progress)?;
        progress.end();
        if settings.layers.contains(Layer::Motion) {
            done.layers.extend(self.motion(&settings)?);
        }
        let mut picture = done.picture(&settings, scene);
        picture.attributes.extend(kept.attributes.clone());
        // The PNG first: where the EXR is, all of the frame is.
        frame_io::write_png(&files[1], &picture, self.exposure()).map_err(failed)?;
        frame_io::write_exr(&files[0], &picture).map_err(failed)?;
        kept.finish(&done)?;
        let rendered = Some(Rendered::new(scene, &settings, &done, &files));
        self.print(&Line { frame, kept: false, rebuild_seconds, files: &files, rendered });
        self.spent_spp = done.estimated_err.map(|_| done.spp() as u32);
        self.total.rendered += 1;
        self.total.tally.samples += done.tally.samples;
        self.total.tally.rejected += done.tally.rejected;
        self.total.spp += done.spp();
        self.total.seconds += done.seconds;
        self.total.rebuilds += u32::from(rebuild_seconds.is_some());
        self.total.rebuild_seconds += rebuild_seconds.unwrap_or(0.0);
        Ok(())
    }

    /// How what the frame shows has moved since the one before, whether that was rendered or not.
    fn motion(&self, settings: &Settings) -> Result<BTreeMap<String, Vec<f32>>, Failure> {
        let before = self.animation.before().map_err(bad)?;
        let scene = self.animation.scene();
        let eye = eye(&self.arguments.common);
        let before = before.map(|pose| Pose { view: eye.applied(&pose.view, scene.origin), ..pose });
        motion::layer(scene, settings, before.as_ref(), self.arguments.common.threads).map_err(blame)
    }

    fn print(&self, line: &Line) {
        if self.arguments.json {
            // Plain data with string keys: it cannot fail to become JSON.
            say(&serde_json::to_string(line).unwrap_or_default());
        }
    }

    fn make_video(&self) -> Result<(), Failure> {
        let Some(file) = self.arguments.video.clone() else { return Ok(()) };
        let of_scene = self.animation.frames().map_or(24.0, |frames| frames.fps);
        let video = Video {
            file,
            pictures: self.name.with_extension("png"),
            frames: self.first()..=self.last(),
            fps: self.arguments.fps.unwrap_or(of_scene),
        };
        video.make().map_err(|error| failed(format!("{error}; the frames are complete")))
    }

    fn summary(&self, settings: &Settings, has_video: bool) -> String {
        let Total { rendered, kept, seconds, spp, rebuilds, rebuild_seconds, .. } = self.total;
        let scene = self.animation.scene();
        let core = &settings.sampler;
        let (first, last) = (self.first(), self.last());
        let frames = match self.frames.len() as u32 - 1 == last - first {
            true => format!("{first} to {last}"),
            false => sequence::compact(&self.frames),
        };
        let mut text = format!(
            "{}: frames {frames}, {}×{} pixels, {} samples per pixel, sampler {}, seed {}\n",
            scene.name, core.width, core.height, settings.spp, settings.method, core.seed
        );
        let each = seconds / f64::from(rendered.max(1));
        text +=
            &format!("{rendered} rendered in {seconds:.1} s, {each:.2} s each; {kept} were there already\n");
        if let Some(target) = settings.target.filter(|_| rendered > 0) {
            let spp = spp / f64::from(rendered);
            text +=
                &format!("{spp:.1} samples per pixel on average for an estimated Err below {}\n", target.err);
        }
        if rebuilds > 0 {
            let each = 1e3 * rebuild_seconds / f64::from(rebuilds);
            text += &format!("the hierarchy was built {rebuilds} times, {each:.1} ms each\n");
        }
        let [a, b] = [self.files(first), self.files(last)].map(|[exr, _]| exr.display().to_string());
        text += &format!("wrote {a} to {b}, each with a PNG");
        if let Some(video) = self.arguments.video.as_ref().filter(|_| has_video) {
            text += &format!(", and {}", video.display());
        }
        text + "\n"
    }
}
