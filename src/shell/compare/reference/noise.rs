//! What is known of a reference's own noise.
//!
//! A reference that was rendered here was rendered in [parts](super::parts) of independent seeds, and their spread tells
//! it. Of any other picture its `variance` plane tells: that takes samples as independent, and where they are stratified
//! they are better than that.

use super::super::spread::Spread;
use crate::picture::frame_io::Picture;
use crate::picture::metrics::{self, luminance};
use serde::Serialize;
use std::collections::BTreeMap;

/// Attributes with the number of parts, [`Noise::err`] and the standard error of the energy over the energy.
const ATTRIBUTES: [&str; 3] = ["parts", "noise_err", "noise_energy"];

/// What told the noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Source {
    /// The spread of parts that were rendered with seeds of their own.
    Parts,
    /// The `variance` plane, as if samples were independent: too much where they are stratified.
    Variance,
}

/// The noise of a reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// What it adds to every Err.
    pub err: f64,
    /// Standard error of the energy (sum of luminances) over the energy.
    pub energy: Spread,
    /// What told it.
    pub source: Source,
}

impl Noise {
    /// The noise of a picture; none if nothing tells it.
    pub fn of(picture: &Picture, cd_per_unit: f64) -> Option<Noise> {
        Noise::by_parts(&picture.attributes).or_else(|| Noise::by_variance(picture, cd_per_unit))
    }

    /// Keeps what `parts` parts have told.
    pub fn keep(&self, parts: usize, attributes: &mut BTreeMap<String, String>) {
        let values = [parts.to_string(), self.err.to_string(), self.energy.stderr.to_string()];
        attributes.extend(ATTRIBUTES.map(String::from).into_iter().zip(values));
    }

    fn by_parts(attributes: &BTreeMap<String, String>) -> Option<Noise> {
        let number =
            |name: &str| attributes.get(name)?.parse().ok().filter(|number: &f64| number.is_finite());
        let [parts, err, stderr] = ATTRIBUTES.map(number);
        let energy = Spread::new(stderr?, parts.filter(|parts| *parts >= 2.0)? - 1.0);
        Some(Noise { err: err?, energy, source: Source::Parts })
    }

    fn by_variance(picture: &Picture, cd_per_unit: f64) -> Option<Noise> {
        let counted = |count: &Vec<f32>| count.iter().any(|count| *count >= 2.0);
        let told = picture.planes.get("count").is_none_or(counted);
        let variance = picture.planes.get("variance").filter(|_| told)?;
        let variance: Vec<f64> = variance.iter().map(sane).collect();
        let energy = Spread::new(energy_stderr(&variance, picture), f64::INFINITY);
        Some(Noise { err: err(&variance, picture, cd_per_unit), energy, source: Source::Variance })
    }
}

/// Number of seeds that a picture has used, down from that in its attribute.
pub fn seeds(picture: &Picture) -> u32 {
    picture.attributes.get(ATTRIBUTES[0]).and_then(|parts| parts.parse().ok()).unwrap_or(1)
}

/// A variance as it can be; what it cannot be counts as nothing known, hence 0.
fn sane(value: &f32) -> f64 {
    if (0.0..=f32::MAX).contains(value) { f64::from(*value) } else { 0.0 }
}

/// Standard error of the energy of a picture whose pixels have these variances, over the energy of `reference`. Pixels count
/// as independent.
pub fn energy_stderr(variance: &[f64], reference: &Picture) -> f64 {
    variance.iter().sum::<f64>().sqrt() / reference.rgb.iter().map(|rgb| luminance(*rgb)).sum::<f64>()
}

/// The same of a picture's own `variance` plane; 0 if it has none.
pub fn own_energy_stderr(picture: &Picture, reference: &Picture) -> f64 {
    let variance = picture.planes.get("variance").into_iter().flatten();
    energy_stderr(&variance.map(sane).collect::<Vec<f64>>(), reference)
}

/// Mean of variance/tvi.
pub fn err(variance: &[f64], picture: &Picture, cd_per_unit: f64) -> f64 {
    let acuities = picture.rgb.iter().map(|rgb| metrics::acuity(luminance(*rgb), cd_per_unit));
    let weighted: f64 = variance.iter().zip(acuities).map(|(variance, acuity)| variance * acuity).sum();
    cd_per_unit * cd_per_unit * weighted / variance.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(planes: &[(&str, f32)], attributes: &[(&str, &str)]) -> Picture {
        Picture {
            width: 2,
            height: 2,
            rgb: vec![[0.5; 3]; 4],
            planes: planes.iter().map(|(name, value)| ((*name).into(), vec![*value; 4])).collect(),
            attributes: attributes.iter().map(|(name, value)| ((*name).into(), (*value).into())).collect(),
        }
    }

    #[test]
    fn parts_tell_more_than_a_plane_and_nothing_tells_nothing() {
        let told = |planes: &[(&str, f32)], attributes: &[(&str, &str)]| {
            Noise::of(&picture(planes, attributes), 100.0).map(|noise| (noise.source, noise.energy))
        };
        let parts = [("parts", "8"), ("noise_err", "0.5"), ("noise_energy", "0.25")];
        let by_parts = Some((Source::Parts, Spread::new(0.25, 7.0)));
        assert_eq!(told(&[("variance", 0.01)], &parts), by_parts);
        // Four pixels of luminance ½ and variance 0.01: √0.04/2.
        let (source, energy) = told(&[("variance", 0.01), ("count", 2.0)], &[("parts", "1")]).unwrap();
        assert_eq!(source, Source::Variance);
        assert!((energy.stderr - 0.1).abs() < 1e-6 && (energy.ci95 / energy.stderr - 1.96).abs() < 1e-4);
        assert_eq!(told(&[], &[]), None);
        assert_eq!(told(&[("variance", 0.0), ("count", 1.0)], &[]), None, "one sample has no variance");
    }
}
