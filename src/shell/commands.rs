//! The commands: read, work, write, report.

use crate::cli::{Command, Common, Compare, Info, Measure, Reference, Render};
use crate::{animate, progress, report};
use pmcip::compare::report::{FILES, Report};
use pmcip::compare::{self, Comparison, Moving, Plan, Shot, Stage, Still, reference};
use pmcip::error::Error;
use pmcip::frame_io::{self, Picture};
use pmcip::render::{self, Frame};
use pmcip::scene::{self, Animation, LoadedScene, View};
use pmcip::settings::{Method, Settings};
use pmcip::stop::Target;
use pmcip::{metrics, output, probe};
use std::fs;
use std::io::Write;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// Luminance of radiance 1 in cd/m², for images that do not say.
const DEFAULT_CD_PER_UNIT: f64 = 100.0;

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

/// Runs a command.
pub fn run(command: Command) -> Result<(), Failure> {
    match command {
        Command::Render(arguments) => match arguments.frames {
            Some(range) => animate::render_frames(&arguments, range),
            None => render_frame(&arguments),
        },
        Command::Reference(arguments) => render_reference(&arguments),
        Command::Compare(arguments) => compare_methods(&arguments),
        Command::Error(arguments) => measure(&arguments),
        Command::Info(arguments) => info(&arguments),
    }
}

fn render_frame(arguments: &Render) -> Result<(), Failure> {
    let scene = load(&arguments.common)?.into_scene();
    let exr = output_name(arguments, &scene);
    let png = exr.with_extension("png");
    [&exr, &png].into_iter().try_for_each(|path| output::check(path)).map_err(bad)?;
    let settings = render_settings(&scene, arguments)?;
    let frame = work(&scene, &settings, &arguments.common)?;
    let picture = frame.picture(&settings, &scene);
    frame_io::write_exr(&exr, &picture).map_err(failed)?;
    frame_io::write_png(&png, &picture, arguments.exposure).map_err(failed)?;
    let files = [exr, png];
    let report = report::Rendered::new(&scene, &settings, &frame, &files);
    print(&arguments.common, arguments.json, &report);
    Ok(())
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
    settings.target = arguments.target_err.map(|err| Target { err, expected_spp: None });
    Ok(settings)
}

fn render_reference(arguments: &Reference) -> Result<(), Failure> {
    let scene = load(&arguments.common)?.into_scene();
    output::check(&arguments.output).map_err(bad)?;
    let settings = settings(&scene, &arguments.common, Method::Uniform, Some(arguments.spp))?;
    let frame = work(&scene, &settings, &arguments.common)?;
    frame_io::write_exr(&arguments.output, &frame.picture(&settings, &scene)).map_err(failed)?;
    let report = report::Rendered::new(&scene, &settings, &frame, std::slice::from_ref(&arguments.output));
    print(&arguments.common, arguments.json, &report);
    Ok(())
}

/// Loads a scene that can be rendered, and passes on what the loader noticed.
pub fn load(common: &Common) -> Result<Animation, Failure> {
    let animation = Animation::load_lit(&common.scene).map_err(bad)?;
    if !common.quiet {
        animation.scene().warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
    }
    Ok(animation)
}

/// The settings of the command and the scene, with the method's defaults for the rest.
fn settings(
    scene: &LoadedScene,
    common: &Common,
    method: Method,
    spp: Option<u32>,
) -> Result<Settings, Failure> {
    let integrator = common.integrator().map_err(bad)?;
    Ok(Settings { integrator, ..path_settings(scene, common, method, spp) })
}

/// The settings of the command and the scene but for the integrator, which is asked for apart.
fn path_settings(scene: &LoadedScene, common: &Common, method: Method, spp: Option<u32>) -> Settings {
    let mut settings = Settings::new(scene, method, spp, common.size);
    settings.max_depth = common.max_depth.unwrap_or(settings.max_depth);
    settings.sampler.seed = common.seed;
    settings.view = View {
        from: common.look_from.unwrap_or(scene.view.from),
        at: common.look_at.unwrap_or(scene.view.at),
        up: common.up.unwrap_or(scene.view.up),
        fov: common.fov.unwrap_or(scene.view.fov),
    };
    settings
}

fn work(scene: &LoadedScene, settings: &Settings, common: &Common) -> Result<Frame, Failure> {
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

fn print(common: &Common, json: bool, report: &report::Rendered) {
    if json {
        print_json(report);
    } else if !common.quiet {
        say(&report.to_string());
    }
}

fn compare_methods(arguments: &Compare) -> Result<(), Failure> {
    let common = &arguments.common;
    let mut animation = load(common)?;
    prepare(&arguments.output)?;
    match arguments.frames {
        Some(range) => {
            let frames = range.within(animation.frames().map(|f| (f.first, f.last))).map_err(bad)?;
            compare_sequence(arguments, &mut animation, frames)
        }
        None => compare_still(arguments, animation.scene()),
    }
}

fn compare_still(arguments: &Compare, scene: &LoadedScene) -> Result<(), Failure> {
    let base = settings(scene, &arguments.common, Method::Uniform, None)?;
    let reference = find_reference(scene, &base, arguments)?;
    let mut stage =
        Still(Shot { scene, base, reference: &reference.picture, noise: reference.energy_noise() });
    let (plan, comparison) = run_plan(arguments, &mut stage, base)?;
    finish_report(arguments, Report::new(scene, &plan, &reference, &comparison))
}

fn compare_sequence(
    arguments: &Compare,
    animation: &mut Animation,
    frames: RangeInclusive<u32>,
) -> Result<(), Failure> {
    let integrator = arguments.common.integrator().map_err(bad)?;
    let base = |scene: &LoadedScene| {
        let settings = path_settings(scene, &arguments.common, Method::Uniform, None);
        Settings { integrator, startup: arguments.startup, ..settings }
    };
    let own = arguments.output.join(reference::FILE);
    let references = arguments.reference.clone().unwrap_or(own);
    let reference = Picture::default();
    let mut stage = Moving { animation, frames: frames.clone(), base: &base, references, reference };
    let reference = find_references(arguments, &mut stage)?;
    let (_, base) = stage.seek(*frames.start()).map_err(blame)?;
    let (plan, comparison) = run_plan(arguments, &mut stage, base)?;
    finish_report(arguments, Report::new(stage.animation.scene(), &plan, &reference, &comparison))
}

/// Renders and measures everything.
fn run_plan(
    arguments: &Compare,
    stage: &mut dyn Stage,
    base: Settings,
) -> Result<(Plan, Comparison), Failure> {
    let plan = Plan::new(&arguments.methods, &arguments.spp, arguments.runs, base, arguments.common.threads);
    let frames = stage.frames().count();
    let bar = progress::bar(base.pixels(), plan.total_spp(frames), arguments.common.quiet);
    let comparison = compare::run(stage, &plan, &|samples| bar.inc(samples));
    bar.finish_and_clear();
    Ok((plan, comparison.map_err(blame)?))
}

fn finish_report(arguments: &Compare, report: Report) -> Result<(), Failure> {
    report.write(&arguments.output).map_err(failed)?;
    if arguments.json {
        print_json(&report);
    } else if !arguments.common.quiet {
        say(&format!("{report}the report is {}", arguments.output.join(FILES[2]).display()));
    }
    Ok(())
}

/// Makes sure that a report can be written into `folder`, before hours of work depend on it.
fn prepare(folder: &Path) -> Result<(), Failure> {
    if folder.is_file() {
        return Err(bad(Error::write(folder, "it is a file, not a folder")));
    }
    fs::create_dir_all(folder).map_err(|reason| bad(Error::write(folder, output::plain(&reason))))?;
    FILES.iter().chain([&reference::FILE]).try_for_each(|name| output::check(&folder.join(name))).map_err(bad)
}

/// The reference that is named, or that of the folder, which is rendered if it does not fit.
fn find_reference(
    scene: &LoadedScene,
    base: &Settings,
    arguments: &Compare,
) -> Result<reference::Reference, Failure> {
    use reference::Reference;
    let (common, spp) = (&arguments.common, arguments.reference_spp);
    if let Some(file) = &arguments.reference {
        return Reference::read(file, base, scene.cd_per_unit).map_err(blame);
    }
    let file = arguments.output.join(reference::FILE);
    match Reference::find(&file, scene, base, spp) {
        Ok(reference) => {
            note(common, format!("uses the reference in {}", reference.file.display()));
            Ok(reference)
        }
        Err(reason) => {
            note(common, format!("renders the reference with {spp} samples a pixel: {reason}"));
            let bar = progress::bar(base.pixels(), u64::from(spp), common.quiet);
            let inc = |samples| bar.inc(samples);
            let reference = Reference::render(&file, scene, base, spp, common.threads, &inc);
            bar.finish_and_clear();
            reference.map_err(blame)
        }
    }
}

/// Makes sure that every frame has its reference, and returns that of the first.
fn find_references(arguments: &Compare, stage: &mut Moving) -> Result<reference::Reference, Failure> {
    use reference::Reference;
    let (common, spp) = (&arguments.common, arguments.reference_spp);
    let frames = stage.frames();
    let pixels = stage.seek(*frames.start()).map_err(blame)?.1.pixels();
    let bar = progress::bar(pixels, u64::from(spp) * frames.clone().count() as u64, common.quiet);
    let (mut first, mut reused) = (None, 0);
    for frame in frames.clone() {
        let file = reference::of_frame(&stage.references, frame);
        let (scene, base) = stage.seek(frame).map_err(blame)?;
        let found = match &arguments.reference {
            Some(_) => Reference::read(&file, &base, scene.cd_per_unit).map_err(blame)?,
            None => match Reference::find(&file, scene, &base, spp) {
                Ok(found) => {
                    bar.inc(pixels * u64::from(spp));
                    reused += 1;
                    found
                }
                Err(_) => Reference::render(&file, scene, &base, spp, common.threads, &|n| bar.inc(n))
                    .map_err(blame)?,
            },
        };
        first.get_or_insert(found);
    }
    bar.finish_and_clear();
    if arguments.reference.is_none() {
        let rendered = frames.count() - reused;
        note(
            common,
            format!(
                "uses {reused} references of the folder, has rendered {rendered} of {spp} samples a pixel"
            ),
        );
    }
    first.ok_or_else(|| bad("there are no frames"))
}

/// Says something beside the results.
fn note(common: &Common, text: String) {
    if !common.quiet {
        eprintln!("{text}")
    }
}

fn measure(arguments: &Measure) -> Result<(), Failure> {
    let [image, reference] = [&arguments.image, &arguments.reference].map(|path| frame_io::read_exr(path));
    let (image, reference) = (image.map_err(bad)?, reference.map_err(bad)?);
    let cd_per_unit = cd_per_unit(&reference).or(cd_per_unit(&image)).unwrap_or(DEFAULT_CD_PER_UNIT);
    let metrics = metrics::measure(&image, &reference, cd_per_unit).map_err(bad)?;
    let report = report::Compared { cd_per_unit, metrics };
    if arguments.json {
        print_json(&report)
    } else {
        say(&report.to_string())
    }
    Ok(())
}

fn cd_per_unit(picture: &Picture) -> Option<f64> {
    picture.attributes.get("cd_per_unit")?.parse().ok().filter(|cd: &f64| cd.is_finite() && *cd > 0.0)
}

fn info(arguments: &Info) -> Result<(), Failure> {
    let scene = scene::load(&arguments.scene).map_err(bad)?;
    let report = report::Contents::new(&scene);
    if arguments.json {
        print_json(&report)
    } else {
        say(&report.to_string())
    }
    Ok(())
}

fn print_json(report: &impl serde::Serialize) {
    // Plain data with string keys: it cannot fail to become JSON.
    say(&serde_json::to_string_pretty(report).unwrap_or_default());
}

pub fn say(text: &str) {
    // A reader that has closed the pipe has read enough.
    let _ = writeln!(std::io::stdout(), "{}", text.trim_end());
}
