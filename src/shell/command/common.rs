//! What the commands share: failures, loading, settings, what they say.

use super::arguments::Common;
use super::print::Rendered;
use super::progress;
use pmcip::error::Error;
use pmcip::frame::probe;
use pmcip::frame::render::{self, Frame};
use pmcip::frame::settings::{Method, Settings};
use pmcip::scene::{Animation, LoadedScene, SkyMap, View};
use std::io::Write;

/// Why a command ended without success.
pub struct Failure {
    /// 2 for bad input, 1 for failed work.
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

/// Loads a scene that can be rendered, and passes on what the loader noticed.
pub fn load(common: &Common) -> Result<Animation, Failure> {
    let sky = common.sky.as_ref().map(|file| SkyMap::load(file)).transpose().map_err(bad)?;
    let (animation, warnings) = match sky {
        None => (Animation::load_lit(&common.scene).map_err(bad)?, Vec::new()),
        Some((sky, warnings)) => (Animation::load(&common.scene).map_err(bad)?.under(sky), warnings),
    };
    if !common.quiet {
        let all = animation.scene().warnings.iter().chain(&warnings);
        all.for_each(|warning| eprintln!("warning: {warning}"));
    }
    Ok(animation)
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
    settings.view = view(common, scene.view);
    let closing = scene.closing_view.map(|closing| view(common, closing));
    settings.closing_view = closing.filter(|closing| *closing != settings.view);
    settings
}

/// The camera of the command, where it says nothing that of the scene.
pub fn view(common: &Common, scene: View) -> View {
    View {
        from: common.look_from.unwrap_or(scene.from),
        at: common.look_at.unwrap_or(scene.at),
        up: common.up.unwrap_or(scene.up),
        fov: common.fov.unwrap_or(scene.fov),
        aperture: common.aperture.unwrap_or(scene.aperture),
        focus: common.focus.or(scene.focus),
    }
}

pub fn work(scene: &LoadedScene, settings: &Settings, common: &Common) -> Result<Frame, Failure> {
    look(scene, settings, common)?;
    let bar = progress::bar(settings.pixels(), u64::from(settings.spp), common.quiet);
    let frame = render::render(scene, settings, common.threads, &|samples| bar.inc(samples));
    bar.finish_and_clear();
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
