//! `cargo run --release -p measure -- NAME …`: see the head of each file.

use std::process::ExitCode;

fn main() -> ExitCode {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let name = if arguments.is_empty() { String::new() } else { arguments.remove(0) };
    let rest = arguments.as_slice();
    match name.as_str() {
        "all" => measure::all::run(rest),
        "bias" => measure::bias::run(rest),
        "border" => measure::border::run(rest),
        "compare" => measure::compare::run(rest),
        "farm" => measure::farm::run(rest),
        "features" => measure::features::run(rest).expect("files are written"),
        "homography" => measure::homography::run(rest).expect("files are written"),
        "labels" => measure::labels::run(rest),
        "lights" => measure::lights::run(rest),
        "overhead" => measure::overhead::run(rest),
        "prediction" => measure::prediction::run(rest),
        "rays" => measure::rays::run(rest),
        "sweep" => measure::sweep::run(rest),
        "target" => measure::target::run(rest),
        _ => {
            eprintln!(
                "expected all, bias, border, compare, farm, features, homography, labels, lights, overhead, prediction, rays, sweep or target"
            );
            return ExitCode::from(2);
        }
    }
    ExitCode::SUCCESS
}
