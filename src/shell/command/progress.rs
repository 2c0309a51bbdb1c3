//! How far the work is: a bar on a terminal, and lines for programs that watch.

use super::values::Form;
use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};
use pmcip::frame::schedule::Target;
use pmcip::frame::settings::Settings;
use serde::Serialize;
use std::io::Write as _;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Shortest time between two lines, but for those at a frame's begin and end.
const LINES: Duration = Duration::from_secs(1);
/// Shortest time between two states of the bar.
const BARS: Duration = Duration::from_millis(100);
/// Steps of the bar.
const STEPS: f64 = 1e4;

fn on_terminal(length: u64, quiet: bool) -> ProgressBar {
    match quiet {
        true => ProgressBar::hidden(),
        false => ProgressBar::with_draw_target(Some(length), ProgressDrawTarget::stderr()),
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

/// What is to be done for a frame, or whatever is the whole of the work.
#[derive(Clone, Copy, Debug, Default)]
pub struct Work {
    /// Pixels, or texels in use.
    pub pixels: u64,
    /// Samples of each.
    pub spp: u64,
    /// Most seconds, if there is a limit.
    pub seconds: Option<f32>,
    /// Err to come to, if there is one.
    pub target: Option<Target>,
}

impl From<&Settings> for Work {
    fn from(settings: &Settings) -> Work {
        let Settings { spp, seconds, target, .. } = *settings;
        Work { pixels: settings.pixels(), spp: spp.into(), seconds, target }
    }
}

/// How far the work on one or more frames is.
///
/// A frame is done as far as its samples are, its time is over, or Err has come near to its target, whichever is most: Err
/// falls as 1/samples. What is left takes as long for each part as what has been done since the first sample, without what was
/// there already.
pub struct Progress {
    form: Option<Form>,
    bar: ProgressBar,
    frames: usize,
    /// On each of them.
    work: Work,
    begun: Instant,
    state: Mutex<State>,
}

/// Where the render is now.
#[derive(Default)]
struct State {
    frame: Option<u32>,
    /// Frames that are done.
    finished: usize,
    /// Part of this frame that is done; it never falls.
    part: f64,
    /// Samples of this frame.
    samples: u64,
    /// When its samples began, once they have.
    sampling: Option<Instant>,
    estimated_err: Option<f64>,
    /// Parts of frames that were there already.
    given: f64,
    /// When the first sample of all frames was drawn.
    first: Option<Instant>,
    said: Option<Instant>,
}

/// A line for programs.
#[derive(Serialize)]
struct Line {
    event: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    frame: Option<u32>,
    /// Part of the whole render, 0 to 1.
    done: f64,
    /// Of this frame.
    samples: u64,
    /// Of this frame, a pixel.
    spp: f64,
    /// Since the render began.
    seconds: f64,
    /// None as long as nobody can know.
    seconds_left: Option<f64>,
    /// Of this frame; none before there is one.
    estimated_err: Option<f64>,
}

impl Progress {
    /// Of `frames` frames, told in a form; not at all in none.
    pub fn new(form: Option<Form>, work: Work, frames: usize) -> Progress {
        let bar = on_terminal(STEPS as u64, form != Some(Form::Bar));
        let bar = bar.with_style(style("{bar:40} {percent:>3} %  {msg}"));
        let form = form.filter(|form| *form != Form::Bar || !bar.is_hidden());
        Progress { form, bar, frames: frames.max(1), work, begun: Instant::now(), state: Mutex::default() }
    }

    /// Whether somebody is told.
    pub fn is_told(&self) -> bool {
        self.form.is_some()
    }

    /// A frame begins, with this number if there are others.
    pub fn begin(&self, frame: Option<u32>) {
        let State { finished, given, first, said, .. } = *self.state();
        *self.state() = State { frame, finished, given, first, said, ..State::default() };
    }

    /// There are so many samples more. The first time in a frame they are those that were there already, or none.
    pub fn add(&self, samples: u64) {
        if !self.is_told() {
            return;
        }
        let mut state = self.state();
        state.samples += samples;
        let is_first = state.sampling.is_none();
        let sampling = *state.sampling.get_or_insert_with(Instant::now);
        state.part = self.part(&state, sampling).clamp(state.part, 1.0);
        if is_first {
            state.given += state.part;
            state.first.get_or_insert(sampling);
        }
        let pause = if self.form == Some(Form::Bar) { BARS } else { LINES };
        if is_first || state.said.is_none_or(|said| said.elapsed() >= pause) {
            self.say(&mut state);
        }
    }

    /// There are so many samples more, which were there already; not the first of a frame.
    pub fn skip(&self, samples: u64) {
        self.state().given += samples as f64 / (self.work.pixels as f64 * self.work.spp as f64);
        self.add(samples);
    }

    /// An estimate of the frame's Err.
    pub fn estimate(&self, err: f64) {
        self.state().estimated_err = Some(err);
    }

    /// The frame has been rendered.
    pub fn end(&self) {
        let mut state = self.state();
        state.part = 1.0;
        self.say(&mut state);
        (state.finished, state.part) = (state.finished + 1, 0.0);
    }

    /// Removes the bar.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The part of a frame that is done.
    fn part(&self, state: &State, sampling: Instant) -> f64 {
        let Work { pixels, spp, seconds, target } = &self.work;
        let by_samples = state.samples as f64 / (*pixels as f64 * *spp as f64);
        let by_time = seconds.map_or(0.0, |limit| sampling.elapsed().as_secs_f64() / f64::from(limit));
        let by_err = target.zip(state.estimated_err).map_or(0.0, |(target, err)| f64::from(target.err) / err);
        by_samples.max(by_time).max(by_err)
    }

    fn say(&self, state: &mut State) {
        state.said = Some(Instant::now());
        let line = self.line(state);
        match self.form {
            None => {}
            Some(Form::Bar) => {
                self.bar.set_position((line.done * STEPS) as u64);
                self.bar.set_message(self.words(&line, state.finished + 1));
            }
            Some(Form::Json) => {
                // Plain data with string keys: it cannot fail to become JSON. If nobody reads it, that is no reason to end.
                let line = serde_json::to_string(&line).unwrap_or_default();
                let _ = writeln!(std::io::stderr(), "{line}");
            }
            Some(Form::Openjd) => {
                let (percent, words) = (100.0 * line.done, self.words(&line, state.finished + 1));
                // A reader that has closed the pipe has read enough.
                let _ = writeln!(std::io::stdout(), "openjd_progress: {percent:.1}\nopenjd_status: {words}");
            }
        }
    }

    fn line(&self, state: &State) -> Line {
        let frames = self.frames as f64;
        let done = ((state.finished as f64 + state.part) / frames).min(1.0);
        let rendered = done - state.given / frames;
        let seconds = self.begun.elapsed().as_secs_f64();
        // After less than a second nobody knows.
        let since = state.first.map_or(0.0, |first| first.elapsed().as_secs_f64());
        let left = (rendered > 0.0 && since >= 1.0).then(|| since * (1.0 - done) / rendered);
        Line {
            event: "progress",
            frame: state.frame,
            done: (1e4 * done).floor() / 1e4,
            samples: state.samples,
            spp: (1e4 * state.samples as f64 / self.work.pixels as f64).round() / 1e4,
            seconds: (1e3 * seconds).round() / 1e3,
            seconds_left: left.or((done >= 1.0).then_some(0.0)).map(|left| left.round()),
            estimated_err: state.estimated_err,
        }
    }

    /// A line for people, in the frame that is the `number`th.
    fn words(&self, line: &Line, number: usize) -> String {
        let frame = line.frame.map(|frame| format!("frame {frame} ({number} of {})", self.frames));
        let spp = format!("{:.1} spp", line.spp);
        let err = line.estimated_err.map(|err| format!("estimated Err {err:.4}"));
        let left = line.seconds_left.and_then(|left| Duration::try_from_secs_f64(left).ok());
        let left = left.map(|left| format!("{:#} left", HumanDuration(left)));
        frame.into_iter().chain([spp]).chain(err).chain(left).collect::<Vec<_>>().join(", ")
    }
}
