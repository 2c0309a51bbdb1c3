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
//! What is rendered, a [`Stage`], is a still picture or the frames of an animation. Of frames there are curves and one
//! measure more, flicker; a row then has the means over all frames.
//!
//! The energy bias has a standard error that contains the spread of the runs and the reference's own noise, as far as
//! anything tells that ([`reference::noise`]), and an interval of at least 95 % by Student's t: three runs know their spread so badly
//! that two standard errors would miss the truth in one case of five. With a single run the `variance` plane of its
//! picture stands for the spread of runs: that takes samples and pixels as independent, and its error as known.
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
pub mod spread;
mod stage;
mod stats;
mod table;
mod variant;

pub use stage::{Moving, Shot, Stage, Still};
pub use stats::Measures;
pub use variant::Variant;

use crate::animation::startup::Predictor;
use crate::error::Error;
use crate::frame::render::{self, Frame};
use crate::frame::settings::{Method, Settings, word};
use crate::picture::frame_io::Picture;
use crate::picture::metrics::{self, Errors};
use serde::Serialize;
use spread::Spread;
use stats::{mean, median};

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

    /// Samples a pixel of all renders of so many frames together.
    pub fn total_spp(&self, frames: usize) -> u64 {
        let once: u64 = self.spp.iter().map(|spp| u64::from(*spp)).sum();
        once * self.variants.len() as u64 * u64::from(self.runs) * frames as u64 + self.warm_up_spp()
    }

    /// Samples a pixel of the render that is not counted.
    fn warm_up_spp(&self) -> u64 {
        self.spp.first().map_or(0, |spp| u64::from(*spp))
    }

    /// Seeds of the renders in their order: one each, and never the reference's.
    fn seeds(&self, reference: &Picture) -> impl Iterator<Item = u32> + use<> {
        let taken = reference::seeds(reference);
        let free = move |seed: &u32| taken.as_ref().is_none_or(|taken| !taken.contains(seed));
        let first = self.base.sampler.seed;
        (0..=u32::MAX).map(move |k| first.wrapping_add(k)).filter(free)
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
    /// Its standard error: from the spread of the runs, or within the picture if there is one run, and the reference's
    /// own, if anything tells that.
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
    /// By method, then by sample count.
    pub rows: Vec<Row>,
    /// By method, then by sample count, then by frame; empty for a still picture.
    pub frames: Vec<FrameRow>,
    /// One for each method, of the first frame.
    pub shown: Vec<Shown>,
    /// What an oracle would gain over uniform sampling in Err in the first frame, if the reference has a `variance`
    /// plane.
    pub oracle_ratio: Option<f64>,
    /// Threads that worked.
    pub threads: usize,
}

/// What one render has shown.
#[derive(Clone, Copy, Debug)]
struct Outcome {
    frame: u32,
    seconds: f64,
    measures: Measures,
    energy_bias: f64,
    /// Standard error of the energy bias by the picture's variance alone.
    own_stderr: f64,
    /// Standard error of the reference's energy over the energy.
    noise: Option<Spread>,
    oracle_ratio: Option<f64>,
}

/// The renders of one method at one sample count.
struct Cell<'a> {
    variant: &'a Variant,
    spp: u32,
    /// Of the last render.
    settings: Settings,
    /// One a run.
    seeds: Vec<u32>,
    /// Frames of each run.
    runs: Vec<Vec<Outcome>>,
    /// Errors of the frame before.
    before: Option<Errors>,
    /// What the frames before have told.
    predictor: Predictor,
}

/// Renders everything in `plan` and measures it; `progress` hears of samples just drawn.
///
/// # Errors
/// As [`render::render`], [`metrics::measure`] and [`Stage::show`].
pub fn run(stage: &mut dyn Stage, plan: &Plan, progress: &(dyn Fn(u64) + Sync)) -> Result<Comparison, Error> {
    let mut cells: Vec<Cell> = plan
        .spp
        .iter()
        .flat_map(|spp| plan.variants.iter().map(|variant| Cell::new(plan, variant, *spp)))
        .collect();
    let frames = stage.frames();
    let mut shown = Vec::new();
    for run in 0..plan.runs {
        for frame in frames.clone() {
            let shot = stage.show(frame)?;
            let first = run == 0 && frame == *frames.start();
            if let Some(cell) = cells.first().filter(|_| first) {
                // The first render pays for caches, page tables and clock speed: nobody's time.
                let settings = cell.variant.settings(shot.scene, &shot.base, cell.spp);
                render::render(shot.scene, &settings, plan.threads, progress)?;
            }
            if frame == *frames.start() {
                begin_run(&mut cells, plan, shot.reference, run)?;
            }
            for cell in &mut cells {
                let frame = cell.render(&shot, frame, plan, progress)?;
                if first && Some(&cell.spp) == plan.spp.last() {
                    shown.push(Shown { method: cell.variant.to_string(), settings: cell.settings, frame });
                }
            }
        }
    }
    let outcome = cells.first().and_then(|cell| cell.runs.first()?.first());
    let oracle_ratio = outcome.and_then(|outcome| outcome.oracle_ratio);
    let by_method: Vec<&Cell> = plan
        .variants
        .iter()
        .flat_map(|variant| cells.iter().filter(move |cell| cell.variant == variant))
        .collect();
    let curves = || by_method.iter().flat_map(|cell| cell.curve()).collect();
    Ok(Comparison {
        rows: by_method.iter().map(|cell| cell.row()).collect(),
        frames: if stage.is_sequence() { curves() } else { Vec::new() },
        threads: shown.first().map_or(0, |shown| shown.frame.threads),
        shown,
        oracle_ratio,
    })
}

/// Gives every cell its seed of the run and a clean slate.
fn begin_run(cells: &mut [Cell], plan: &Plan, reference: &Picture, run: u32) -> Result<(), Error> {
    let mut seeds = plan.seeds(reference).skip(run as usize * cells.len());
    for cell in cells {
        let seed = seeds.next().ok_or_else(|| Error::Setting("more renders than seeds".into()))?;
        cell.seeds.push(seed);
        cell.runs.push(Vec::new());
        cell.before = None;
        cell.predictor.forget();
    }
    Ok(())
}

impl<'a> Cell<'a> {
    fn new(plan: &Plan, variant: &'a Variant, spp: u32) -> Cell<'a> {
        let predictor = Predictor::default();
        Cell { variant, spp, settings: plan.base, seeds: vec![], runs: vec![], before: None, predictor }
    }

    /// Renders and measures one frame of the run that was begun last.
    fn render(
        &mut self,
        shot: &Shot,
        frame: u32,
        plan: &Plan,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Frame, Error> {
        let scene = shot.scene;
        self.settings = self.variant.settings(scene, &shot.base, self.spp);
        self.settings.sampler.seed = self.seeds.last().copied().unwrap_or_default();
        self.settings.sampler.frame = shot.base.sampler.frame;
        let predictor = &mut self.predictor;
        let done = render::render_next(scene, &self.settings, plan.threads, progress, predictor)?;
        let (picture, cd) = (done.picture(&self.settings, scene), f64::from(scene.cd_per_unit));
        let metrics = metrics::measure(&picture, shot.reference, cd)?;
        let errors = Errors::new(&picture, shot.reference)?;
        let flicker = |before: &Errors| metrics::flicker(before, &errors, cd);
        let flicker = self.before.as_ref().map_or(f64::NAN, flicker);
        self.before = Some(errors);
        let outcome = Outcome {
            frame,
            seconds: done.seconds,
            measures: Measures { flicker, ..Measures::from(&metrics) },
            energy_bias: metrics.energy_bias,
            own_stderr: reference::noise::own_energy_stderr(&picture, shot.reference),
            noise: shot.noise,
            oracle_ratio: metrics.oracle_ratio,
        };
        self.runs.last_mut().into_iter().for_each(|run| run.push(outcome));
        Ok(done)
    }

    fn row(&self) -> Row {
        let runs: Vec<Measures> = self.runs.iter().map(|run| over_frames(run)).collect();
        let of_runs = |of: fn(&Outcome) -> f64| -> Vec<f64> {
            self.runs.iter().map(|run| mean(&run.iter().map(of).collect::<Vec<f64>>())).collect()
        };
        let biases = of_runs(|outcome| outcome.energy_bias);
        let (seconds, measures, stderr) = (
            median(&of_runs(|outcome| outcome.seconds)),
            Measures::means(&runs),
            Measures::standard_errors(&runs),
        );
        let spread = Spread::sum([self.own_spread(&biases), self.reference_spread(&biases)]);
        Row {
            method: self.variant.to_string(),
            spp: self.spp,
            iterations: self.settings.iterations,
            estimator: word(self.settings.sampler.estimator),
            seconds,
            measures,
            p_eff: 1.0 / (seconds * measures.err),
            energy_bias: mean(&biases),
            energy_bias_stderr: spread.stderr,
            energy_bias_ci95: spread.ci95,
            runs: self.runs.len() as u32,
            stderr,
            seeds: self.seeds.clone(),
        }
    }

    /// Spread of the mean energy bias that the renders themselves have: between runs, or within the pictures of the only
    /// run.
    fn own_spread(&self, biases: &[f64]) -> Spread {
        let pictures = || self.runs.iter().flatten();
        let share = 1.0 / pictures().count() as f64;
        let of = |outcome: &Outcome| Spread::new(share * outcome.own_stderr, f64::INFINITY);
        Spread::of_mean(biases).unwrap_or_else(|| Spread::sum(pictures().map(of)))
    }

    /// What the references add, which all runs share: one a frame, each with seeds of its own.
    fn reference_spread(&self, biases: &[f64]) -> Spread {
        let frames = self.runs.first().map_or(&[][..], Vec::as_slice);
        let share = (1.0 + mean(biases)) / frames.len() as f64;
        Spread::sum(frames.iter().filter_map(|outcome| outcome.noise).map(|noise| noise.scaled(share)))
    }

    /// What each frame has shown.
    fn curve(&self) -> Vec<FrameRow> {
        let frames = self.runs.first().map_or(0, Vec::len);
        let row = |i: usize| {
            let all: Vec<&Outcome> = self.runs.iter().map(|run| &run[i]).collect();
            let numbers =
                |of: fn(&Outcome) -> f64| all.iter().map(|outcome| of(outcome)).collect::<Vec<f64>>();
            FrameRow {
                frame: all[0].frame,
                method: self.variant.to_string(),
                spp: self.spp,
                seconds: median(&numbers(|outcome| outcome.seconds)),
                measures: Measures::means(&all.iter().map(|outcome| outcome.measures).collect::<Vec<_>>()),
                energy_bias: mean(&numbers(|outcome| outcome.energy_bias)),
            }
        };
        (0..frames).map(row).collect()
    }
}

/// Means over the frames of a run; flicker over those that have one before them.
fn over_frames(run: &[Outcome]) -> Measures {
    let all: Vec<Measures> = run.iter().map(|outcome| outcome.measures).collect();
    let flicker: Vec<f64> = all.iter().map(|measures| measures.flicker).filter(|f| !f.is_nan()).collect();
    Measures { flicker: mean(&flicker), ..Measures::means(&all) }
}
