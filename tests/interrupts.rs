//! What is left of a render that ends too early, and how it goes on. Signals are those of Unix.
#![cfg(unix)]

mod program;

use pmcip::picture::frame_io::read_exr;
use program::{failure, pmcip, success};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::Duration;
use tempfile::TempDir;

/// A scene that takes seconds at many samples.
fn room() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let scene = "[film]\nwidth = 64\nheight = 64\n[camera]\nfrom = [0, 0, 5]\nat = [0, 0, 0]\nfov = 40\n\
        [frames]\nfirst = 1\nlast = 50\n\
        [[spheres]]\ncenter = [0, 0, 0]\nradius = 1\nsubdivisions = 2\nmaterial = \"m\"\n\
        keys = [{ frame = 1, center = [0, 0, 0] }, { frame = 50, center = [0.5, 0, 0] }]\n\
        [[lights]]\ncenter = [0, 4, 2]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\nradiance = [9, 9, 9]\n[materials.m]\n";
    fs::write(folder.path().join("room.toml"), scene).unwrap();
    folder
}

fn start(folder: &Path, arguments: &str) -> Child {
    let mut program = Command::new(env!("CARGO_BIN_EXE_pmcip"));
    program.current_dir(folder).args(arguments.split_whitespace());
    program.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

fn send(child: &Child, signal: &str) {
    let sent = Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let files = fs::read_dir(folder).unwrap().map(|file| file.unwrap().path());
    // Names that begin with a dot are those of parts.
    let is_hidden = |path: &Path| path.file_name().unwrap().to_string_lossy().starts_with('.');
    files.filter(|path| path.to_string_lossy().ends_with(ending) && !is_hidden(path)).collect()
}

/// Files that are on their way, or were when their run was killed.
fn left_over(folder: &Path) -> usize {
    let files = fs::read_dir(folder).unwrap().map(|file| file.unwrap().file_name());
    files.filter(|name| name.to_string_lossy().ends_with(".part")).count()
}

/// Waiting times that differ from one to the next: a golden rotation.
fn moments() -> impl Iterator<Item = Duration> {
    (1..).map(|i| Duration::from_millis(20 + ((f64::from(i) * 0.618_034).fract() * 380.0) as u64))
}

/// How often the program is killed: `PMCIP_KILLS`, or as often as there is time for in a test.
fn kills() -> usize {
    std::env::var("PMCIP_KILLS").map_or(6, |kills| kills.parse().unwrap())
}

const LONG: &str = "render room.toml --spp 2048 --iterations 256 --quiet -o long.exr";

#[test]
fn an_interrupted_frame_goes_on_with_the_same_bits() {
    for (signal, code) in [("-INT", 130), ("-TERM", 143)] {
        let [whole, parts] = [room(), room()];
        let mut child = start(parts.path(), LONG);
        sleep(Duration::from_millis(400));
        assert!(child.try_wait().unwrap().is_none(), "it should take longer");
        send(&child, signal);
        let Output { status, stderr, .. } = child.wait_with_output().unwrap();
        let said = String::from_utf8(stderr).unwrap();
        assert_eq!(status.code(), Some(code), "{said}");
        assert!(said.contains("long.film has what there is, --resume goes on from it"), "{said}");
        assert!(files(parts.path(), ".exr").is_empty() && files(parts.path(), ".png").is_empty());
        failure(parts.path(), &format!("{LONG} --resume --seed 3"), 2, "seed was '0', now it is '3'");
        success(parts.path(), &format!("{LONG} --resume"));
        assert!(files(parts.path(), ".film").is_empty());
        success(whole.path(), LONG);
        let [whole, parts] = [whole, parts].map(|folder| fs::read(folder.path().join("long.exr")).unwrap());
        assert!(whole == parts, "the pictures differ");
    }
}

#[test]
fn a_frame_that_is_killed_again_and_again_gets_done() {
    let [whole, parts] = [room(), room()];
    for moment in moments().take(kills()) {
        let mut child = start(parts.path(), &format!("{LONG} --resume --checkpoint 0"));
        sleep(moment);
        child.kill().unwrap();
        child.wait().unwrap();
        // What has its final name is whole.
        files(parts.path(), ".exr").iter().for_each(|file| _ = read_exr(file).unwrap());
        for file in files(parts.path(), ".film") {
            let bytes = fs::read(file).unwrap();
            let line = bytes.iter().position(|byte| *byte == b'\n').unwrap();
            pmcip_core::sampler::saved::Saved::new(&bytes[line + 1..]).unwrap();
        }
    }
    success(parts.path(), &format!("{LONG} --resume"));
    assert_eq!(left_over(parts.path()), 0);
    success(whole.path(), LONG);
    let [whole, parts] = [whole, parts].map(|folder| fs::read(folder.path().join("long.exr")).unwrap());
    assert!(whole == parts, "the pictures differ");
}

#[test]
fn an_animation_that_is_killed_again_and_again_gets_done() {
    const FRAMES: &str = "render room.toml --spp 48 --frames 1..50 --quiet -o f.exr";
    let [whole, parts] = [room(), room()];
    for moment in moments().take(kills()) {
        let mut child = start(parts.path(), FRAMES);
        sleep(moment);
        child.kill().unwrap();
        child.wait().unwrap();
        files(parts.path(), ".exr").iter().for_each(|file| _ = read_exr(file).unwrap());
    }
    success(parts.path(), FRAMES);
    assert_eq!(left_over(parts.path()), 0);
    success(whole.path(), FRAMES);
    let [whole, parts] = [whole, parts].map(|folder| {
        let mut files = files(folder.path(), ".exr");
        files.sort();
        files.iter().map(|file| fs::read(file).unwrap()).collect::<Vec<_>>()
    });
    assert_eq!(whole.len(), 50);
    assert!(whole == parts, "the frames differ");
}

#[test]
fn what_needs_more_than_the_film_has_no_checkpoint() {
    let room = room();
    for more in
        ["--target-err 1", "--frames 1..2 --startup motion", "--frames 1..2 --history --estimator guided"]
    {
        failure(
            room.path(),
            &format!("render room.toml --checkpoint 5 {more}"),
            2,
            "--checkpoint cannot be used",
        );
    }
    fs::write(room.path().join("room.film"), "anything\n").unwrap();
    failure(room.path(), "render room.toml --resume", 2, "room.film: it is no film file");
    failure(
        room.path(),
        "render room.toml --checkpoint 5",
        2,
        "room.film is there already: --resume goes on",
    );
    // What is somebody's own stays, whatever is rendered beside it.
    success(room.path(), "render room.toml --spp 1 --quiet");
    assert_eq!(fs::read(room.path().join("room.film")).unwrap(), b"anything\n");
}

#[test]
fn time_ends_a_frame() {
    let room = room();
    let report = success(room.path(), "render room.toml --time 0.2 --json");
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    let (spent, samples) = (report["spent_spp"].as_f64().unwrap(), report["samples"].as_f64().unwrap());
    assert!(spent >= 2.0 && spent.fract() == 0.0 && samples <= spent * 64.0 * 64.0, "{report}");
    assert_eq!(report["settings"]["time"], 0.2);
    let most = success(room.path(), "render room.toml --time 1000 --spp 20");
    assert!(most.contains("20 samples per pixel in the 1000 seconds"), "{most}");
    assert_eq!(read_exr(&room.path().join("room.exr")).unwrap().attributes["spent_spp"], "20");
}

#[test]
fn a_folder_that_vanishes_is_an_error() {
    let room = room();
    let gone = room.path().join("out");
    fs::create_dir(&gone).unwrap();
    let child = start(room.path(), &format!("{} -o out/a.exr", LONG.trim_end_matches(" -o long.exr")));
    sleep(Duration::from_millis(300));
    fs::remove_dir_all(&gone).unwrap();
    send(&child, "-INT");
    let Output { status, stderr, .. } = child.wait_with_output().unwrap();
    let said = String::from_utf8(stderr).unwrap();
    assert_eq!(status.code(), Some(1), "{said}");
    assert!(said.contains("cannot write out/a.film: no such file or folder"), "{said}");
}

#[test]
fn a_checkpoint_that_cannot_be_written_ends_nothing() {
    let room = room();
    let [out, away] = ["out", "away"].map(|name| room.path().join(name));
    fs::create_dir(&out).unwrap();
    let render = "render room.toml --spp 2048 --iterations 256 --checkpoint 0 -o out/a.exr";
    let child = start(room.path(), render);
    sleep(Duration::from_millis(300));
    fs::rename(&out, &away).unwrap();
    sleep(Duration::from_millis(300));
    fs::rename(&away, &out).unwrap();
    let Output { status, stderr, .. } = child.wait_with_output().unwrap();
    let said = String::from_utf8(stderr).unwrap();
    assert!(status.success(), "{said}");
    assert_eq!(said.matches("warning: no checkpoint: cannot write out/a.film").count(), 1, "{said}");
    assert!(out.join("a.exr").exists() && !out.join("a.film").exists());
}

/// Few descriptors are enough for many frames: what is opened is closed.
#[test]
fn few_descriptors_are_enough() {
    let room = room();
    let program = env!("CARGO_BIN_EXE_pmcip");
    let frames = "--frames 1..12 --spp 2 --size 16x16 --checkpoint 0 --resume -o f.####.exr --quiet";
    let script = format!("ulimit -n 8 && exec '{program}' render room.toml {frames}");
    let done = Command::new("sh").args(["-c", &script]).current_dir(room.path()).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    assert_eq!(files(room.path(), ".exr").len(), 12);
}

/// A disk that is full, where the tests may make one.
#[test]
fn a_full_disk_leaves_nothing_half_done() {
    let room = room();
    let disk = room.path().join("disk");
    fs::create_dir(&disk).unwrap();
    let mounted = Command::new("mount").args(["-t", "tmpfs", "-o", "size=16k", "tmpfs"]).arg(&disk).output();
    if !mounted.is_ok_and(|mounted| mounted.status.success()) {
        eprintln!("skipped: no disk can be made here");
        return;
    }
    let done = pmcip(room.path(), "render room.toml --spp 1 --size 200x200 -o disk/a.exr");
    let left = fs::read_dir(&disk).unwrap().count();
    Command::new("umount").arg(&disk).status().unwrap();
    let said = String::from_utf8(done.stderr).unwrap();
    assert_eq!(done.status.code(), Some(1), "{said}");
    assert!(said.contains("cannot write disk/a.exr: the disk is full"), "{said}");
    assert_eq!(left, 0);
}
