//! Renders what a plan asks for, and measures it.

use super::data::{Comparison, FrameRow, Row, Shown};
use super::plan::Plan;
use super::reference;
use super::spread::Spread;
use super::stage::{Shot, Stage};
use super::stats::{Measures, mean, median};
use super::variant::Variant;
use crate::animation::startup::Predictor;
use crate::error::Error;
use crate::frame::cost;
use crate::frame::render::{self, Frame};
use crate::frame::settings::{Settings, word};
use crate::picture::frame_io::Picture;
use crate::picture::metrics::{self, Errors};
use pmcip_core::sampler::Tally;

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
    let (mut shown, mut oracle_ratio_equal_rays, mut tally) = (Vec::new(), None, Tally::default());
    for run in 0..plan.runs {
        for frame in frames.clone() {
            let shot = stage.show(frame)?;
            let first = run == 0 && frame == *frames.start();
            if let Some(cell) = cells.first().filter(|_| first) {
                // The first render pays for caches, page tables and clock speed: nobody's time.
                let settings = cell.variant.settings(shot.scene, &shot.base, cell.spp);
                render::render(shot.scene, &settings, plan.threads, progress)?;
                let cost = cost::rays(shot.scene, &settings, plan.threads)?;
                let cd = f64::from(shot.scene.cd_per_unit);
                oracle_ratio_equal_rays = cost.and_then(|cost| metrics::oracle_of(shot.reference, &cost, cd));
            }
            if frame == *frames.start() {
                begin_run(&mut cells, plan, shot.reference, run)?;
            }
            for cell in &mut cells {
                let frame = cell.render(&shot, frame, plan, progress)?;
                tally += frame.tally;
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
        others: Vec::new(),
        other_pictures: Vec::new(),
        threads: shown.first().map_or(0, |shown| shown.frame.threads),
        shown,
        oracle_ratio,
        oracle_ratio_equal_rays,
        tally,
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
            spp: Some(self.spp),
            iterations: Some(self.settings.iterations),
            estimator: Some(word(self.settings.sampler.estimator)),
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
