//! The measurements behind the tables of `benches/README.md`: speed against error, and what each part costs.
//!
//! `cargo run --release -p measure -- NAME …` prints a table; `… -- all` writes every table into that file.

use std::path::{Path, PathBuf};

pub mod all;
pub mod bias;
pub mod border;
pub mod compare;
pub mod farm;
pub mod features;
pub mod homography;
pub mod labels;
pub mod lights;
pub mod overhead;
pub mod pairs;
pub mod prediction;
pub mod queue;
pub mod rays;
pub mod study;
pub mod sweep;
pub mod target;
pub mod turned;

/// The repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The scene file of a scene of this project.
pub fn scene_file(name: &str) -> PathBuf {
    root().join("scenes").join(name).with_extension("toml")
}
