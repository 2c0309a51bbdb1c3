//! The numbers of a comparison as tables of a page.

use super::super::data::Row;
use super::super::digits::{count, fixed, number, significant};
use super::super::ratio::Ratio;
use super::super::report::Report;
use super::methods::{Measure, measures as columns, methods, named};

/// Columns of what was measured, after the method's.
const HEADS: [&str; 10] = [
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

/// How much better than uniform sampling.
pub fn ratios(report: &Report) -> String {
    let count = columns(report).len();
    let names = columns(report).iter().enumerate().map(|(i, (name, ..))| {
        let left = if i == 0 { " class='left'" } else { "" };
        format!("<th{left}>{name}</th>")
    });
    let names = names.collect::<String>();
    let pairs = report.ratios.equal_spp.iter().zip(&report.ratios.equal_time);
    let rows: String = pairs.map(|(same, time)| ratio_line(report, same, time)).collect();
    format!(
        "<h2>Uniform ÷ method</h2>\n<table>\n<tr><th colspan='2'></th>\
         <th class='group left' colspan='{count}'>at equal samples</th>\
         <th class='group left' colspan='{count}'>at equal time</th><th class='left'></th></tr>\n\
         <tr><th class='name'>method</th><th>spp</th>{names}{names}<th class='left'>P-Eff gain</th></tr>\n\
         {rows}</table>\n\
         <p class='note'>Above 1 the method has less error than uniform sampling. At equal time uniform’s error is \
         read off its curve over seconds, followed at most a factor of two beyond its measured points (as 1/time if \
         there is but one).</p>\n"
    )
}

fn ratio_line(report: &Report, same: &Ratio, time: &Ratio) -> String {
    let method = methods(report).position(|rows| rows[0].method == same.method).unwrap_or(0);
    let first = same.spp.is_none() || report.rows.first().is_some_and(|row| row.spp == same.spp);
    format!(
        "<tr{}><td class='name'>{}</td><td>{}</td>{}{}<td class='left'>{}</td></tr>\n",
        if first { " class='first'" } else { "" },
        named(method, &same.method),
        count(same.spp),
        ratio_cells(report, same),
        ratio_cells(report, time),
        number(same.p_eff_gain),
    )
}

fn ratio_cells(report: &Report, ratio: &Ratio) -> String {
    let cell = |(i, &(_, _, of)): (usize, &Measure)| {
        let left = if i == 0 { " class='left'" } else { "" };
        let error = ratio.stderr.as_ref().map(of).filter(|error| error.is_finite());
        let error = error.map_or(String::new(), |error| format!(" <small>± {error:.2}</small>"));
        format!("<td{left}>{}{error}</td>", number(of(&ratio.measures)))
    };
    columns(report).iter().enumerate().map(cell).collect()
}

/// Every number that was measured.
pub fn measures(report: &Report) -> String {
    let flicker = (!report.frames.is_empty()).then_some("flicker");
    let heads: String = HEADS.into_iter().chain(flicker).map(|head| format!("<th>{head}</th>")).collect();
    let rows = methods(report).enumerate().flat_map(|(method, rows)| {
        let line = move |(i, row): (usize, &Row)| measure_line(method, row, i == 0);
        rows.into_iter().enumerate().map(line).collect::<Vec<String>>()
    });
    format!(
        "<h2>Measures</h2>\n<table>\n<tr><th class='name'>method</th>{heads}</tr>\n{}</table>\n\
         <p class='note'>P-Eff is 1/(seconds · Err). Trimmed is relMSE without the worst 0.1 % of pixels. Energy \
         bias is Σe/Σref, ± half the width of an interval that contains the truth in 95 % of all cases or more, by Student’s t from the spread of the runs and the \
         reference’s own noise as far as that is known.</p>\n",
        rows.collect::<String>()
    )
}

fn measure_line(method: usize, row: &Row, first: bool) -> String {
    let m = &row.measures;
    let small = |value: f64| format!("<td>{}</td>", significant(value, 4));
    let flicker = if m.flicker.is_nan() { String::new() } else { small(m.flicker) };
    let numbers = [m.err, row.p_eff, m.err_lowpass, m.mse, m.rel_mse, m.rel_mse_trimmed].map(small).concat();
    format!(
        "<tr{}><td class='name'>{}</td><td>{}</td><td>{}</td><td>{:.3}</td>{numbers}\
         <td>{:+.3} % <small>± {}</small></td>{flicker}</tr>\n",
        if first { " class='first'" } else { "" },
        named(method, &row.method),
        count(row.spp),
        count(row.iterations),
        row.seconds,
        100.0 * row.energy_bias,
        fixed(100.0 * row.energy_bias_ci95, 3),
    )
}
