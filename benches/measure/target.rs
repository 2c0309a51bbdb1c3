//! Is the Err that a frame stops by the true one? Estimates against references, and what stopping does to a frame.
//!
//! `cargo run --release -p measure -- target [RUNS [SIDE [REFERENCE_SPP]]]` prints Markdown tables.

use crate::study::Study;
use pmcip::frame::schedule::Target;
use pmcip::frame::settings::{Method, Settings};

/// Samples a pixel at which estimates are compared.
const SPP: [u32; 4] = [8, 16, 32, 64];
/// Most samples a pixel of a frame that stops.
const MOST: u32 = 512;

/// Prints the table.
pub fn run(arguments: &[String]) {
    let mut arguments = arguments.iter().map(|a| a.parse::<u32>().expect("a whole number"));
    let runs = arguments.next().unwrap_or(32);
    let side = arguments.next().unwrap_or(64);
    let reference_spp = arguments.next().unwrap_or(8192);
    for name in ["cornell", "caustic"] {
        let study = Study::new(name, side, reference_spp);
        for method in [Method::Uniform, Method::Pmc] {
            table(name, &study, method, runs);
        }
    }
}

fn table(name: &str, study: &Study, method: Method, runs: u32) {
    println!("\n{name}, {method}, {runs} runs\n");
    println!("| samples a pixel | Err | estimated ÷ true | spread of one estimate | energy bias |");
    println!("| --- | --- | --- | --- | --- |");
    let row = |settings: &Settings, label: &dyn Fn(f64) -> String| {
        let outcome = study.run(settings, runs);
        let (err, (bias, error)) = (outcome.err, outcome.bias);
        let (mean, spread) = (outcome.estimate.0 / err, 100.0 * outcome.estimate.1 / outcome.estimate.0);
        let (bias, error) = (100.0 * bias, 100.0 * error);
        let label = label(outcome.spp);
        println!("| {label} | {err:.3} | {mean:.2} | {spread:.0} % | {bias:+.2} % ± {error:.2} |");
        err
    };
    let mut aims = Vec::new();
    for spp in SPP {
        // No estimate is below 0, so nothing stops.
        let settings = aimed(study, method, spp, f32::MIN_POSITIVE);
        aims.push(row(&settings, &|_| spp.to_string()));
    }
    for aim in &aims[1..] {
        let settings = aimed(study, method, MOST, *aim as f32);
        row(&settings, &|spp| format!("stopped below {aim:.3}: {spp:.1}"));
    }
}

fn aimed(study: &Study, method: Method, spp: u32, err: f32) -> Settings {
    Settings { target: Some(Target { err, expected_spp: None }), ..study.settings(method, spp) }
}
