//! A comparison as a page that needs nothing else: plots, tables, pictures.

mod gallery;
mod methods;
mod tables;

use super::data::{Comparison, FrameRow, Row};
use super::digits::significant;
use super::other::Other;
use super::pictures::Gallery;
use super::plot::{self, Axis, Line, Point, Spacing};
use super::reference::{Reference, Source};
use super::report::{Machine, Report};
use super::stats::Measures;
use crate::error::Error;
use methods::{escape, measures, methods, named};
use serde_json::{Map, Value};

/// The page.
///
/// # Errors
/// [`Error::Work`] if a plot cannot be drawn.
pub fn html(report: &Report, comparison: &Comparison, cd_per_unit: f64) -> Result<String, Error> {
    let gallery = Gallery::new(comparison, &report.reference.picture, cd_per_unit);
    let title = format!("{}: speed against error", escape(report.scene));
    Ok(format!(
        "<!DOCTYPE html>\n<html lang='en'>\n<head>\n<meta charset='utf-8'>\n<title>{title}</title>\n\
         <style>\n{}</style>\n</head>\n<body>\n<h1>{title}</h1>\n{}{}{}{}{}{}{}</body>\n</html>\n",
        include_str!("style.css"),
        facts(report),
        plots(report)?,
        curves(report)?,
        tables::ratios(report),
        tables::measures(report),
        gallery::pictures(comparison, &gallery),
        gallery::zooms(comparison, &gallery),
    ))
}

/// What was compared, and where.
fn facts(report: &Report) -> String {
    let reference = report.reference;
    let spp = reference.spp.map_or("unknown".into(), |spp| spp.to_string());
    let seed = reference.seed.map_or(String::new(), |seed| format!(", seed {seed}"));
    let Machine { cpu, cpu_threads, threads, system } = &report.machine;
    let machine = format!("{}, {threads} of {cpu_threads} threads, {system}", escape(cpu));
    let oracle = report.oracle_ratio.map_or("unknown: the reference has no variance".into(), |ratio| {
        format!("{ratio:.2} <small>what known variances would gain in Err over uniform sampling</small>")
    });
    let rays = report.oracle_ratio_equal_rays.map_or("unknown".into(), |ratio| {
        format!("{ratio:.2} <small>the same at equal rays, if what samples cost is known, too</small>")
    });
    let mut facts = vec![
        ("Scene", escape(&report.scene_file.display().to_string())),
        ("Oracle ratio", oracle),
        ("Oracle ratio at equal rays", rays),
        (
            "Reference",
            format!(
                "{}, {spp} samples a pixel{seed}; {}",
                escape(&reference.file.display().to_string()),
                noise(reference)
            ),
        ),
        ("Runs", format!("{} of each method at each sample count, first seed {}", report.runs, report.seed)),
        ("Settings", list(&report.settings)),
        ("Machine", machine),
        ("Version", format!("pmcip {}", report.versions.pmcip)),
    ];
    let own = methods(report).map(|rows| rows[0].method.as_str());
    let own = own.filter_map(|method| Some((method, list(report.methods.get(method)?.as_object()?))));
    facts.extend(own);
    let other = |other: &Other| (other.name.clone(), escape(&other.file.display().to_string()));
    let others: Vec<(String, String)> = report.others.iter().map(other).collect();
    facts.extend(others.iter().map(|(name, file)| (name.as_str(), file.clone())));
    facts.extend(report.warnings.iter().map(|warning| ("Warning", escape(warning))));
    let items = facts.iter().map(|(name, value)| format!("<dt>{}</dt><dd>{value}</dd>\n", escape(name)));
    format!("<dl>\n{}</dl>\n", items.collect::<String>())
}

/// What is known of the reference's own noise.
fn noise(reference: &Reference) -> String {
    let (Some(err), Some(energy)) = (reference.noise_err, reference.noise_energy) else {
        return "its own noise is unknown, and no ± contains it".into();
    };
    let source = match reference.noise_source {
        Some(Source::Parts) => "by the spread of its parts",
        _ => "by its variance layer, which takes samples as independent: rather too much",
    };
    let (err, energy) = (significant(err, 2), significant(100.0 * energy, 2));
    format!(
        "its own noise adds about {err} to Err, and ± {energy} % (standard error) to the energy, {source}"
    )
}

fn list(settings: &Map<String, Value>) -> String {
    let item = |(name, value): (&String, &Value)| {
        format!("<small>{}</small> {}", escape(name), escape(value.to_string().trim_matches('"')))
    };
    settings.iter().map(item).collect::<Vec<String>>().join(", ")
}

/// Every measure against time and against samples.
fn plots(report: &Report) -> Result<String, Error> {
    let counts = methods(report).take(1).flatten().filter_map(|row| row.spp.map(f64::from)).collect();
    let seconds = Axis { title: "seconds", scale: Spacing::Logarithmic(None) };
    let samples = Axis { title: "samples per pixel", scale: Spacing::Logarithmic(Some(counts)) };
    let x: [fn(&Row) -> f64; 2] = [|row| row.seconds, |row| row.spp.map_or(f64::NAN, f64::from)];
    let mut drawings = String::new();
    for (axis, x) in [seconds, samples].iter().zip(x) {
        for &(title, _, of) in measures(report) {
            let lines: Vec<Line> =
                methods(report).enumerate().map(|(i, rows)| line(i, &rows, x, of)).collect();
            drawings += &plot::svg(title, axis, &lines)?;
        }
    }
    let names =
        methods(report).enumerate().map(|(i, rows)| format!("<span>{}</span>", named(i, &rows[0].method)));
    Ok(format!(
        "<h2>Error against time and samples</h2>\n<p class='legend'>{}</p>\n\
         <div class='plots'>\n{drawings}</div>\n\
         <p class='note'>Means and standard errors over runs; seconds are medians of the render’s wall time. \
         {}.</p>\n",
        names.collect::<String>(),
        meanings(report),
    ))
}

/// What the measures mean.
fn meanings(report: &Report) -> String {
    let meanings = measures(report).iter().map(|(name, meaning, _)| format!("{name}: {meaning}"));
    meanings.collect::<Vec<String>>().join("; ")
}

/// Every measure over the frames of a sequence, at the largest sample count.
fn curves(report: &Report) -> Result<String, Error> {
    let Some(spp) = report.frames.iter().map(|row| row.spp).max() else { return Ok(String::new()) };
    let rows: Vec<&FrameRow> = report.frames.iter().filter(|row| row.spp == spp).collect();
    let by_method: Vec<&[&FrameRow]> = rows.chunk_by(|a, b| a.method == b.method).collect();
    let axis = Axis { title: "frame", scale: Spacing::Even };
    let mut drawings = String::new();
    for &(title, _, of) in measures(report) {
        let point = |row: &&FrameRow| Point { x: f64::from(row.frame), y: of(&row.measures), error: 0.0 };
        let line = |(method, rows): (usize, &&[&FrameRow])| Line {
            colour: plot::colour(method),
            points: rows.iter().map(point).collect(),
        };
        drawings += &plot::svg(title, &axis, &by_method.iter().enumerate().map(line).collect::<Vec<Line>>())?;
    }
    Ok(format!("<h2>Over frames at {spp} samples a pixel</h2>\n<div class='plots'>\n{drawings}</div>\n"))
}

/// A method's measurements as a line.
fn line(method: usize, rows: &[&Row], x: fn(&Row) -> f64, y: fn(&Measures) -> f64) -> Line {
    let point = |row: &&Row| {
        let error = row.stderr.as_ref().map_or(0.0, y);
        Point { x: x(row), y: y(&row.measures), error }
    };
    Line { colour: plot::colour(method), points: rows.iter().map(point).collect() }
}
