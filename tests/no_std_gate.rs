//! The core needs neither std nor an allocator: two gates, and mutants that each must be rejected.
//!
//! A `#![no_std]` library proves little on a host with std: methods such as `f32::sqrt` resolve as soon as any
//! crate of the build links std, and `extern crate alloc` costs nothing until something is linked. So
//! 1. a program without allocator (`tests/no_std`) is linked to the core and run, and
//! 2. the core is compiled against a sysroot that holds the crate `core` and nothing else.
//!
//! And where there is WebAssembly, the sampler runs there.

#[path = "wasm/film.rs"]
mod film;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const TEMPORARY: &str = env!("CARGO_TARGET_TMPDIR");

#[test]
#[cfg(target_os = "linux")]
fn a_program_without_std_and_allocator_links_to_the_core_and_runs() {
    let folder = Path::new(ROOT).join("tests/no_std");
    let target = Path::new(TEMPORARY).join("probe");
    let mut cargo = Command::new(env!("CARGO"));
    cargo.current_dir(folder).args(["build", "--locked", "--target-dir"]).arg(&target);
    expect(&mut cargo, None);
    expect(&mut Command::new(target.join("debug/probe")), None);
}

/// The sampler in WebAssembly, with and without its SIMD, has the bits that it has here. It is skipped where the target
/// (`rustup target add wasm32-unknown-unknown`) or node is not there.
#[test]
fn a_film_has_the_same_bits_in_webassembly() {
    const TARGET: &str = "wasm32-unknown-unknown";
    let libraries = PathBuf::from(ask(&["--print", "target-libdir", "--target", TARGET]).trim());
    if !libraries.is_dir() {
        return eprintln!("skipped: the target {TARGET} is not installed");
    }
    if !Command::new("node").arg("--version").output().is_ok_and(|node| node.status.success()) {
        return eprintln!("skipped: there is no node");
    }
    let here = film::digest().unwrap();
    for (name, flags) in [("plain", ""), ("SIMD", "-C target-feature=+simd128")] {
        let target = Path::new(TEMPORARY).join("wasm");
        let mut cargo = Command::new(env!("CARGO"));
        cargo.current_dir(Path::new(ROOT).join("tests/wasm")).args(["build", "--locked", "--target", TARGET]);
        cargo.arg("--target-dir").arg(&target);
        cargo.env_remove("CARGO_ENCODED_RUSTFLAGS").env("RUSTFLAGS", flags);
        expect(&mut cargo, None);
        let run = "WebAssembly.instantiate(require('fs').readFileSync(process.argv[1]))\
            .then(({ instance }) => console.log(BigInt.asUintN(64, instance.exports.digest()).toString()))";
        let mut node = Command::new("node");
        node.args(["-e", run]).arg(target.join(TARGET).join("debug/film.wasm"));
        let output = node.output().unwrap();
        let found = String::from_utf8(output.stdout).unwrap();
        assert_eq!(found.trim(), here.to_string(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn the_core_compiles_where_nothing_but_core_exists() {
    let sysroot = core_only_sysroot("gate");
    let architecture = if cfg!(target_arch = "x86_64") { " -C target-cpu=x86-64-v3" } else { "" };
    let mut cargo = Command::new(env!("CARGO"));
    cargo.current_dir(ROOT).args([
        "check",
        "--locked",
        "-p",
        "pmcip-core",
        "--target",
        &host(),
        "--target-dir",
    ]);
    cargo.arg(Path::new(TEMPORARY).join("core_only"));
    cargo.env_remove("CARGO_ENCODED_RUSTFLAGS");
    cargo.env("RUSTFLAGS", format!("--sysroot {}{architecture}", sysroot.display()));
    expect(&mut cargo, None);
}

#[test]
fn the_sysroot_rejects_alloc_std_and_sqrt() {
    let sysroot = core_only_sysroot("mutants");
    let compile = |name: &str, body: &str, complaint: Option<&str>| {
        let source = write(&format!("sysroot_{name}.rs"), &format!("#![no_std]\n{body}"));
        let mut rustc = rustc();
        rustc
            .args(["--crate-type", "lib", "--emit", "metadata", "--edition", "2024", "--sysroot"])
            .arg(&sysroot);
        expect(rustc.arg("--out-dir").arg(TEMPORARY).arg(source), complaint);
    };
    compile("control", "pub fn f(x: f32) -> f32 { x + 1.0 }", None);
    compile("alloc", "extern crate alloc;", Some("can't find crate for `alloc`"));
    compile("std", "extern crate std;", Some("can't find crate for `std`"));
    compile("sqrt", "pub fn f(x: f32) -> f32 { x.sqrt() }", Some("no method named `sqrt`"));
}

#[test]
#[cfg(target_os = "linux")]
fn the_probe_rejects_alloc_and_std() {
    let probe = fs::read_to_string(Path::new(ROOT).join("tests/no_std/probe.rs")).unwrap();
    let handler = probe.find("#[link").expect("the probe links libc");
    let frame = &probe[handler..probe.find("/// What the C runtime calls").expect("the probe has a main")];
    let link = |name: &str, body: &str, complaint: Option<&str>| {
        let head = "#![no_std]\n#![no_main]\nuse core::panic::PanicInfo;\n";
        let main = "#[unsafe(no_mangle)] pub extern \"C\" fn main() -> i32 { 0 }";
        let source = write(&format!("probe_{name}.rs"), &format!("{head}{body}\n{frame}{main}"));
        let mut rustc = rustc();
        rustc.args(["--crate-type", "bin", "--edition", "2024", "-O", "-C", "panic=abort", "--out-dir"]);
        expect(rustc.arg(TEMPORARY).arg(source), complaint);
    };
    link("control", "", None);
    link("alloc", "extern crate alloc;", Some("no global memory allocator"));
    link("std", "extern crate std;", Some("`panic_impl`"));
}

/// Runs a command that must succeed, or fail with a complaint.
#[track_caller]
fn expect(command: &mut Command, complaint: Option<&str>) {
    let Output { status, stderr, .. } = command.output().unwrap();
    let stderr = String::from_utf8_lossy(&stderr);
    match complaint {
        None => assert!(status.success(), "{command:?} failed:\n{stderr}"),
        Some(words) => assert!(!status.success() && stderr.contains(words), "{command:?}:\n{stderr}"),
    }
}

fn rustc() -> Command {
    Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()))
}

/// What `rustc` prints when asked.
fn ask(arguments: &[&str]) -> String {
    String::from_utf8(rustc().args(arguments).output().unwrap().stdout).unwrap()
}

fn host() -> String {
    let version = ask(&["-vV"]);
    version.lines().find_map(|line| line.strip_prefix("host: ")).expect("rustc names its host").to_owned()
}

fn write(name: &str, source: &str) -> PathBuf {
    let path = Path::new(TEMPORARY).join(name);
    fs::write(&path, source).unwrap();
    path
}

/// A folder that looks like the compiler's own, with nothing but `core` in it.
fn core_only_sysroot(name: &str) -> PathBuf {
    let sysroot = Path::new(TEMPORARY).join(format!("sysroot_{name}"));
    let libraries = sysroot.join("lib/rustlib").join(host()).join("lib");
    let _ = fs::remove_dir_all(&sysroot);
    fs::create_dir_all(&libraries).unwrap();
    for file in fs::read_dir(ask(&["--print", "target-libdir"]).trim()).unwrap().map(Result::unwrap) {
        let name = file.file_name().into_string().unwrap();
        let kept = ["libcore-", "libcompiler_builtins-", "librustc_std_workspace_core-"];
        if kept.iter().any(|prefix| name.starts_with(prefix)) {
            let copy = libraries.join(name);
            fs::hard_link(file.path(), &copy).or_else(|_| fs::copy(file.path(), copy).map(drop)).unwrap();
        }
    }
    sysroot
}
