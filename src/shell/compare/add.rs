//! Adds pictures of other programs to a comparison.

use super::data::{Comparison, Row};
use super::other::Other;
use super::reference::noise::own_energy_stderr;
use super::spread::Spread;
use super::stage::Shot;
use super::stats::Measures;
use crate::error::Error;
use crate::picture::frame_io::Picture;
use crate::picture::metrics;

impl Comparison {
    /// Measures another program's picture of `shot` as a method's only run, and adds it as the last row.
    ///
    /// Where it has no layer `variance`, nothing tells how far its energy spreads.
    ///
    /// # Errors
    /// As [`metrics::measure`].
    pub fn add(&mut self, other: Other, picture: Picture, shot: &Shot) -> Result<(), Error> {
        self.rows.push(row(&other, &picture, shot)?);
        self.others.push(other);
        self.other_pictures.push(picture.rgb);
        Ok(())
    }
}

fn row(other: &Other, picture: &Picture, shot: &Shot) -> Result<Row, Error> {
    let metrics = metrics::measure(picture, shot.reference, f64::from(shot.scene.cd_per_unit))?;
    let own = picture.planes.contains_key("variance").then(|| own_energy_stderr(picture, shot.reference));
    let own = Spread::new(own.unwrap_or(f64::NAN), f64::INFINITY);
    let noise = shot.noise.map(|noise| noise.scaled(1.0 + metrics.energy_bias));
    let spread = Spread::sum([own].into_iter().chain(noise));
    Ok(Row {
        method: other.name.clone(),
        spp: None,
        iterations: None,
        estimator: None,
        seconds: other.seconds,
        measures: Measures::from(&metrics),
        p_eff: 1.0 / (other.seconds * metrics.err),
        energy_bias: metrics.energy_bias,
        energy_bias_stderr: spread.stderr,
        energy_bias_ci95: spread.ci95,
        runs: 1,
        stderr: None,
        seeds: Vec::new(),
    })
}
