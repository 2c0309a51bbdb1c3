//! A comparison as a page that needs nothing else: plots, tables, pictures.

use super::colour::{Scale, data_uri};
use super::pictures::{Block, Gallery, Kind};
use super::plot::{self, Line, Point};
use super::ratio::Ratio;
use super::report::Report;
use super::table::number;
use super::{Comparison, Measures, Row};
use crate::error::Error;
use serde_json::{Map, Value};

/// Enlargement of the zooms.
const ENLARGED: usize = 4;

/// A measure: its name, what its number means, and where it is.
type Measure = (&'static str, &'static str, fn(&Measures) -> f64);

/// What is plotted and compared.
const MEASURES: [Measure; 3] = [
    ("Err", "mean of e²/tvi", |m| m.err),
    ("Low-pass Err", "after an 8×8 box average", |m| m.err_lowpass),
    ("relMSE", "mean of e²/(ref² + 0.01)", |m| m.rel_mse),
];

/// The page.
///
/// # Errors
/// [`Error::Work`] if a plot cannot be drawn.
pub fn html(report: &Report, comparison: &Comparison, cd_per_unit: f64) -> Result<String, Error> {
    let gallery = Gallery::new(comparison, &report.reference.picture, cd_per_unit);
    let title = format!("{}: speed against error", escape(report.scene));
    Ok(format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>{title}</title>\n\
         <style>\n{}</style>\n</head>\n<body>\n<h1>{title}</h1>\n{}{}{}{}{}{}</body>\n</html>\n",
        include_str!("page.css"),
        facts(report),
        plots(report)?,
        ratio_table(report),
        measure_table(report),
        pictures(comparison, &gallery),
        zooms(comparison, &gallery),
    ))
}

/// What was compared, and where.
fn facts(report: &Report) -> String {
    let reference = report.reference;
    let spp = reference.spp.map_or("unknown".into(), |spp| spp.to_string());
    let noise =
        reference.err.map_or(String::new(), |err| format!(", its own noise adds at most {err:.2e} to Err"));
    let seed = reference.seed.map_or(String::new(), |seed| format!(", seed {seed}"));
    let machine = &report.machine;
    let oracle = report.oracle_ratio.map_or("unknown: the reference has no variance".into(), |ratio| {
        format!("{ratio:.2} <small>what known variances would gain in Err over uniform sampling</small>")
    });
    let mut facts = vec![
        ("Scene", escape(&report.scene_file.display().to_string())),
        ("Oracle ratio", oracle),
        (
            "Reference",
            format!("{}, {spp} samples a pixel{seed}{noise}", escape(&reference.file.display().to_string())),
        ),
        ("Runs", format!("{} of each method at each sample count, first seed {}", report.runs, report.seed)),
        ("Settings", list(&report.settings)),
        (
            "Machine",
            format!(
                "{}, {} of {} threads, {}",
                escape(&machine.cpu),
                machine.threads,
                machine.cpu_threads,
                machine.system
            ),
        ),
        ("Version", format!("pmcip {}", report.versions.pmcip)),
    ];
    let own =
        report.methods.iter().filter_map(|(method, own)| Some((method.as_str(), list(own.as_object()?))));
    facts.extend(own);
    facts.extend(report.warnings.iter().map(|warning| ("Warning", escape(warning))));
    let items = facts.iter().map(|(name, value)| format!("<dt>{}</dt><dd>{value}</dd>\n", escape(name)));
    format!("<dl>\n{}</dl>\n", items.collect::<String>())
}

fn list(settings: &Map<String, Value>) -> String {
    let item = |(name, value): (&String, &Value)| {
        format!("<small>{}</small> {}", escape(name), escape(value.to_string().trim_matches('"')))
    };
    settings.iter().map(item).collect::<Vec<String>>().join(", ")
}

/// Every measure against time and against samples.
fn plots(report: &Report) -> Result<String, Error> {
    let mut drawings = String::new();
    let axes: [(&str, fn(&Row) -> f64); 2] =
        [("seconds", |row| row.seconds), ("samples per pixel", |row| f64::from(row.spp))];
    for (x_title, x) in axes {
        for (title, _, of) in MEASURES {
            let point = |row: &&Row| Point {
                x: x(row),
                y: of(&row.measures),
                error: row.stderr.as_ref().map_or(0.0, of),
            };
            let lines = methods(report)
                .enumerate()
                .map(|(i, rows)| Line { colour: plot::colour(i), points: rows.iter().map(point).collect() });
            drawings += &plot::svg(title, x_title, &lines.collect::<Vec<Line>>())?;
        }
    }
    let legend =
        methods(report).enumerate().map(|(i, rows)| format!("<span>{}</span>", named(i, &rows[0].method)));
    Ok(format!(
        "<h2>Error against time and samples</h2>\n<p class=\"legend\">{}</p>\n<div class=\"plots\">\n{drawings}</div>\n\
         <p class=\"note\">Means and standard errors over runs; seconds are medians of the render's wall time. {}.</p>\n",
        legend.collect::<String>(),
        MEASURES.map(|(name, meaning, _)| format!("{name}: {meaning}")).join("; "),
    ))
}

/// The rows of each method in turn.
fn methods<'a>(report: &'a Report) -> impl Iterator<Item = Vec<&'a Row>> {
    report.rows.chunk_by(|a, b| a.method == b.method).map(|rows| rows.iter().collect())
}

/// A method's name beside its colour.
fn named(method: usize, name: &str) -> String {
    let (r, g, b) = plot::colour(method);
    format!("<i class=\"swatch\" style=\"background:rgb({r},{g},{b})\"></i>{}", escape(name))
}

/// How much better than uniform sampling.
fn ratio_table(report: &Report) -> String {
    let columns = MEASURES.map(|(name, ..)| name);
    let names = columns.iter().enumerate().map(|(i, name)| {
        let left = if i == 0 { " class=\"left\"" } else { "" };
        format!("<th{left}>{name}</th>")
    });
    let names = names.collect::<String>();
    let rows: String = report
        .ratios
        .equal_spp
        .iter()
        .zip(&report.ratios.equal_time)
        .map(|(same, time)| {
            let method = methods(report).position(|rows| rows[0].method == same.method).unwrap_or(0);
            let first = if report.rows.first().is_some_and(|row| row.spp == same.spp) {
                " class=\"first\""
            } else {
                ""
            };
            format!(
                "<tr{first}><td class=\"name\">{}</td><td>{}</td>{}{}<td class=\"left\">{}</td></tr>\n",
                named(method, &same.method),
                same.spp,
                ratio_cells(same),
                ratio_cells(time),
                number(same.p_eff_gain),
            )
        })
        .collect();
    format!(
        "<h2>Uniform ÷ method</h2>\n<table>\n<tr><th colspan=\"2\"></th><th class=\"group left\" colspan=\"3\">at equal samples</th>\
         <th class=\"group left\" colspan=\"3\">at equal time</th><th class=\"left\"></th></tr>\n\
         <tr><th class=\"name\">method</th><th>spp</th>{names}{names}<th class=\"left\">P-Eff gain</th></tr>\n{rows}</table>\n\
         <p class=\"note\">Above 1 the method has less error than uniform sampling. At equal time uniform’s error is read off its \
         curve over seconds, followed at most a factor of two beyond its measured points (as 1/time if there is but one).</p>\n"
    )
}

fn ratio_cells(ratio: &Ratio) -> String {
    let cell = |(i, (_, _, of)): (usize, Measure)| {
        let left = if i == 0 { " class=\"left\"" } else { "" };
        let error = ratio.stderr.as_ref().map(of).filter(|error| error.is_finite());
        let error = error.map_or(String::new(), |error| format!(" <small>± {error:.2}</small>"));
        format!("<td{left}>{}{error}</td>", number(of(&ratio.measures)))
    };
    MEASURES.into_iter().enumerate().map(cell).collect()
}

/// Every number that was measured.
fn measure_table(report: &Report) -> String {
    let heads = [
        "spp",
        "iterations",
        "seconds",
        "Err",
        "P-Eff",
        "low-pass Err",
        "MSE",
        "relMSE",
        "trimmed",
        "energy bias",
    ];
    let heads: String = heads.iter().map(|head| format!("<th>{head}</th>")).collect();
    let rows = methods(report).enumerate().flat_map(|(method, rows)| {
        let line = move |(i, row): (usize, &Row)| measure_line(method, row, i == 0);
        rows.into_iter().enumerate().map(line).collect::<Vec<String>>()
    });
    format!(
        "<h2>Measures</h2>\n<table>\n<tr><th class=\"name\">method</th>{heads}</tr>\n{}</table>\n\
         <p class=\"note\">P-Eff is 1/(seconds · Err). Trimmed is relMSE without the worst 0.1 % of pixels. Energy bias is \
         Σe/Σref, with its standard error.</p>\n",
        rows.collect::<String>()
    )
}

fn measure_line(method: usize, row: &Row, first: bool) -> String {
    let m = &row.measures;
    let small = |value: f64| format!("<td>{value:.3e}</td>");
    let numbers = [m.err, row.p_eff, m.err_lowpass, m.mse, m.rel_mse, m.rel_mse_trimmed].map(small).concat();
    format!(
        "<tr{}><td class=\"name\">{}</td><td>{}</td><td>{}</td><td>{:.3}</td>{numbers}<td>{:+.3} % <small>± {:.3}</small></td></tr>\n",
        if first { " class=\"first\"" } else { "" },
        named(method, &row.method),
        row.spp,
        row.iterations,
        row.seconds,
        100.0 * row.energy_bias,
        100.0 * row.energy_bias_stderr,
    )
}

/// One row of pictures a method, one column a kind.
fn pictures(comparison: &Comparison, gallery: &Gallery) -> String {
    let spp = comparison.shown.first().map_or(0, |shown| shown.settings.spp);
    let columns = gallery.kinds.len();
    let heads: String = gallery.kinds.iter().map(|kind| head(kind, gallery.exposure)).collect();
    let cells: String = comparison
        .shown
        .iter()
        .enumerate()
        .map(|(method, shown)| {
            gallery
                .kinds
                .iter()
                .map(|kind| {
                    format!(
                        "<figure><img src=\"{}\" alt=\"\"><figcaption>{}</figcaption></figure>\n",
                        data_uri(&kind.rasters[method]),
                        named(method, &shown.method)
                    )
                })
                .collect::<String>()
        })
        .collect();
    let (width, height) = (gallery.reference.width, gallery.reference.height);
    let marks: String =
        gallery.zooms.iter().enumerate().map(|(i, block)| mark(i, block, width, height)).collect();
    format!(
        "<h2>Pictures at {spp} samples a pixel</h2>\n<div class=\"pictures\" style=\"grid-template-columns:repeat({columns},1fr)\">\n\
         {heads}<figure style=\"grid-column:1\"><img src=\"{}\" alt=\"\">{marks}<figcaption>reference</figcaption></figure>\n\
         <span style=\"grid-column:2/-1\"></span>\n{cells}</div>\n",
        data_uri(&gallery.reference)
    )
}

/// The title of a column, and what its colours mean.
fn head(kind: &Kind, exposure: f64) -> String {
    let meaning = match &kind.scale {
        Some(scale) => legend(scale),
        None => format!("<div class=\"ends\">exposure {exposure:+.1} stops</div>"),
    };
    format!("<div><h3>{} <small>{}</small></h3>{meaning}</div>\n", kind.title, kind.unit)
}

fn legend(scale: &Scale) -> String {
    let spacing = if scale.logarithmic { "logarithmic" } else { "linear" };
    format!(
        "<div class=\"bar\" style=\"background:{}\"></div><div class=\"ends\"><span>{:.2e}</span><span>{spacing}</span><span>{:.2e}</span></div>",
        scale.gradient(),
        scale.low,
        scale.high
    )
}

/// The frame around a zoomed block of the reference.
fn mark(i: usize, block: &Block, width: usize, height: usize) -> String {
    let part = |pixels: usize, of: usize| 100.0 * pixels as f64 / of as f64;
    format!(
        "<div class=\"mark\" style=\"left:{:.2}%;top:{:.2}%;width:{:.2}%;aspect-ratio:1\">{}</div>",
        part(block.x, width),
        part(block.y, height),
        part(block.side, width),
        i + 1
    )
}

/// The blocks where methods differ most, enlarged.
fn zooms(comparison: &Comparison, gallery: &Gallery) -> String {
    let rows: String = gallery
        .zooms
        .iter()
        .enumerate()
        .map(|(i, block)| {
            let mut figures = enlarged(&gallery.reference, block, &format!("{}: reference", i + 1));
            for (method, shown) in comparison.shown.iter().enumerate() {
                for kind in &gallery.kinds[..2] {
                    let name =
                        if kind.scale.is_none() { named(method, &shown.method) } else { "difference".into() };
                    figures += &enlarged(&kind.rasters[method], block, &name);
                }
            }
            format!("<div class=\"zooms\">\n{figures}</div>\n")
        })
        .collect();
    if rows.is_empty() {
        return rows;
    }
    format!(
        "<h2>Where the methods differ most</h2>\n{rows}<p class=\"note\">The blocks in which the mean of e²/tvi differs most between \
         the worst and the best method, enlarged {ENLARGED} times.</p>\n"
    )
}

fn enlarged(raster: &super::pictures::Raster, block: &Block, caption: &str) -> String {
    format!(
        "<figure><img src=\"{}\" width=\"{}\" alt=\"\"><figcaption>{caption}</figcaption></figure>\n",
        data_uri(&raster.crop(block)),
        ENLARGED * block.side
    )
}

/// Text that a page shows as it is.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
