//! Scenes from texts, for the tests of the loader.

#![allow(dead_code, reason = "each test program uses some of it")]

use pmcip::scene::{LoadedScene, load};
use tempfile::TempDir;

/// The corners of a unit square.
pub const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

/// A folder with the given files.
pub fn folder(files: &[(&str, &str)]) -> TempDir {
    let dir = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(dir.path().join(name), text).unwrap();
    }
    dir
}

/// Loads the first of the given files.
pub fn load_files(files: &[(&str, &str)]) -> LoadedScene {
    let dir = folder(files);
    load(&dir.path().join(files[0].0)).unwrap()
}
