//! The command `merge`: films of one frame, rendered apart, as one.
//!
//! They are merged by pairs, the results by pairs, and so on: one after the other each film would count for less in single
//! precision until it counted for nothing. In memory are as many films as that has levels, however many there are.

use super::arguments::Merge;
use super::common::{Failure, bad, blame, failed, print_json, say};
use pmcip::error::Error;
use pmcip::film::Film;
use pmcip::frame::attributes::{MERGED_SEEDS, difference};
use pmcip::frame::checkpoint;
use pmcip::frame::settings::Layer;
use pmcip::picture::frame_io::{self, Picture};
use pmcip::picture::output;
use pmcip_core::sampler::estimate::Estimator;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What was done.
#[derive(Serialize)]
struct Report<'a> {
    films: &'a [PathBuf],
    seeds: &'a [u32],
    samples: u64,
    files: [&'a Path; 3],
}

/// A film file.
struct Part<'a> {
    path: &'a Path,
    attributes: BTreeMap<String, String>,
    /// In order.
    seeds: Vec<u32>,
}

pub fn merge_films(arguments: &Merge) -> Result<(), Failure> {
    let Merge { films, output: exr, exposure, .. } = arguments;
    let (png, out) = (exr.with_extension("png"), checkpoint::path(exr));
    [exr, &png, &out].into_iter().try_for_each(|path| output::check(path)).map_err(bad)?;
    let mut parts = films.iter().map(|path| open(path)).collect::<Result<Vec<Part<'_>>, _>>()?;
    // In this order whatever that of the files is: so the result has the same bits.
    parts.sort_by(|a, b| a.seeds.cmp(&b.seeds));
    check(&parts)?;
    let Some(first) = parts.first() else { return Err(bad("no films to merge")) };
    let mut film = merged(&parts)?;
    let mut seeds: Vec<u32> = parts.iter().flat_map(|part| part.seeds.iter().copied()).collect();
    seeds.sort_unstable();
    let mut attributes = first.attributes.clone();
    let list: Vec<String> = seeds.iter().map(u32::to_string).collect();
    attributes.insert("seed".into(), list[0].clone());
    attributes.insert(MERGED_SEEDS.into(), list.join(","));
    checkpoint::write(&out, &attributes, &film.save().map_err(failed)?).map_err(failed)?;
    let picture = picture(&mut film, attributes).map_err(blame)?;
    frame_io::write_png(&png, &picture, *exposure).map_err(failed)?;
    frame_io::write_exr(exr, &picture).map_err(failed)?;
    let samples = film.count().map_err(failed)?.iter().map(|count| u64::from(*count)).sum();
    let report = Report { films, seeds: &seeds, samples, files: [exr, &png, &out] };
    if arguments.json {
        print_json(&report);
    } else {
        let [exr, png, out] = report.files.map(Path::display);
        say(&format!("{} films, {samples} samples\nwrote {exr}, {png} and {out}", films.len()));
    }
    Ok(())
}

impl Part<'_> {
    /// The film as bytes.
    fn film(&self) -> Result<Vec<u8>, Failure> {
        checkpoint::open(self.path).map(|(_, film)| film).map_err(bad)
    }
}

/// All of at least one film.
fn merged(parts: &[Part<'_>]) -> Result<Film, Failure> {
    if let [part] = parts {
        return Film::load(&part.film()?).map_err(|why| unread(part, &why));
    }
    let (some, others) = parts.split_at(parts.len() / 2);
    let mut film = merged(some)?;
    let others_film = match others {
        [part] => part.film()?,
        _ => merged(others)?.save().map_err(failed)?,
    };
    film.merge(&others_film).map_err(|why| unread(&others[0], &why))?;
    Ok(film)
}

/// Blames a film file.
fn unread(part: &Part<'_>, why: &Error) -> Failure {
    bad(Error::read(part.path, why))
}

fn open(path: &Path) -> Result<Part<'_>, Failure> {
    let attributes = checkpoint::attributes(path).map_err(bad)?;
    let seeds = attributes.get(MERGED_SEEDS).or(attributes.get("seed"));
    let seeds =
        seeds.and_then(|list| list.split(',').map(|seed| seed.parse().ok()).collect::<Option<Vec<u32>>>());
    match seeds {
        Some(seeds) => Ok(Part { path, attributes, seeds }),
        None => Err(bad(Error::read(path, "it does not say of which seed it is"))),
    }
}

/// Makes sure that the films are of one frame, and none of them is there twice.
fn check(parts: &[Part<'_>]) -> Result<(), Failure> {
    let alike = |part: &Part<'_>| {
        let mut attributes = part.attributes.clone();
        attributes.remove("seed");
        attributes
    };
    for (i, part) in parts.iter().enumerate() {
        if let Some(why) = difference(&alike(part), &alike(&parts[0])) {
            let (one, other) = (part.path.display(), parts[0].path.display());
            return Err(bad(format!("{one} is of another frame than {other}: {why} there")));
        }
        let shared = |other: &&Part<'_>| other.seeds.iter().any(|seed| part.seeds.contains(seed));
        if let Some(other) = parts[..i].iter().find(shared) {
            let (one, other) = (part.path.display(), other.path.display());
            return Err(bad(format!(
                "{one} and {other} have samples of the same seed: render them with others"
            )));
        }
    }
    Ok(())
}

/// The picture of a film, by its estimator; one that is to be filtered by `balanced`.
fn picture(film: &mut Film, mut attributes: BTreeMap<String, String>) -> Result<Picture, Error> {
    let settings = *film.settings();
    let estimator = match settings.estimator {
        Estimator::Guided => Estimator::Balanced,
        other => other,
    };
    attributes.insert("estimator".into(), pmcip::frame::settings::word(estimator));
    let counts = film.count()?.iter().map(|count| *count as f32).collect();
    let planes =
        [(Layer::Variance, film.variance()?), (Layer::Count, counts), (Layer::Kernel, film.alpha()?)];
    let planes = planes.map(|(layer, plane)| (layer.channels()[0].to_owned(), plane));
    Ok(Picture {
        width: settings.width,
        height: settings.height,
        rgb: film.resolve(estimator)?,
        planes: planes.into_iter().collect(),
        attributes,
    })
}
