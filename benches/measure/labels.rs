//! What labels cost: nanoseconds a pixel to begin an iteration and to resolve, and a sample to hand out and accept, without
//! labels, with one for all, and with islands. One thread.
//!
//! `cargo run --release -p measure -- labels [RUNS]` prints a Markdown table of medians; the films take turns, so that a noisy
//! machine hurts them alike. Without labels is the row that [`overhead`](crate::overhead) has of this size.

use crate::overhead::{Cost, Film, median};

const SIDE: u32 = 512;

/// Prints the table.
pub fn run(arguments: &[String]) {
    let runs = arguments.first().map_or(101, |runs| runs.parse().expect("a whole number"));
    let islands = |cells: u32| {
        let label = move |i: u32| (i / SIDE * cells / SIDE * cells + i % SIDE * cells / SIDE + 1) as u16;
        Some((0..SIDE * SIDE).map(label).collect::<Vec<u16>>())
    };
    let cases =
        [("none", None), ("one", islands(1)), ("16 islands", islands(4)), ("256 islands", islands(16))];
    let mut films = cases.each_ref().map(|(_, labels)| Film::new(SIDE, SIDE, labels.as_deref()));
    films.iter_mut().for_each(|film| _ = film.run(2)); // The first iteration is uniform.
    let costs: Vec<[Cost; 4]> = (0..runs.max(1)).map(|_| films.each_mut().map(|film| film.run(2))).collect();
    println!("| labels | begin ns/px | ns/sample | resolve ns/px | all, ÷ without |");
    println!("| --- | --- | --- | --- | --- |");
    let all = |cost: &Cost| cost.begin + 2.0 * cost.samples + cost.resolve;
    for (i, (name, _)) in cases.iter().enumerate() {
        let of = |f: &dyn Fn(&[Cost; 4]) -> f64| median(costs.iter().map(f).collect());
        println!(
            "| {name} | {:.2} | {:.2} | {:.2} | {:.3} |",
            of(&|c| c[i].begin),
            of(&|c| c[i].samples),
            of(&|c| c[i].resolve),
            of(&|c| all(&c[i]) / all(&c[0])),
        );
    }
}
