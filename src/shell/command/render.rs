//! The command `render`: one frame.

use super::arguments::Render;
use super::common::{Failure, admit, bad, failed, look, print, settings};
use super::kept::{Kept, attributes};
use super::layers;
use super::load::load;
use super::print::Rendered;
use super::progress::Progress;
use super::signals::Signals;
use pmcip::frame::schedule::{MOST_SPP, Target};
use pmcip::frame::settings::Settings;
use pmcip::picture::{frame_io, output};
use pmcip::scene::LoadedScene;
use pmcip_core::sampler::estimate::Estimator;
use std::path::PathBuf;

pub fn render_frame(arguments: &Render) -> Result<(), Failure> {
    let scene = load(&arguments.common, arguments.exposure)?.into_scene();
    let exr = output_name(arguments, &scene);
    let png = exr.with_extension("png");
    [&exr, &png].into_iter().try_for_each(|path| output::check(path)).map_err(bad)?;
    let settings = render_settings(&scene, arguments)?;
    look(&scene, &settings, &arguments.common)?;
    let signals = Signals::catch();
    let progress =
        Progress::new(arguments.watch.form(arguments.json, arguments.common.quiet), (&settings).into(), 1);
    let mut kept = Kept::new(&exr, attributes(&scene, &settings), arguments);
    progress.begin(None);
    let frame = kept.render(&scene, &settings, &mut (), &signals, &progress)?;
    progress.end();
    progress.clear();
    let picture = frame.picture(&settings, &scene);
    frame_io::write_exr(&exr, &picture).map_err(failed)?;
    frame_io::write_png(&png, &picture, arguments.exposure.unwrap_or(scene.exposure)).map_err(failed)?;
    kept.finish(&frame)?;
    let files = [exr, png];
    let report = Rendered::new(&scene, &settings, &frame, &files);
    print(&arguments.common, arguments.json, &report);
    admit(arguments.common.quiet, frame.tally)
}

/// The file that is asked for, or one named after the scene.
pub fn output_name(arguments: &Render, scene: &LoadedScene) -> PathBuf {
    arguments.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}.exr", scene.name)))
}

/// The settings of `render`.
pub fn render_settings(scene: &LoadedScene, arguments: &Render) -> Result<Settings, Failure> {
    let mut settings = settings(scene, &arguments.common, arguments.sampler, arguments.spp)?;
    settings.iterations = arguments.iterations.unwrap_or(settings.iterations);
    settings.sampler.gamma = arguments.gamma.unwrap_or(settings.sampler.gamma);
    settings.set_estimator(arguments.estimator.map_or(settings.sampler.estimator, Into::into));
    let follows = arguments.frames.is_some();
    settings.layers = layers::chosen(&arguments.layers, settings.sampler.estimator, follows).map_err(bad)?;
    if arguments.history && settings.sampler.estimator != Estimator::Guided {
        return Err(bad("--history needs --estimator guided: it blends filtered frames"));
    }
    settings.history = arguments.history;
    settings.startup = arguments.startup;
    settings.target = arguments.target_err.map(|err| Target { err, expected_spp: None });
    settings.seconds = arguments.time;
    if arguments.time.is_some() && arguments.spp.is_none() {
        settings.spp = MOST_SPP;
    }
    if arguments.checkpoint.is_some() && !settings.stands_alone() {
        let other = "--history, --target-err or a --startup other than uniform";
        return Err(bad(format!("--checkpoint cannot be used with {other}: they need more than the film")));
    }
    Ok(settings)
}
