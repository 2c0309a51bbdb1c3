//! The command `bake`: a lightmap.

use super::arguments::Bake;
use super::common::{Failure, admit, bad, blame, failed, print_json, say};
use super::load::Loader;
use super::progress::{Progress, Work};
use pmcip::bake::atlas::{Atlas, Fineness};
use pmcip::bake::check::{Check, check};
use pmcip::bake::light::{Lightmap, bake};
use pmcip::bake::{mesh, second};
use pmcip::frame::settings::{Method, Settings};
use pmcip::picture::{frame_io, output};
use pmcip::scene::{Eye, LoadedScene};
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::tracer::scene::Scene;
use serde::Serialize;
use std::fmt::{self, Display, Formatter};
use std::path::{Path, PathBuf};

/// Texels a side where nobody says.
const DEFAULT_SIZE: u32 = 1024;

/// What was done.
#[derive(Serialize)]
struct Report {
    scene: String,
    size: u32,
    texels_per_unit: f32,
    islands: usize,
    used: f64,
    spp: u32,
    samples: u64,
    rejected: u64,
    seconds: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    check_energy_bias: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    check_difference: Option<f64>,
    files: Vec<PathBuf>,
}

pub fn bake_lightmap(arguments: &Bake) -> Result<(), Failure> {
    let loader = Loader { source: &arguments.source, eye: Eye::default(), quiet: arguments.quiet };
    let trial = |scene: &LoadedScene| settings(arguments, scene, None);
    let scene = loader.load(arguments.exposure, trial)?.into_scene();
    let exr = &arguments.output;
    let [png, obj, check_png] = ["png", "obj", "check.png"].map(|end| exr.with_extension(end));
    let mut files = vec![exr.clone(), png.clone(), obj.clone()];
    files.extend(arguments.check.then(|| check_png.clone()));
    files.iter().try_for_each(|path| output::check(path)).map_err(bad)?;
    let atlas = atlas(arguments, &scene)?;
    let settings = settings(arguments, &scene, Some((atlas.size, atlas.size)));
    let lightmap = work(arguments, &scene, &atlas, &settings)?;
    let picture = lightmap.picture(&scene, &settings);
    frame_io::write_exr(exr, &picture).map_err(failed)?;
    frame_io::write_png(&png, &picture, arguments.exposure.unwrap_or(scene.exposure)).map_err(failed)?;
    mesh::write(&obj, &scene, &atlas).map_err(failed)?;
    let check = match arguments.check {
        true => Some(look(arguments, &scene, &atlas, &lightmap, &check_png)?),
        false => None,
    };
    let difference = check.and_then(|check| check.difference);
    let report = Report {
        scene: scene.name.clone(),
        size: atlas.size,
        texels_per_unit: atlas.density,
        islands: atlas.charts(),
        used: atlas.used() as f64 / lightmap.labels.len() as f64,
        spp: settings.spp,
        samples: lightmap.tally.samples,
        rejected: lightmap.tally.rejected,
        seconds: lightmap.seconds,
        check_energy_bias: difference.map(|difference| difference.energy_bias),
        check_difference: difference.map(|difference| difference.rms),
        files,
    };
    match (arguments.json, arguments.quiet) {
        (true, _) => print_json(&report),
        (false, false) => say(&report.to_string()),
        (false, true) => {}
    }
    admit(arguments.quiet, lightmap.tally)
}

/// By the scene's second texture coordinates, if it has any that are of use.
fn atlas<'a>(arguments: &Bake, scene: &'a LoadedScene) -> Result<Atlas<'a>, Failure> {
    if !scene.second_uvs.is_empty() {
        match second::atlas(scene, fineness(arguments)) {
            Ok(atlas) => return Ok(atlas),
            Err(why) if !arguments.quiet => {
                let name = scene.path.display();
                eprintln!("warning: {name}: second texture coordinates are not used: {why}");
            }
            Err(_) => {}
        }
    }
    Atlas::new(scene, fineness(arguments)).map_err(blame)
}

fn fineness(arguments: &Bake) -> Fineness {
    match (arguments.size, arguments.texels_per_unit) {
        (Some(size), Some(density)) => Fineness::Both(size, density),
        (None, Some(density)) => Fineness::Density(density),
        (size, None) => Fineness::Size(size.unwrap_or(DEFAULT_SIZE)),
    }
}

/// The settings of the command; `size` instead of the scene's own.
fn settings(arguments: &Bake, scene: &LoadedScene, size: Option<(u32, u32)>) -> Settings {
    let mut settings = Settings::new(scene, arguments.sampler, arguments.spp, size);
    settings.max_depth = arguments.max_depth.unwrap_or(settings.max_depth);
    settings.sampler.seed = arguments.seed;
    let usual = if arguments.sampler == Method::Pmc { Estimator::Guided } else { settings.sampler.estimator };
    settings.set_estimator(arguments.estimator.map_or(usual, Into::into));
    settings
}

fn work(
    arguments: &Bake,
    scene: &LoadedScene,
    atlas: &Atlas<'_>,
    settings: &Settings,
) -> Result<Lightmap, Failure> {
    let whole = Work { pixels: atlas.used() as u64, spp: settings.spp.into(), ..Work::default() };
    let progress = Progress::new(arguments.watch.form(arguments.json, arguments.quiet), whole, 1);
    let core = Scene::new(scene.data()).map_err(bad)?;
    progress.begin(None);
    progress.add(0);
    let lightmap = bake(atlas, core, settings, arguments.threads, &|samples| progress.add(samples));
    if lightmap.is_ok() {
        progress.end();
    }
    progress.clear();
    lightmap.map_err(blame)
}

/// Renders the scene with and without the lightmap.
fn look(
    arguments: &Bake,
    scene: &LoadedScene,
    atlas: &Atlas<'_>,
    lightmap: &Lightmap,
    png: &Path,
) -> Result<Check, Failure> {
    let settings = settings(arguments, scene, None);
    let check = check(scene, atlas, lightmap, &settings, arguments.threads).map_err(blame)?;
    let exposure = arguments.exposure.unwrap_or(scene.exposure);
    frame_io::write_png(png, &check.picture, exposure).map_err(failed)?;
    Ok(check)
}

impl Display for Report {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Report { scene, size, texels_per_unit, islands, spp, seconds, .. } = self;
        let used = 100.0 * self.used;
        writeln!(
            f,
            "{scene}: {size}×{size} texels, {texels_per_unit:.2} per unit, {used:.0} % in {islands} islands"
        )?;
        writeln!(f, "{spp} samples per texel in use, {seconds:.2} s, {} samples rejected", self.rejected)?;
        if let (Some(bias), Some(difference)) = (self.check_energy_bias, self.check_difference) {
            let (bias, difference) = (100.0 * bias, 100.0 * difference);
            writeln!(
                f,
                "lit by it: energy {bias:+.2} %, differs by {difference:.2} % (RMS) from the path tracer"
            )?;
        }
        let files: Vec<_> = self.files.iter().map(|file| file.display().to_string()).collect();
        writeln!(f, "wrote {}", files.join(", "))
    }
}
