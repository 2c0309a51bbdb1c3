//! The program, run in a folder.
#![allow(dead_code, reason = "each test file uses its own part")]

use std::path::Path;
use std::process::{Command, Output};

/// Runs the program in `folder`, with arguments divided by spaces.
pub fn pmcip(folder: &Path, arguments: &str) -> Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_pmcip"));
    program.current_dir(folder).args(arguments.split_whitespace()).output().unwrap()
}

/// What a successful run printed.
#[track_caller]
pub fn success(folder: &Path, arguments: &str) -> String {
    let Output { status, stdout, stderr } = pmcip(folder, arguments);
    assert!(status.success(), "{arguments}: {}", String::from_utf8_lossy(&stderr));
    String::from_utf8(stdout).unwrap()
}

/// Checks the exit code and that one line on stderr says `words`.
#[track_caller]
pub fn failure(folder: &Path, arguments: &str, code: i32, words: &str) {
    let Output { status, stdout, stderr } = pmcip(folder, arguments);
    let stderr = String::from_utf8(stderr).unwrap();
    assert_eq!(status.code(), Some(code), "{arguments}: {stderr}");
    assert!(stderr.starts_with("error: ") && stderr.trim_end().lines().count() == 1, "{arguments}: {stderr}");
    assert!(stderr.contains(words), "{arguments}: `{words}` is not in {stderr}");
    assert!(stdout.is_empty());
}
