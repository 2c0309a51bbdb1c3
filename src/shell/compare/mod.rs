//! Speed against error: every method at every sample count, many times, against one reference.
//!
//! A [`Plan`] names [`Variant`]s of the sampler, sample counts and a number of runs. [`run`] renders them all, the
//! methods taking turns within a sample count and the sample counts within a run, so that a machine that is busy
//! for a while hurts all methods alike. Each render has a seed of its own, and none that of the reference. What comes
//! out, a [`Comparison`], goes to disk as JSON, CSV and a page through [`mod@report`]; [`reference`](mod@reference)
//! keeps the reference from one comparison to the next.
//!
//! Seconds are wall time of the render, without loading the scene, measuring and writing; a row has the median of
//! its runs, and the mean of the errors. Errors are in the units of [`metrics`].
//!
//! Limits: errors contain the reference's own noise, which [`Reference`](reference::Reference) estimates, and every
//! method's last picture is kept, hence 24 bytes a pixel and method.

mod colour;
mod page;
mod pictures;
mod plot;
pub mod ratio;
pub mod reference;
pub mod report;
mod stats;
mod table;
mod variant;

pub use stats::Measures;
pub use variant::Variant;

use crate::error::Error;
use crate::frame_io::Picture;
use crate::metrics::{self, Metrics};
use crate::render::{self, Frame};
use crate::scene::LoadedScene;
use crate::settings::{Method, Settings, word};
use serde::Serialize;
use stats::{mean, median, standard_error};

/// What to render.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The methods; the first is the baseline of all ratios.
    pub variants: Vec<Variant>,
    /// Samples a pixel, rising.
    pub spp: Vec<u32>,
    /// Renders of each method at each sample count.
    pub runs: u32,
    /// Size, integrator, depth, camera and first seed of all renders; the rest is the variants' own.
    pub base: Settings,
    /// Threads, or all there are.
    pub threads: Option<usize>,
}

impl Plan {
    /// A plan that has the baseline, uniform sampling, first, and every method and sample count once.
    pub fn new(methods: &[Variant], spp: &[u32], runs: u32, base: Settings, threads: Option<usize>) -> Plan {
        let mut variants = vec![Variant::from(Method::Uniform)];
        for variant in methods {
            if !variants.contains(variant) {
                variants.push(variant.clone());
            }
        }
        let mut spp = spp.to_vec();
        spp.sort_unstable();
        spp.dedup();
        Plan { variants, spp, runs, base, threads }
    }

    /// Samples a pixel of all renders together.
    pub fn total_spp(&self) -> u64 {
        let once: u64 = self.spp.iter().map(|spp| u64::from(*spp)).sum();
        once * self.variants.len() as u64 * u64::from(self.runs) + self.warm_up_spp()
    }

    /// Samples a pixel of the render that is not counted.
    fn warm_up_spp(&self) -> u64 {
        self.spp.first().map_or(0, |spp| u64::from(*spp))
    }

    /// Seeds of the renders in their order: one each, and never the reference's.
    fn seeds(&self, reference: &Picture) -> impl Iterator<Item = u32> {
        let taken = reference.attributes.get("seed").and_then(|seed| seed.parse().ok());
        let first = self.base.sampler.seed;
        (0..=u32::MAX).map(move |k| first.wrapping_add(k)).filter(move |seed| Some(*seed) != taken)
    }
}

/// One method at one sample count.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Name of the variant.
    pub method: String,
    /// Samples a pixel.
    pub spp: u32,
    /// Rounds of sampling.
    pub iterations: u32,
    /// How samples became pixels.
    pub estimator: String,
    /// Median wall time of a render.
    pub seconds: f64,
    /// Means of the errors.
    #[serde(flatten)]
    pub measures: Measures,
    /// 1/(seconds·Err).
    pub p_eff: f64,
    /// Mean of Σe/Σref, luminance.
    pub energy_bias: f64,
    /// Its standard error: from the spread of the runs, or within the picture if there is one run.
    pub energy_bias_stderr: f64,
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

/// What a plan's renders have shown.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// By method, then by sample count.
    pub rows: Vec<Row>,
    /// One for each method.
    pub shown: Vec<Shown>,
    /// What an oracle would gain over uniform sampling in Err, if the reference has a `variance` plane.
    pub oracle_ratio: Option<f64>,
    /// Threads that worked.
    pub threads: usize,
}

/// The renders of one method at one sample count.
struct Cell<'a> {
    variant: &'a Variant,
    settings: Settings,
    seeds: Vec<u32>,
    seconds: Vec<f64>,
    metrics: Vec<Metrics>,
}

/// Renders everything in `plan` and measures it against `reference`; `progress` hears of samples just drawn.
///
/// # Errors
/// As [`render::render`] and [`metrics::measure`].
pub fn run(
    scene: &LoadedScene,
    plan: &Plan,
    reference: &Picture,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Comparison, Error> {
    let mut cells: Vec<Cell> = plan
        .spp
        .iter()
        .flat_map(|spp| plan.variants.iter().map(|variant| Cell::new(scene, plan, variant, *spp)))
        .collect();
    if let Some(cell) = cells.first() {
        // The first render pays for caches, page tables and clock speed: nobody's time.
        render::render(scene, &cell.settings, plan.threads, progress)?;
    }
    let mut seeds = plan.seeds(reference);
    let mut shown = Vec::new();
    for run in 0..plan.runs {
        for cell in &mut cells {
            let frame = cell.render(scene, plan, reference, &mut seeds, progress)?;
            if run == 0 && Some(&cell.settings.spp) == plan.spp.last() {
                shown.push(Shown { method: cell.variant.to_string(), settings: cell.settings, frame });
            }
        }
    }
    let oracle_ratio =
        cells.first().and_then(|cell| cell.metrics.first()).and_then(|metrics| metrics.oracle_ratio);
    let by_method =
        plan.variants.iter().flat_map(|variant| cells.iter().filter(move |cell| cell.variant == variant));
    Ok(Comparison {
        rows: by_method.map(Cell::row).collect(),
        threads: shown.first().map_or(0, |shown| shown.frame.threads),
        shown,
        oracle_ratio,
    })
}

impl<'a> Cell<'a> {
    fn new(scene: &LoadedScene, plan: &Plan, variant: &'a Variant, spp: u32) -> Cell<'a> {
        let settings = variant.settings(scene, &plan.base, spp);
        Cell { variant, settings, seeds: vec![], seconds: vec![], metrics: vec![] }
    }

    /// One more render with the next seed.
    fn render(
        &mut self,
        scene: &LoadedScene,
        plan: &Plan,
        reference: &Picture,
        seeds: &mut impl Iterator<Item = u32>,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Frame, Error> {
        let seed = seeds.next().ok_or_else(|| Error::Setting("more renders than seeds".into()))?;
        self.settings.sampler.seed = seed;
        let frame = render::render(scene, &self.settings, plan.threads, progress)?;
        let picture = frame.picture(&self.settings, scene);
        self.metrics.push(metrics::measure(&picture, reference, f64::from(scene.cd_per_unit))?);
        self.seconds.push(frame.seconds);
        self.seeds.push(seed);
        Ok(frame)
    }

    fn row(&self) -> Row {
        let measures: Vec<Measures> = self.metrics.iter().map(Measures::from).collect();
        let biases: Vec<f64> = self.metrics.iter().map(|metrics| metrics.energy_bias).collect();
        let within = self.metrics.first().map_or(f64::NAN, |metrics| metrics.energy_bias_stderr);
        let (seconds, measures, stderr) =
            (median(&self.seconds), Measures::means(&measures), Measures::standard_errors(&measures));
        Row {
            method: self.variant.to_string(),
            spp: self.settings.spp,
            iterations: self.settings.iterations,
            estimator: word(self.settings.sampler.estimator),
            seconds,
            measures,
            p_eff: 1.0 / (seconds * measures.err),
            energy_bias: mean(&biases),
            energy_bias_stderr: standard_error(&biases).unwrap_or(within),
            runs: self.metrics.len() as u32,
            stderr,
            seeds: self.seeds.clone(),
        }
    }
}
