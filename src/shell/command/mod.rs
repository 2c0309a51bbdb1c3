//! The program's own: arguments, one file a command, what they print.

pub mod arguments;
mod bake;
mod common;
mod compare;
mod error;
mod farm;
mod frames;
mod guide;
mod info;
mod kept;
mod layers;
mod load;
mod merge;
mod print;
pub mod processor;
mod progress;
mod reference;
mod render;
mod signals;
mod values;
mod viewer;

use arguments::Command;
use common::Failure;

/// Runs a command.
pub fn run(command: Command) -> Result<(), Failure> {
    match command {
        Command::Render(arguments) => match &arguments.frames {
            Some(list) => frames::render_frames(&arguments, list),
            None => render::render_frame(&arguments),
        },
        Command::Bake(arguments) => bake::bake_lightmap(&arguments),
        Command::Farm(arguments) => farm::divide(&arguments),
        Command::Merge(arguments) => merge::merge_films(&arguments),
        Command::Guide(arguments) => guide::guide_picture(&arguments),
        Command::Reference(arguments) => reference::render_reference(&arguments),
        Command::Compare(arguments) => compare::compare_methods(&arguments),
        Command::Error(arguments) => error::measure(&arguments),
        Command::Info(arguments) => info::info(&arguments),
    }
}
