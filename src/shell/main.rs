//! The program `pmcip`: see `pmcip --help`.

mod animate;
mod cli;
mod commands;
mod processor;
mod progress;
mod report;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    if let Some(missing) = processor::missing() {
        eprintln!("error: {missing}");
        return ExitCode::from(1);
    }
    let arguments = match cli::Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(refusal) => return cli::refuse(&refusal),
    };
    match commands::run(arguments.command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {}", failure.message);
            ExitCode::from(failure.code)
        }
    }
}
