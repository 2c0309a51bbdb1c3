//! What the commands share: failures, settings, what they say.

use super::arguments::Common;
use super::print::Rendered;
use super::progress::Progress;
use super::values::Form;
use pmcip::error::Error;
use pmcip::frame::probe;
use pmcip::frame::render::{self, Frame, Learner, Run};
use pmcip::frame::settings::{Method, Settings};
use pmcip::scene::{Eye, LoadedScene};
use pmcip_core::sampler::Tally;
use std::io::Write;

/// Why a command ended without success.
pub struct Failure {
    /// 2 for bad input, 1 for failed work, 3 for a picture of which a part is missing.
    pub code: u8,
    /// One line.
    pub message: String,
}

/// Blames the input.
pub fn bad(reason: impl ToString) -> Failure {
    Failure { code: 2, message: reason.to_string() }
}

/// Blames the work.
pub fn failed(reason: impl ToString) -> Failure {
    Failure { code: 1, message: reason.to_string() }
}

/// Part of the samples that may be rejected before a command counts as failed.
const REJECTABLE: f64 = 0.01;

/// What the command says of the camera.
pub fn eye(common: &Common) -> Eye {
    Eye {
        from: common.look_from,
        at: common.look_at,
        up: common.up,
        fov: common.fov,
        aperture: common.aperture,
        focus: common.focus,
    }
}

/// Says how many samples of a picture were no numbers.
///
/// # Errors
/// If they are more than a hundredth of all.
pub fn admit(quiet: bool, tally: Tally) -> Result<(), Failure> {
    let all = tally.samples + tally.rejected;
    let part = tally.rejected as f64 / all.max(1) as f64;
    let message = || {
        let why = "were infinite, too large or no numbers, and are left out of the picture";
        format!("{} of {all} samples ({:.2} %) {why}", tally.rejected, 100.0 * part)
    };
    match tally.rejected {
        0 => Ok(()),
        _ if part > REJECTABLE => Err(Failure { code: 3, message: message() }),
        _ => {
            if !quiet {
                eprintln!("warning: {}", message());
            }
            Ok(())
        }
    }
}

/// The settings of the command and the scene, with the method's defaults for the rest.
pub fn settings(
    scene: &LoadedScene,
    common: &Common,
    method: Method,
    spp: Option<u32>,
) -> Result<Settings, Failure> {
    let integrator = common.integrator().map_err(bad)?;
    Ok(Settings { integrator, ..path_settings(scene, common, method, spp) })
}

/// The settings of the command and the scene but for the integrator, which is asked for apart.
pub fn path_settings(scene: &LoadedScene, common: &Common, method: Method, spp: Option<u32>) -> Settings {
    let mut settings = Settings::new(scene, method, spp, common.size);
    settings.max_depth = common.max_depth.unwrap_or(settings.max_depth);
    settings.sampler.seed = common.seed;
    let eye = eye(common);
    settings.view = eye.applied(&scene.view, scene.origin);
    let closing = scene.closing_view.map(|closing| eye.applied(&closing, scene.origin));
    settings.closing_view = closing.filter(|closing| *closing != settings.view);
    settings
}

/// Renders a frame that nothing can interrupt.
pub fn work(
    scene: &LoadedScene,
    settings: &Settings,
    common: &Common,
    form: Option<Form>,
) -> Result<Frame, Failure> {
    look(scene, settings, common)?;
    let progress = Progress::new(form, settings.into(), 1);
    let learner: &mut dyn Learner = &mut ();
    let (add, mut estimate) = (|samples| progress.add(samples), |err| progress.estimate(err));
    progress.begin(None);
    let run = Run {
        threads: common.threads,
        estimates: if progress.is_told() { Some(&mut estimate) } else { None },
        ..Run::watched(&add, learner)
    };
    let frame = render::render_while(scene, settings, run, &mut |_| Ok(true));
    if frame.is_ok() {
        progress.end();
    }
    progress.clear();
    frame.map_err(blame)
}

/// Looks whether the camera can see anything.
pub fn look(scene: &LoadedScene, settings: &Settings, common: &Common) -> Result<(), Failure> {
    if let Some(warning) = probe::look(scene, settings).map_err(blame)?
        && !common.quiet
    {
        eprintln!("warning: {warning}");
    }
    Ok(())
}

/// Blames the input for a setting that the core refuses or a picture that does not fit, else the work.
pub fn blame(error: Error) -> Failure {
    match error {
        Error::Read { .. } | Error::Setting(_) | Error::Sizes { .. } | Error::NotFinite { .. } => bad(error),
        _ => failed(error),
    }
}

pub fn print(common: &Common, json: bool, report: &Rendered) {
    if json {
        print_json(report);
    } else if !common.quiet {
        say(&report.to_string());
    }
}

/// Says something beside the results.
pub fn note(common: &Common, text: String) {
    if !common.quiet {
        eprintln!("{text}")
    }
}

pub fn print_json(report: &impl serde::Serialize) {
    // Plain data with string keys: it cannot fail to become JSON.
    say(&serde_json::to_string_pretty(report).unwrap_or_default());
}

pub fn say(text: &str) {
    // A reader that has closed the pipe has read enough.
    let _ = writeln!(std::io::stdout(), "{}", text.trim_end());
}
