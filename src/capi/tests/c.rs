//! The header is current, and programs in C and C++ compile without a warning, link and do what they should, also under
//! valgrind. What needs a tool that is not there says so and passes.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

const HERE: &str = env!("CARGO_MANIFEST_DIR");
const TEMPORARY: &str = env!("CARGO_TARGET_TMPDIR");

/// Whether a tool can be started.
fn there_is(tool: &str) -> bool {
    let found = Command::new(tool).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    let there = found.is_ok_and(|status| status.success());
    if !there {
        eprintln!("skipped: there is no {tool}");
    }
    there
}

fn succeed(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(output.status.success(), "{command:?}\n{}{}", text(&output.stdout), text(&output.stderr));
    text(&output.stdout)
}

/// The static library, made by cargo where the tests were made.
fn library() -> &'static Path {
    static LIBRARY: OnceLock<PathBuf> = OnceLock::new();
    LIBRARY.get_or_init(|| {
        let target = Path::new(TEMPORARY).parent().unwrap();
        let mut cargo = Command::new(env!("CARGO"));
        cargo.current_dir(HERE).args(["build", "--locked", "--package", "pmcip-capi", "--target-dir"]);
        succeed(cargo.arg(target));
        target.join("debug/libpmcip_capi.a")
    })
}

/// Compiles an example and returns the program.
fn compiled(compiler: &str, flags: &[&str], source: &str) -> PathBuf {
    let program = Path::new(TEMPORARY).join(source.replace('.', "_"));
    let mut command = Command::new(compiler);
    command.args(flags).args(["-O1", "-g", "-Wall", "-Wextra", "-Werror", "-pedantic"]);
    command.arg("-I").arg(Path::new(HERE).join("include"));
    command.arg(Path::new(HERE).join("examples").join(source)).arg(library());
    succeed(command.args(["-lpthread", "-ldl", "-lm", "-o"]).arg(&program));
    program
}

/// Runs an example as it is, and under valgrind.
fn check(program: &Path) {
    assert!(succeed(&mut Command::new(program)).contains("energy"));
    // Valgrind knows no AVX-512, and tests are built for AVX2 at most.
    if there_is("valgrind") {
        let mut valgrind = Command::new("valgrind");
        valgrind.args(["--quiet", "--error-exitcode=9", "--leak-check=full"]);
        succeed(valgrind.arg(program));
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_c99_program_runs() {
    if there_is("cc") {
        check(&compiled("cc", &["-std=c99"], "analytic.c"));
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_cpp17_program_with_threads_runs() {
    if there_is("c++") {
        check(&compiled("c++", &["-std=c++17"], "threads.cpp"));
    }
}

#[test]
fn the_header_is_current() {
    let header = fs::read_to_string(Path::new(HERE).join("include/pmcip.h")).unwrap();
    // Every function of the library is in it, whether or not there is a cbindgen.
    let source = fs::read_to_string(Path::new(HERE).join("lib.rs")).unwrap();
    let functions =
        source.lines().filter_map(|line| line.split_once("extern \"C\" fn ")).map(|(_, rest)| rest);
    let mut count = 0;
    for name in functions.map(|rest| rest.split('(').next().unwrap()) {
        assert!(header.contains(&format!("{name}(")), "{name} is not in the header");
        count += 1;
    }
    assert!(count > 20);
    if there_is("cbindgen") {
        let made = succeed(Command::new("cbindgen").current_dir(HERE).args([
            "--quiet",
            "--config",
            "cbindgen.toml",
        ]));
        assert_eq!(
            made, header,
            "make the header anew: cbindgen --config cbindgen.toml --output include/pmcip.h"
        );
    }
}
