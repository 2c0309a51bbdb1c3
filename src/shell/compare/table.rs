//! A comparison as text: the table of ratios for a terminal, and all rows for a spreadsheet.

use super::data::{FrameRow, Row};
use super::digits::{count, fixed, number, significant};
use super::ratio::Ratio;
use super::reference::Source;
use super::report::Report;

/// Columns of the rows that everybody may rely on.
const COLUMNS: &str = "method,spp,iterations,estimator,seconds,err,p_eff,err_lowpass,mse,rel_mse,rel_mse_trimmed,\
                       energy_bias,energy_bias_stderr,runs,err_stderr,err_lowpass_stderr,rel_mse_stderr,flicker,\
                       energy_bias_ci95";

/// The rows as comma-separated values; what is not known is empty.
pub fn csv(rows: &[Row]) -> String {
    let lines = rows.iter().map(|row| {
        let m = &row.measures;
        let errors = row.stderr.map_or([f64::NAN; 3], |s| [s.err, s.err_lowpass, s.rel_mse]);
        let whole = |value: Option<u32>| value.map_or(String::new(), |value| value.to_string());
        let (spp, iterations) = (whole(row.spp), whole(row.iterations));
        let head = format!("{},{spp},{iterations},{}", row.method, row.estimator.as_deref().unwrap_or(""));
        let middle =
            [row.seconds, m.err, row.p_eff, m.err_lowpass, m.mse, m.rel_mse, m.rel_mse_trimmed].map(cell);
        let bias = [row.energy_bias, row.energy_bias_stderr].map(cell).join(",");
        let errors = errors.map(cell).join(",");
        let tail = [m.flicker, row.energy_bias_ci95].map(cell).join(",");
        format!("{head},{},{bias},{},{errors},{tail}\n", middle.join(","), row.runs)
    });
    format!("{COLUMNS}\n{}", lines.collect::<String>())
}

/// Columns of the curves over frames.
const FRAME_COLUMNS: &str =
    "frame,method,spp,seconds,err,err_lowpass,mse,rel_mse,rel_mse_trimmed,flicker,energy_bias";

/// The curves over frames as comma-separated values.
pub fn frames_csv(frames: &[FrameRow]) -> String {
    let lines = frames.iter().map(|row| {
        let m = &row.measures;
        let errors = [m.err, m.err_lowpass, m.mse, m.rel_mse, m.rel_mse_trimmed, m.flicker, row.energy_bias];
        let numbers = [row.seconds].into_iter().chain(errors).map(cell).collect::<Vec<String>>();
        format!("{},{},{},{}\n", row.frame, row.method, row.spp, numbers.join(","))
    });
    format!("{FRAME_COLUMNS}\n{}", lines.collect::<String>())
}

fn cell(value: f64) -> String {
    if value.is_finite() { value.to_string() } else { String::new() }
}

/// The ratios, with what is needed to judge them.
pub fn ratios(report: &Report) -> String {
    let width = report.rows.iter().map(|row| row.method.len()).max().unwrap_or(0).max("method".len());
    let mut text = format!(
        "{:width$}  {:>5} {:>8} {:>10}   {:<26}   {:<26}  {:>6}   energy bias, 95 %\n",
        "", "", "", "", "uniform ÷ method, same spp", "at equal time", ""
    );
    let names = format!("{:>8}  {:>8} {:>7}", "Err", "low-pass", "relMSE");
    text += &format!(
        "{:width$}  {:>5} {:>8} {:>10}   {names}   {names}  {:>6}\n",
        "method", "spp", "seconds", "Err", "P-Eff"
    );
    for row in report.rows {
        let fits = |r: &&Ratio| r.method == row.method && r.spp == row.spp && r.seconds == row.seconds;
        let find = |list: &[Ratio]| list.iter().find(fits).cloned();
        let (same, time) = (find(&report.ratios.equal_spp), find(&report.ratios.equal_time));
        let flicker = match row.measures.flicker {
            flicker if flicker.is_nan() => String::new(),
            flicker => {
                let ratio = number(same.as_ref().map_or(f64::NAN, |ratio| ratio.measures.flicker));
                format!("   flicker {} ({ratio})", significant(flicker, 4))
            }
        };
        text += &format!(
            "{:width$}  {:>5} {:>8.3} {:>10}   {}   {}  {:>6}   {:+.3} % ± {}{flicker}\n",
            row.method,
            count(row.spp),
            row.seconds,
            significant(row.measures.err, 4),
            group(same.as_ref()),
            group(time.as_ref()),
            number(same.map_or(f64::NAN, |ratio| ratio.p_eff_gain)),
            100.0 * row.energy_bias,
            fixed(100.0 * row.energy_bias_ci95, 3),
        );
    }
    match report.reference.noise_source {
        Some(Source::Parts) => {}
        Some(Source::Variance) => {
            text += "± has the reference's noise by its variance layer: rather too wide\n"
        }
        None => text += "± is without the reference's own noise, which is unknown\n",
    }
    if let Some(ratio) = report.oracle_ratio {
        text += &format!("oracle ratio {ratio:.2}: what known variances would gain in Err at equal spp\n");
    }
    if let Some(ratio) = report.oracle_ratio_equal_rays {
        text += &format!("oracle ratio {ratio:.2} at equal rays, if what samples cost is known, too\n");
    }
    text
}

fn group(ratio: Option<&Ratio>) -> String {
    let values =
        ratio.map_or([f64::NAN; 3], |r| [r.measures.err, r.measures.err_lowpass, r.measures.rel_mse]);
    let [err, lowpass, relative] = values.map(number);
    format!("{err:>8}  {lowpass:>8} {relative:>7}")
}
