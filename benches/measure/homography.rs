//! How well and how fast homographies are found among noise and outliers.
//!
//! `cargo run --release -p measure -- homography [PROBLEMS [SEED [THRESHOLD [FILE]]]]` prints the mean corner error,
//! the area under the corner-error curve up to 5 pixels and the time of a fit. To FILE it writes the problems, so that
//! other estimators can be run on them: little-endian doubles, 9 of the true matrix and then x, y, x', y' of each
//! of 200 pairs.

use crate::pairs::{self, PAIRS, Problem, Problems};
use pmcip_core::predict::homography::{self, Block, Settings};
use std::time::Instant;

/// Prints the table.
pub fn run(arguments: &[String]) -> std::io::Result<()> {
    let number = |i: usize, default: f64| {
        arguments.get(i).map_or(default, |a| a.parse().expect("problems, seed and threshold are numbers"))
    };
    let problems: Vec<Problem> =
        Problems::new(number(1, 1.0) as u64).take(number(0, 1000.0) as usize).collect();
    if let Some(file) = arguments.get(3) {
        std::fs::write(file, problems.iter().flat_map(bytes).collect::<Vec<u8>>())?;
    }
    measure(&problems, number(2, 3.0));
    Ok(())
}

/// A problem as it is written.
fn bytes(problem: &Problem) -> impl Iterator<Item = u8> + '_ {
    let pairs = problem.pairs.iter().flat_map(|pair| [pair.from, pair.to]).flatten();
    let matrix = problem.truth.matrix.into_iter().flatten();
    matrix.chain(pairs).flat_map(f64::to_le_bytes)
}

/// Fits all problems five times and prints errors and the median time.
fn measure(problems: &[Problem], threshold: f64) {
    let settings = Settings { threshold, ..Settings::default() };
    let mut scratch = [Block::default(); homography::required(PAIRS)];
    let mut fit = |problem: &Problem| homography::estimate(&problem.pairs, &settings, &mut scratch);
    let mut seconds: Vec<f64> = (0..5)
        .map(|_| {
            let start = Instant::now();
            problems.iter().for_each(|problem| _ = std::hint::black_box(fit(problem)));
            start.elapsed().as_secs_f64() / problems.len() as f64
        })
        .collect();
    seconds.sort_by(f64::total_cmp);
    let fits: Vec<_> = problems.iter().map(&mut fit).collect();
    let errors: Vec<f64> = problems
        .iter()
        .zip(&fits)
        .map(|(problem, fit)| pairs::corner_error(&problem.truth, fit.as_ref().ok().map(|f| &f.homography)))
        .collect();
    let iterations = fits.iter().flatten().map(|f| f64::from(f.iterations)).sum::<f64>();
    println!(
        "| problems | without a result | beyond 5 px | mean corner error, px | area up to 5 px | samples | µs |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    println!(
        "| {} | {} | {} | {:.4} | {:.4} | {:.0} | {:.1} |",
        problems.len(),
        fits.iter().filter(|fit| fit.is_err()).count(),
        errors.iter().filter(|e| **e > 5.0).count(),
        pairs::mean(&errors),
        pairs::area(&errors),
        iterations / problems.len() as f64,
        1e6 * seconds[2]
    );
}
