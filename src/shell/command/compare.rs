//! The command `compare`: methods against a reference.

use super::arguments::Compare;
use super::common::{Failure, admit, bad, blame, failed, note, path_settings, print_json, say, settings};
use super::load::load;
use super::progress::{Progress, Work};
use pmcip::compare::report::{FILES, Report};
use pmcip::compare::{self, Comparison, Moving, Other, Plan, Shot, Stage, Still, reference};
use pmcip::error::Error;
use pmcip::frame::settings::{Method, Settings};
use pmcip::picture::frame_io::Picture;
use pmcip::picture::output;
use pmcip::scene::{Animation, LoadedScene};
use std::fs;
use std::ops::RangeInclusive;
use std::path::Path;

pub fn compare_methods(arguments: &Compare) -> Result<(), Failure> {
    let common = &arguments.common;
    let mut animation = load(common, None)?;
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
    let others = read_others(arguments, &base)?;
    let (plan, progress) = begin(arguments, base, 1);
    let reference = find_reference(scene, &base, arguments, &progress)?;
    let mut stage =
        Still(Shot { scene, base, reference: &reference.picture, noise: reference.energy_noise() });
    let mut comparison = run_plan(&mut stage, &plan, &progress)?;
    for (other, picture) in others {
        comparison.add(other, picture, &stage.0).map_err(blame)?;
    }
    finish_report(arguments, Report::new(scene, &plan, &reference, &comparison))?;
    admit(arguments.common.quiet, comparison.tally)
}

/// The pictures of other programs, those of one name in a row: read before any work, since they may not fit.
fn read_others(arguments: &Compare, base: &Settings) -> Result<Vec<(Other, Picture)>, Failure> {
    let read = |other: &Other| other.read(base).map(|picture| (other.clone(), picture)).map_err(bad);
    let mut others = arguments.others.iter().map(read).collect::<Result<Vec<_>, _>>()?;
    others.sort_by(|(a, _), (b, _)| a.name.cmp(&b.name));
    Ok(others)
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
    let (_, base) = stage.seek(*frames.start()).map_err(blame)?;
    let (plan, progress) = begin(arguments, base, frames.count());
    let reference = find_references(arguments, &mut stage, &progress)?;
    let comparison = run_plan(&mut stage, &plan, &progress)?;
    finish_report(arguments, Report::new(stage.animation.scene(), &plan, &reference, &comparison))?;
    admit(arguments.common.quiet, comparison.tally)
}

/// What is to be rendered of so many frames beside the references, and how far all of it is.
fn begin(arguments: &Compare, base: Settings, frames: usize) -> (Plan, Progress) {
    let Compare { common, reference, reference_spp, watch, json, .. } = arguments;
    let plan = Plan::new(&arguments.methods, &arguments.spp, arguments.runs, base, common.threads);
    let references = if reference.is_some() { 0 } else { u64::from(*reference_spp) * frames as u64 };
    let spp = references + plan.total_spp(frames);
    let whole = Work { pixels: base.pixels(), spp, ..Work::default() };
    let progress = Progress::new(watch.form(*json, common.quiet), whole, 1);
    progress.begin(None);
    progress.add(0);
    (plan, progress)
}

/// Renders and measures everything.
fn run_plan(stage: &mut dyn Stage, plan: &Plan, progress: &Progress) -> Result<Comparison, Failure> {
    let comparison = compare::run(stage, plan, &|samples| progress.add(samples));
    if comparison.is_ok() {
        progress.end();
    }
    progress.clear();
    comparison.map_err(blame)
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
    progress: &Progress,
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
            progress.skip(base.pixels() * u64::from(spp));
            Ok(reference)
        }
        Err(reason) => {
            note(common, format!("renders the reference with {spp} samples a pixel: {reason}"));
            let add = |samples| progress.add(samples);
            Reference::render(&file, scene, base, spp, common.threads, &add).map_err(blame)
        }
    }
}

/// Makes sure that every frame has its reference, and returns that of the first.
fn find_references(
    arguments: &Compare,
    stage: &mut Moving,
    progress: &Progress,
) -> Result<reference::Reference, Failure> {
    use reference::Reference;
    let (common, spp) = (&arguments.common, arguments.reference_spp);
    let frames = stage.frames();
    let (mut first, mut reused) = (None, 0);
    for frame in frames.clone() {
        let file = reference::of_frame(&stage.references, frame);
        let (scene, base) = stage.seek(frame).map_err(blame)?;
        let found = match &arguments.reference {
            Some(_) => Reference::read(&file, &base, scene.cd_per_unit).map_err(blame)?,
            None => match Reference::find(&file, scene, &base, spp) {
                Ok(found) => {
                    progress.skip(base.pixels() * u64::from(spp));
                    reused += 1;
                    found
                }
                Err(_) => Reference::render(&file, scene, &base, spp, common.threads, &|n| progress.add(n))
                    .map_err(blame)?,
            },
        };
        first.get_or_insert(found);
    }
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
