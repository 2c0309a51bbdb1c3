//! Methods and measures as a page shows them.

use crate::compare::data::Row;
use crate::compare::plot;
use crate::compare::report::Report;
use crate::compare::stats::Measures;

/// A measure: its name, what its number means, and where it is.
pub(super) type Measure = (&'static str, &'static str, fn(&Measures) -> f64);

/// What is plotted and compared.
pub(super) const MEASURES: [Measure; 4] = [
    ("Err", "mean of e²/tvi", |m| m.err),
    ("Low-pass Err", "after an 8×8 box average", |m| m.err_lowpass),
    ("relMSE", "mean of e²/(ref² + 0.01)", |m| m.rel_mse),
    ("Flicker", "mean of (e_t − e_{t−1})²/tvi", |m| m.flicker),
];

/// The measures that a report has: flicker needs frames.
pub(super) fn measures(report: &Report) -> &'static [Measure] {
    if report.frames.is_empty() { &MEASURES[..3] } else { &MEASURES }
}

/// The rows of each method in turn.
pub(super) fn methods<'a>(report: &'a Report) -> impl Iterator<Item = Vec<&'a Row>> {
    report.rows.chunk_by(|a, b| a.method == b.method).map(|rows| rows.iter().collect())
}

/// A method's name beside its colour.
pub(super) fn named(method: usize, name: &str) -> String {
    let (r, g, b) = plot::colour(method);
    format!("<i class='swatch' style='background:rgb({r},{g},{b})'></i>{}", escape(name))
}

/// Text that a page shows as it is.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
