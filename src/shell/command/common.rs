//! What the commands share: failures, loading, settings, what they say.

use super::arguments::Common;
use super::print::Rendered;
use super::progress;
use pmcip::error::Error;
use pmcip::frame::probe;
use pmcip::frame::render::{self, Frame};
use pmcip::frame::settings::{Method, Settings};
use pmcip::scene::{Animation, Eye, LightChoice, LoadedScene, Options, SkyMap};
use pmcip_core::sampler::Tally;
use std::io::Write;
use std::path::Path;

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

/// Loads a scene that can be rendered, and passes on what the loader noticed. One that its own light leaves in the dark, at
/// an exposure that is the scene's where none is given, gets a light of last resort, if it is no scene file and may have one.
pub fn load(common: &Common, exposure: Option<f32>) -> Result<Animation, Failure> {
    let mut options = Options { strict: common.strict, light: common.light, eye: eye(common) };
    if let Some(file) = &common.sky {
        return under_sky(common, options, file);
    }
    let open = |options: &Options| {
        let animation = Animation::open(&common.scene, options).map_err(bad)?;
        animation.scene().require_light().map(|()| animation).map_err(bad)
    };
    let mut animation = open(&options)?;
    let mut dark = None;
    if common.light == LightChoice::Auto && !animation.scene().has_lamp {
        let scene = animation.scene();
        let settings = path_settings(scene, common, Method::Uniform, None);
        if probe::is_dark(scene, &settings, exposure.unwrap_or(scene.exposure)).map_err(blame)? {
            let name = common.scene.display();
            let why = format!("{name}: its own light leaves the picture nearly black");
            if animation.scene().is_bare() {
                options.light = LightChoice::Sky;
                animation = open(&options)?;
                dark = Some(format!("{why}: {} is added (--light own: without)", LAST_RESORT));
            } else {
                dark = Some(format!("{why}: --light sky adds {LAST_RESORT}"));
            }
        }
    }
    warn(common, animation.scene().warnings.iter().chain(&dark));
    Ok(animation)
}

/// What lights a scene that nothing else does.
const LAST_RESORT: &str = "a soft sky and a key light, in a room a lamp by the camera,";

/// Loads a scene under the sky of a file.
fn under_sky(common: &Common, mut options: Options, file: &Path) -> Result<Animation, Failure> {
    if options.light == LightChoice::Auto {
        options.light = LightChoice::Own;
    }
    let (sky, warnings) = SkyMap::load(file).map_err(bad)?;
    let animation = Animation::open(&common.scene, &options).map_err(bad)?.under(sky);
    warn(common, animation.scene().warnings.iter().chain(&warnings));
    Ok(animation)
}

fn warn<'a>(common: &Common, warnings: impl Iterator<Item = &'a String>) {
    if !common.quiet {
        warnings.for_each(|warning| eprintln!("warning: {warning}"));
    }
}

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

pub fn work(scene: &LoadedScene, settings: &Settings, common: &Common) -> Result<Frame, Failure> {
    look(scene, settings, common)?;
    let bar = progress::bar(settings.pixels(), Some(u64::from(settings.spp)), common.quiet);
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
