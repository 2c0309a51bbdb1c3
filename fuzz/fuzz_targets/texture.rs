//! A picture, through the loader: a file of any bytes.

#![no_main]

use libfuzzer_sys::fuzz_target;
use mutant::{MTL, OBJ};
use std::sync::LazyLock;
use tempfile::TempDir;

#[allow(dead_code, reason = "shared with other targets")]
#[path = "../../tests/mutant/mod.rs"]
mod mutant;

static FOLDER: LazyLock<TempDir> =
    LazyLock::new(|| tempfile::tempdir().expect("there is a temporary folder"));

fuzz_target!(|bytes: &[u8]| mutant::load(FOLDER.path(), OBJ, MTL, bytes));
