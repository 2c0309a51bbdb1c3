//! What a comparison has shown: rows, curves, pictures.

use super::other::Other;
use super::stats::Measures;
use crate::frame::render::Frame;
use crate::frame::settings::Settings;
use pmcip_core::sampler::Tally;
use serde::Serialize;

/// One method at one sample count.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Name of the variant, or of what made another program's picture.
    pub method: String,
    /// Samples a pixel; none of another program's picture.
    pub spp: Option<u32>,
    /// Rounds of sampling, likewise.
    pub iterations: Option<u32>,
    /// How samples became pixels, likewise.
    pub estimator: Option<String>,
    /// Median wall time of a render.
    pub seconds: f64,
    /// Means of the errors.
    #[serde(flatten)]
    pub measures: Measures,
    /// 1/(seconds·Err).
    pub p_eff: f64,
    /// Mean of Σe/Σref, luminance.
    pub energy_bias: f64,
    /// Its standard error: from the spread of the runs, or within the picture if there is one run, and the reference's
    /// own, if anything tells that. Not a number of another program's picture without variance.
    pub energy_bias_stderr: f64,
    /// Half the width of an interval that contains the truth in at least 95 % of all cases, by Student's t.
    pub energy_bias_ci95: f64,
    /// Number of renders.
    pub runs: u32,
    /// Standard errors of the means, if there are two runs or more.
    pub stderr: Option<Measures>,
    /// Seeds of the renders.
    pub seeds: Vec<u32>,
}

/// A method's picture, from the first run at the largest sample count.
#[derive(Clone, Debug)]
pub struct Shown {
    /// Name of the variant.
    pub method: String,
    /// How it was made.
    pub settings: Settings,
    /// The picture.
    pub frame: Frame,
}

/// One method at one sample count in one frame of a sequence: means over the runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameRow {
    /// The frame.
    pub frame: u32,
    /// Name of the variant.
    pub method: String,
    /// Samples a pixel.
    pub spp: u32,
    /// Median wall time of the render.
    pub seconds: f64,
    /// The errors; of the first frame there is no flicker.
    #[serde(flatten)]
    pub measures: Measures,
    /// Σe/Σref, luminance.
    pub energy_bias: f64,
}

/// What a plan's renders have shown.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// By method, then by sample count; then those of other programs' pictures.
    pub rows: Vec<Row>,
    /// By method, then by sample count, then by frame; empty for a still picture.
    pub frames: Vec<FrameRow>,
    /// One for each method, of the first frame.
    pub shown: Vec<Shown>,
    /// Pictures of other programs, those of one name in a row.
    pub others: Vec<Other>,
    /// Their pixels, in the same order.
    pub other_pictures: Vec<Vec<[f32; 3]>>,
    /// What an oracle would gain over uniform sampling in Err in the first frame, if the reference has a `variance`
    /// plane.
    pub oracle_ratio: Option<f64>,
    /// The same at equal rays: of an oracle that knows what samples cost, too. None with photon maps.
    pub oracle_ratio_equal_rays: Option<f64>,
    /// Threads that worked.
    pub threads: usize,
    /// Samples of all renders, accepted and rejected.
    pub tally: Tally,
}
