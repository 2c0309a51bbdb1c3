//! A comparison on disk: `report.json`, `report.csv` and `report.html` in one folder, and `frames.csv` of a sequence.
//!
//! Each file is either complete or not there. The page needs no other file and no network.

use super::data::{Comparison, FrameRow, Row};
use super::other::Other;
use super::plan::Plan;
use super::ratio::Ratios;
use super::reference::Reference;
use crate::scene::LoadedScene;
use serde::Serialize;
use serde_json::{Map, Value};
use std::path::Path;

/// Names of the files in the report's folder.
pub const FILES: [&str; 3] = ["report.json", "report.csv", "report.html"];

/// The machine that was measured on.
#[derive(Clone, Debug, Serialize)]
pub struct Machine {
    /// The processor's name, or its family where the system does not tell.
    pub cpu: String,
    /// Threads that the processor offers.
    pub cpu_threads: usize,
    /// Threads that rendered.
    pub threads: usize,
    /// The operating system.
    pub system: &'static str,
}

/// What made the report.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Versions {
    /// This program.
    pub pmcip: &'static str,
    /// This layout of the report.
    pub report: u32,
}

/// Everything a report says; as JSON it is `report.json`, as text the table of ratios.
#[derive(Clone, Debug, Serialize)]
pub struct Report<'a> {
    /// The scene's name.
    pub scene: &'a str,
    /// Its file.
    pub scene_file: &'a Path,
    /// What is the same in all renders.
    pub settings: Map<String, Value>,
    /// What differs between methods, at the largest sample count.
    pub methods: Map<String, Value>,
    /// Renders of each method at each sample count.
    pub runs: u32,
    /// First seed.
    pub seed: u32,
    /// What was measured against.
    pub reference: &'a Reference,
    /// The machine.
    pub machine: Machine,
    /// What made this.
    pub versions: Versions,
    /// What an oracle would gain over uniform sampling in Err at equal samples.
    pub oracle_ratio: Option<f64>,
    /// The same at equal rays.
    pub oracle_ratio_equal_rays: Option<f64>,
    /// One a method and sample count.
    pub rows: &'a [Row],
    /// Curves over frames: one a method, sample count and frame; empty for a still picture.
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    pub frames: &'a [FrameRow],
    /// Pictures of other programs, whose rows have no samples.
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    pub others: &'a [Other],
    /// Uniform over method.
    pub ratios: Ratios,
    /// What the loader of the scene had to guess.
    pub warnings: &'a [String],
    #[serde(skip)]
    pub(super) comparison: &'a Comparison,
    #[serde(skip)]
    pub(super) cd_per_unit: f64,
}

impl<'a> Report<'a> {
    /// Collects the facts.
    pub fn new(
        scene: &'a LoadedScene,
        plan: &Plan,
        reference: &'a Reference,
        comparison: &'a Comparison,
    ) -> Report<'a> {
        let (settings, methods) = settings(comparison);
        Report {
            scene: &scene.name,
            scene_file: &scene.path,
            settings,
            methods,
            runs: plan.runs,
            seed: plan.base.sampler.seed,
            reference,
            machine: machine(comparison.threads),
            versions: Versions { pmcip: env!("CARGO_PKG_VERSION"), report: 1 },
            oracle_ratio: comparison.oracle_ratio,
            oracle_ratio_equal_rays: comparison.oracle_ratio_equal_rays,
            rows: &comparison.rows,
            frames: &comparison.frames,
            others: &comparison.others,
            ratios: Ratios::new(comparison),
            warnings: &scene.warnings,
            comparison,
            cd_per_unit: f64::from(scene.cd_per_unit),
        }
    }
}

/// The settings that all methods share, and for each method those that it does not.
fn settings(comparison: &Comparison) -> (Map<String, Value>, Map<String, Value>) {
    let mut lists: Vec<(String, Map<String, Value>)> =
        comparison.shown.iter().map(|shown| (shown.method.clone(), shown.settings.list())).collect();
    for (_, list) in &mut lists {
        // These belong to a row, not to a method.
        list.retain(|name, _| name != "seed" && name != "spp");
    }
    let first = lists.first().map(|(_, list)| list.clone()).unwrap_or_default();
    let (common, _): (Map<_, _>, Map<_, _>) = first
        .into_iter()
        .partition(|(name, value)| lists.iter().all(|(_, list)| list.get(name) == Some(value)));
    let own = lists.into_iter().map(|(method, mut list)| {
        list.retain(|name, _| !common.contains_key(name));
        (method, Value::Object(list))
    });
    let own = own.collect();
    (common, own)
}

/// What the system tells about itself.
fn machine(threads: usize) -> Machine {
    let facts = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = facts.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    let cpu = name.map_or(std::env::consts::ARCH, |(_, name)| name.trim());
    Machine {
        cpu: cpu.into(),
        cpu_threads: std::thread::available_parallelism().map_or(0, usize::from),
        threads,
        system: std::env::consts::OS,
    }
}
