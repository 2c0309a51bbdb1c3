//! Means and spreads over runs, and curves between measured points.

use crate::picture::metrics::Metrics;
use serde::Serialize;

/// The errors that methods are compared by, as [`Metrics`] defines them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Measures {
    /// Mean of e²/tvi.
    pub err: f64,
    /// The same after an 8×8 box average.
    pub err_lowpass: f64,
    /// Mean of e².
    pub mse: f64,
    /// Mean of e²/(ref² + 0.01).
    pub rel_mse: f64,
    /// The same without the worst 0.1 % of pixels.
    pub rel_mse_trimmed: f64,
    /// Mean of (e_t − e_{t−1})²/tvi over the frames of a sequence but the first; not a number elsewhere.
    #[serde(skip_serializing_if = "is_unknown")]
    pub flicker: f64,
}

fn is_unknown(value: &f64) -> bool {
    value.is_nan()
}

impl From<&Metrics> for Measures {
    fn from(metrics: &Metrics) -> Measures {
        let Metrics { err, err_lowpass, mse, rel_mse, rel_mse_trimmed, .. } = *metrics;
        Measures { err, err_lowpass, mse, rel_mse, rel_mse_trimmed, flicker: f64::NAN }
    }
}

impl Measures {
    /// Each of them computed from its number.
    pub fn build(mut value: impl FnMut(fn(&Measures) -> f64) -> f64) -> Measures {
        Measures {
            err: value(|m| m.err),
            err_lowpass: value(|m| m.err_lowpass),
            mse: value(|m| m.mse),
            rel_mse: value(|m| m.rel_mse),
            rel_mse_trimmed: value(|m| m.rel_mse_trimmed),
            flicker: value(|m| m.flicker),
        }
    }

    /// Means over runs.
    pub fn means(runs: &[Measures]) -> Measures {
        Measures::build(|of| mean(&runs.iter().map(of).collect::<Vec<f64>>()))
    }

    /// Standard errors of the means, if there are two runs or more.
    pub fn standard_errors(runs: &[Measures]) -> Option<Measures> {
        let error = |of| standard_error(&runs.iter().map(of).collect::<Vec<f64>>());
        (runs.len() > 1).then(|| Measures::build(|of| error(of).unwrap_or(f64::NAN)))
    }
}

/// Not a number for no values.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Standard error of the mean, if there are two values or more.
pub fn standard_error(values: &[f64]) -> Option<f64> {
    let (count, centre) = (values.len() as f64, mean(values));
    let squares: f64 = values.iter().map(|value| (value - centre).powi(2)).sum();
    (values.len() > 1).then(|| (squares / (count * (count - 1.0))).sqrt())
}

/// The middle value, or the mean of the middle two; not a number for no values.
pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    match sorted.len() {
        0 => f64::NAN,
        length if length % 2 == 1 => sorted[middle],
        _ => 0.5 * (sorted[middle - 1] + sorted[middle]),
    }
}

/// How far beyond the measured points a curve is followed, as a factor.
const REACH: f64 = 2.0;

/// The curve through `points` at `x`, straight between them in logarithms; beyond them as steep as at its end, up to
/// a factor of two. A single point falls as 1/x, the law of independent samples.
pub fn interpolate(points: &[(f64, f64)], x: f64) -> Option<f64> {
    let mut logs: Vec<(f64, f64)> = points
        .iter()
        .filter(|(x, y)| *x > 0.0 && *y > 0.0 && x.is_finite() && y.is_finite())
        .map(|(x, y)| (x.ln(), y.ln()))
        .collect();
    logs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let (first, last, x) = (*logs.first()?, *logs.last()?, x.ln());
    if !(first.0 - REACH.ln() <= x && x <= last.0 + REACH.ln()) {
        return None;
    }
    let right = logs.partition_point(|point| point.0 < x).clamp(1, (logs.len() - 1).max(1));
    let (a, b) = (logs[right - 1], logs.get(right).copied().unwrap_or(first));
    let slope = if b.0 > a.0 { (b.1 - a.1) / (b.0 - a.0) } else { -1.0 };
    Some((a.1 + slope * (x - a.0)).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spreads_are_those_of_the_textbook() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), 2.5);
        assert!(median(&[]).is_nan());
        assert_eq!(standard_error(&[1.0]), None);
        assert!((standard_error(&[1.0, 2.0, 3.0]).unwrap() - (1.0_f64 / 3.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn power_laws_are_met_between_and_a_little_beyond_the_points() {
        let law = |x: f64| 5.0 * x.powf(-1.3);
        let points: Vec<(f64, f64)> = [8.0, 1.0, 2.0].map(|x| (x, law(x))).into();
        for x in [0.6, 1.0, 1.5, 2.0, 5.0, 8.0, 15.0] {
            assert!((interpolate(&points, x).unwrap() / law(x) - 1.0).abs() < 1e-12, "{x}");
        }
        assert_eq!((interpolate(&points, 0.4), interpolate(&points, 17.0)), (None, None));
        assert!((interpolate(&[(2.0, 6.0)], 3.0).unwrap() - 4.0).abs() < 1e-12);
        assert_eq!(interpolate(&[], 1.0), None);
        assert_eq!(interpolate(&[(1.0, 0.0), (0.0, 1.0)], 1.0), None);
    }
}
