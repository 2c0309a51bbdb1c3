//! An MTL file of any bytes.

#![no_main]

use libfuzzer_sys::fuzz_target;
use mutant::OBJ;
use std::sync::LazyLock;
use tempfile::TempDir;

#[allow(dead_code, reason = "shared with other targets")]
#[path = "../../tests/mutant/mod.rs"]
mod mutant;

static FOLDER: LazyLock<TempDir> =
    LazyLock::new(|| tempfile::tempdir().expect("there is a temporary folder"));
static PICTURE: LazyLock<Vec<u8>> = LazyLock::new(mutant::picture);

fuzz_target!(|bytes: &[u8]| mutant::load(FOLDER.path(), OBJ, bytes, &PICTURE));
