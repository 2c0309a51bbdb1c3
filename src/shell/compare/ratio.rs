//! How many times less error than uniform sampling, for the same samples and for the same time.
//!
//! At equal time the baseline's error is read off its curve over seconds, straight between the measured points in
//! logarithms and followed up to a factor of two beyond them. With a single sample count the curve is taken to fall
//! as 1/seconds. Where the curve says nothing the ratio is not a number, `null` in JSON; nor are the ratios at equal samples
//! of another program's picture.

use super::data::{Comparison, Row};
use super::stats::{Measures, interpolate};
use serde::Serialize;

/// The baseline's error over that of a method: above 1 the method is better.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ratio {
    /// Name of the variant.
    pub method: String,
    /// Samples a pixel of the method; none of another program's picture.
    pub spp: Option<u32>,
    /// Median wall time of the method.
    pub seconds: f64,
    /// The ratios.
    #[serde(flatten)]
    pub measures: Measures,
    /// Their standard errors, if there are two runs or more.
    pub stderr: Option<Measures>,
    /// P-Eff of the method over that of the baseline at equal samples.
    pub p_eff_gain: f64,
}

/// All ratios, by method and sample count.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ratios {
    /// For the same samples a pixel.
    pub equal_spp: Vec<Ratio>,
    /// For the same seconds.
    pub equal_time: Vec<Ratio>,
}

impl Ratios {
    /// Compares every other method with the first one.
    pub fn new(comparison: &Comparison) -> Ratios {
        let rows = &comparison.rows;
        let (baseline, others): (Vec<&Row>, Vec<&Row>) =
            rows.iter().partition(|row| row.method == rows[0].method);
        let both = others.into_iter().filter_map(|row| {
            let same = baseline.iter().copied().find(|other| other.spp == row.spp);
            let comparable = same.is_some() || row.spp.is_none();
            comparable.then(|| {
                (
                    ratio(row, same, |of| same.map_or(f64::NAN, |same| of(&same.measures))),
                    ratio(row, same, |of| at_time(&baseline, row, of)),
                )
            })
        });
        let (equal_spp, equal_time) = both.unzip();
        Ratios { equal_spp, equal_time }
    }
}

/// The baseline's error by its curve, at the time that `row` takes.
fn at_time(baseline: &[&Row], row: &Row, of: fn(&Measures) -> f64) -> f64 {
    let curve: Vec<(f64, f64)> = baseline.iter().map(|row| (row.seconds, of(&row.measures))).collect();
    interpolate(&curve, row.seconds).unwrap_or(f64::NAN)
}

/// The ratio of `error` to that of `row`; `same` is the baseline at the same samples, whose relative spread counts.
fn ratio(row: &Row, same: Option<&Row>, error: impl Fn(fn(&Measures) -> f64) -> f64) -> Ratio {
    let measures = Measures::build(|of| error(of) / of(&row.measures));
    let spreads = row.stderr.zip(same.and_then(|same| Some((same.stderr?, same.measures))));
    let stderr = spreads.map(|(own, (other, same))| {
        Measures::build(|of| {
            let parts = (of(&own) / of(&row.measures)).hypot(of(&other) / of(&same));
            of(&measures) * parts
        })
    });
    Ratio {
        method: row.method.clone(),
        spp: row.spp,
        seconds: row.seconds,
        measures,
        stderr,
        p_eff_gain: same.map_or(f64::NAN, |same| row.p_eff / same.p_eff),
    }
}
