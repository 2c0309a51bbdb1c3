//! The program `pmcip`: see `pmcip --help`.

mod command;

use clap::Parser;
use command::{arguments, processor};
use std::process::ExitCode;

fn main() -> ExitCode {
    if let Some(missing) = processor::missing() {
        eprintln!("error: {missing}");
        return ExitCode::from(1);
    }
    let arguments = match arguments::Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(refusal) => return arguments::refuse(&refusal),
    };
    match command::run(arguments.command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {}", failure.message);
            ExitCode::from(failure.code)
        }
    }
}
