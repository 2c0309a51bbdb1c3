//! Makes the scenes that are too large for the repository.
//!
//! `cargo run --release -p scenes -- [statue|room …] [-o DIR]`: all scenes without a name; `DIR` is `scenes`
//! without `-o`, and gets `cache/NAME/` with meshes and textures, and the scene files if they are not there.

use clap::Parser;
use scenes::{Outcome, Scene, make};
use std::path::PathBuf;
use std::process::ExitCode;

/// Makes the meshes and textures of the scenes that are too large for the repository.
#[derive(Debug, Parser)]
struct Arguments {
    /// Scenes to make [default: all]
    #[arg(value_parser = scene)]
    scenes: Vec<Scene>,
    /// Folder of the scene files
    #[arg(short, long, value_name = "DIR", default_value = "scenes")]
    output: PathBuf,
}

fn scene(name: &str) -> Result<Scene, String> {
    let names = Scene::ALL.map(Scene::name).join(", ");
    Scene::ALL.into_iter().find(|s| s.name() == name).ok_or(format!("expected one of {names}"))
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let scenes = if arguments.scenes.is_empty() { Scene::ALL.to_vec() } else { arguments.scenes };
    for scene in scenes {
        let file = arguments.output.join(scene.name()).with_extension("toml");
        match make(scene, 1.0, &arguments.output) {
            Ok(Outcome::Kept) => println!("{}: up to date", file.display()),
            Ok(Outcome::Made(triangles)) => println!("{}: made {triangles} triangles", file.display()),
            Err(reason) => {
                eprintln!("{}: {reason}", file.display());
                return ExitCode::FAILURE;
            }
        }
    }
    ExitCode::SUCCESS
}
