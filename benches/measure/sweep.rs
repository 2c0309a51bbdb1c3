//! How the defaults were chosen: every setting varied by itself, on both scenes, as error of uniform sampling
//! over that of the setting.
//!
//! `cargo run --release -p measure -- sweep [RUNS [SIDE [REFERENCE_SPP [SPP…]]]]` prints Markdown tables.

use crate::study::Study;
use pmcip::frame::settings::{Method, Settings};
use pmcip_core::sampler::Sequence;
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::kernel::{Criterion, Window};

/// A change to the default settings, by name.
type Variant = (String, Box<dyn Fn(&mut Settings)>);

fn variants(spp: u32) -> Vec<Variant> {
    let mut all: Vec<Variant> = vec![("defaults".into(), Box::new(|_| ()))];
    let mut add = |name: String, change: Box<dyn Fn(&mut Settings)>| all.push((name, change));
    for gamma in [0.5, 0.667, 0.9, 1.0] {
        add(format!("γ {gamma}"), Box::new(move |s| s.sampler.gamma = gamma));
    }
    add("σ² of a sample".into(), Box::new(|s| s.sampler.criterion = Criterion::Sample));
    for gamma in [0.5, 0.667] {
        let change = move |s: &mut Settings| {
            s.sampler.criterion = Criterion::Sample;
            s.sampler.gamma = gamma;
        };
        add(format!("σ² of a sample, γ {gamma}"), Box::new(change));
    }
    add("no window".into(), Box::new(|s| s.sampler.window = Window::Pixel));
    for iterations in [2, 4, 8, 16, 32].into_iter().filter(|i| i * 2 <= spp.max(4)) {
        add(format!("{iterations} iterations"), Box::new(move |s| s.iterations = iterations));
    }
    for epsilon in [0.0, 0.05, 0.1] {
        add(format!("ε {epsilon}"), Box::new(move |s| s.sampler.epsilon = epsilon));
    }
    for fair in [2, 4, 8, 16, 32].into_iter().filter(|fair| fair * 2 <= spp) {
        add(format!("{fair} fair samples"), Box::new(move |s| s.sampler.fair = fair));
    }
    for radius in [12, 24, 48] {
        add(format!("balance radius {radius}"), Box::new(move |s| s.sampler.balance_radius = radius));
    }
    add("fresh sequences".into(), Box::new(|s| s.sampler.sequence = Sequence::Fresh));
    for (name, estimator) in [
        ("pooled", Estimator::Pooled),
        ("difference", Estimator::Difference),
        ("subframe", Estimator::Subframe),
    ] {
        add(name.into(), Box::new(move |s| s.set_estimator(estimator)));
    }
    all
}

/// Prints the table.
pub fn run(arguments: &[String]) {
    let mut arguments = arguments.iter().map(|a| a.parse::<u32>().expect("a whole number"));
    let runs = arguments.next().unwrap_or(16);
    let side = arguments.next().unwrap_or(128);
    let reference_spp = arguments.next().unwrap_or(8192);
    let rest: Vec<u32> = arguments.collect();
    let spps = if rest.is_empty() { vec![8, 16, 64] } else { rest };
    for name in ["cornell", "caustic"] {
        let study = Study::new(name, side, reference_spp);
        for &spp in &spps {
            table(name, &study, spp, runs);
        }
    }
}

fn table(name: &str, study: &Study, spp: u32, runs: u32) {
    let uniform = study.run(&study.settings(Method::Uniform, spp), runs);
    println!("\n{name}, {spp} spp, {runs} runs: uniform ÷ variant\n");
    println!("| variant | Err | low-pass Err | relMSE | energy bias |\n| --- | --- | --- | --- | --- |");
    let row = |name: &str, settings: &Settings| {
        let outcome = study.run(settings, runs);
        println!(
            "| {name} | {:.2} | {:.2} | {:.2} | {:+.2} % ± {:.2} |",
            uniform.err / outcome.err,
            uniform.err_lowpass / outcome.err_lowpass,
            uniform.rel_mse / outcome.rel_mse,
            100.0 * outcome.bias.0,
            100.0 * outcome.bias.1,
        );
    };
    row("paper", &study.settings(Method::Paper, spp));
    for (variant, change) in variants(spp) {
        let mut settings = study.settings(Method::Pmc, spp);
        change(&mut settings);
        row(&variant, &settings);
    }
}
