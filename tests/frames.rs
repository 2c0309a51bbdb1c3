//! `render --frames` from outside: names, resuming, what is never overwritten, videos.

use pmcip::picture::frame_io::{read_exr, write_exr};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

const SCENE: &str = "[film]\nwidth = 24\nheight = 17\n[render]\nspp = 2\n[frames]\nfirst = 1\nlast = 4\nfps = 12\n\
    [camera]\nfrom = [0, 0, 5]\nat = [0, 0, 0]\nfov = 40\n\
    keys = [{ frame = 1, from = [0, 0, 5] }, { frame = 4, from = [1, 0, 5] }]\n\
    [[spheres]]\ncenter = [0, 0, 0]\nradius = 1\nsubdivisions = 2\nmaterial = \"m\"\n\
    keys = [{ frame = 2, center = [0, 0, 0] }, { frame = 4, center = [0.5, 0, 0] }]\n\
    [[lights]]\ncenter = [0, 4, 2]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\nradiance = [9, 9, 9]\n[materials.m]\n";

fn room() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("walk.toml"), SCENE).unwrap();
    folder
}

/// Runs the program in `folder`, which is also where it finds other programs.
fn pmcip(folder: &Path, arguments: &str) -> Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_pmcip"));
    let here = std::env::join_paths([folder, Path::new("/bin"), Path::new("/usr/bin")]).unwrap();
    // Only a program of ours may pass for ffmpeg.
    let path = if folder.join("ffmpeg").exists() { here } else { folder.into() };
    program.current_dir(folder).env("PATH", path).args(arguments.split_whitespace()).output().unwrap()
}

#[track_caller]
fn success(folder: &Path, arguments: &str) -> String {
    let Output { status, stdout, stderr } = pmcip(folder, arguments);
    assert!(status.success(), "{arguments}: {}", String::from_utf8_lossy(&stderr));
    String::from_utf8(stdout).unwrap()
}

#[track_caller]
fn failure(folder: &Path, arguments: &str, code: i32, words: &str) {
    let Output { status, stderr, .. } = pmcip(folder, arguments);
    let stderr = String::from_utf8(stderr).unwrap();
    assert_eq!(status.code(), Some(code), "{arguments}: {stderr}");
    assert!(stderr.contains(words), "{arguments}: `{words}` is not in {stderr}");
}

fn lines(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    fs::read(folder.join(name)).unwrap()
}

#[test]
fn frames_are_numbered_and_both_ends_are_rendered() {
    let room = room();
    let said = success(room.path(), "render walk.toml --frames 2..3");
    assert!(
        said.contains("frames 2 to 3") && said.contains("wrote walk.0002.exr to walk.0003.exr"),
        "{said}"
    );
    let mut names: Vec<_> = fs::read_dir(room.path()).unwrap().map(|f| f.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["walk.0002.exr", "walk.0002.png", "walk.0003.exr", "walk.0003.png", "walk.toml"]);
    let picture = read_exr(&room.path().join("walk.0003.exr")).unwrap();
    assert_eq!((picture.attributes["frame"].as_str(), picture.attributes["seed"].as_str()), ("3", "0"));
    assert!(picture.attributes["look_from"].starts_with("0.66"));
    // The same frame alone has the same bits, on any number of threads.
    success(room.path(), "render walk.toml --frames 3 -o alone.exr --threads 1");
    assert_eq!(bytes(room.path(), "walk.0003.exr"), bytes(room.path(), "alone.0003.exr"));
    // Without --frames there is one picture, of the first frame.
    success(room.path(), "render walk.toml");
    let still = read_exr(&room.path().join("walk.exr")).unwrap();
    assert_eq!(still.attributes["look_from"], "0.0,0.0,5.0");
}

#[test]
fn an_interrupted_sequence_goes_on_where_it_stopped() {
    let room = room();
    let all = lines(&success(room.path(), "render walk.toml --frames .. --json"));
    assert_eq!(all.iter().map(|line| line["frame"].as_u64().unwrap()).collect::<Vec<_>>(), [1, 2, 3, 4]);
    assert!(all.iter().all(|line| line["kept"] == false && line["samples"] == 24 * 17 * 2));
    // The sphere stands still up to frame 2.
    let rebuilt: Vec<bool> = all.iter().map(|line| line["rebuild_seconds"].is_f64()).collect();
    assert_eq!(rebuilt, [false, false, true, true]);
    let before = bytes(room.path(), "walk.0003.exr");
    fs::remove_file(room.path().join("walk.0003.exr")).unwrap();
    fs::remove_file(room.path().join("walk.0002.png")).unwrap();
    let again = lines(&success(room.path(), "render walk.toml --frames 1..4 --json"));
    let kept: Vec<bool> = again.iter().map(|line| line["kept"].as_bool().unwrap()).collect();
    assert_eq!(kept, [true, true, false, true]);
    assert_eq!(before, bytes(room.path(), "walk.0003.exr"));
    assert!(room.path().join("walk.0002.png").exists());
    assert!(success(room.path(), "render walk.toml --frames 1..4").contains("4 were there already"));
}

#[test]
fn frames_made_otherwise_are_not_lost() {
    let room = room();
    let path = room.path();
    success(path, "render walk.toml --frames 1..2");
    let before = bytes(path, "walk.0002.exr");
    failure(
        path,
        "render walk.toml --frames 1..2 --spp 3 --iterations 1",
        2,
        "walk.0001.exr is another frame",
    );
    failure(path, "render walk.toml --frames 1..2 --seed 9", 2, "seed was '0', now it is '9'");
    fs::write(path.join("walk.toml"), SCENE.replace("[materials.m]", "[materials.m]\ndiffuse = [1, 0, 0]"))
        .unwrap();
    failure(path, "render walk.toml --frames 2..3", 2, "the scene or the program was another");
    assert_eq!(before, bytes(path, "walk.0002.exr"));
    success(path, "render walk.toml --frames 1..2 --overwrite");
    assert_ne!(before, bytes(path, "walk.0002.exr"));
    fs::write(path.join("walk.0001.exr"), "no picture").unwrap();
    failure(path, "render walk.toml --frames 1", 2, "walk.0001.exr is another frame");
    success(path, "render walk.toml --frames 1 --overwrite");
    assert_eq!(read_exr(&path.join("walk.0001.exr")).unwrap().width, 24);
}

#[test]
fn damaged_frames_are_rendered_again() {
    let room = room();
    let path = room.path();
    success(path, "render walk.toml --frames 1..2");
    let whole = bytes(path, "walk.0002.exr");
    // In the head, in the pixels, and nothing at all.
    for length in [40, whole.len() - 20, 0] {
        for overwrite in ["", " --overwrite"] {
            fs::write(path.join("walk.0002.exr"), &whole[..length]).unwrap();
            assert_eq!(success(path, "render walk.toml --frames 1..2 --missing").trim(), "2");
            success(path, &format!("render walk.toml --frames 1..2{overwrite}"));
            assert!(whole == bytes(path, "walk.0002.exr"), "{length}{overwrite}");
        }
    }
}

#[test]
fn frames_may_be_listed_and_those_missing_asked_for() {
    let room = room();
    let path = room.path();
    let said = success(path, "render walk.toml --frames 1,3-4");
    assert!(said.contains("frames 1,3-4") && said.contains("3 rendered"), "{said}");
    assert!(!path.join("walk.0002.exr").exists());
    assert_eq!(success(path, "render walk.toml --frames 1..6 --missing").trim(), "2,5-6");
    let json: Value =
        serde_json::from_str(&success(path, "render walk.toml --frames .. --missing --json")).unwrap();
    assert_eq!(json["missing"], serde_json::json!([2]));
    assert!(!path.join("walk.0002.exr").exists());
    // A frame is the same in a list and in a row.
    let alone = bytes(path, "walk.0004.exr");
    success(path, "render walk.toml --frames 1..4 --startup uniform -o other.exr");
    success(path, "render walk.toml --frames 4,1 --startup uniform -o third.exr");
    assert!(bytes(path, "other.0004.exr") == bytes(path, "third.0004.exr") && !alone.is_empty());
    failure(path, "render walk.toml --frames 1..4000000000", 2, "4000000000 frames are more than");
    failure(path, "render walk.toml --frames 1,,2", 2, "expected A..B");
    failure(path, "render walk.toml --frames 1,3 --video a.mp4", 2, "without gaps");
}

#[test]
fn frames_that_end_early_pass_on_how_long_they_took() {
    let room = room();
    let render = "render walk.toml --frames 1..4 --target-err 20 --spp 200 --json";
    let all = lines(&success(room.path(), render));
    let spent: Vec<f64> = all.iter().map(|line| line["spent_spp"].as_f64().unwrap()).collect();
    assert!(spent.iter().all(|spp| (8.0..200.0).contains(spp)), "{spent:?}");
    assert!(all.iter().all(|line| line["estimated_err"].as_f64().unwrap() < 20.0));
    let expected: Vec<Option<f64>> =
        all.iter().map(|line| line["settings"]["expected_spp"].as_f64()).collect();
    assert_eq!(expected, [None, Some(spent[0]), Some(spent[1]), Some(spent[2])]);
    // A frame that is rendered again learns from the file of the one before.
    let before = bytes(room.path(), "walk.0003.exr");
    fs::remove_file(room.path().join("walk.0003.exr")).unwrap();
    success(room.path(), render);
    assert_eq!(before, bytes(room.path(), "walk.0003.exr"));
    failure(room.path(), "render walk.toml --target-err 0", 2, "above 0");
    failure(room.path(), "render walk.toml --target-err 1 --iterations 3", 2, "--iterations");
    let said = success(room.path(), "render walk.toml --target-err 20 --spp 200");
    assert!(said.contains("at most 200 samples per pixel") && said.contains("estimated Err"), "{said}");
}

#[test]
fn ranges_that_make_no_sense_are_refused() {
    let room = room();
    let still = SCENE.replace("[frames]\nfirst = 1\nlast = 4\nfps = 12\n", "").replace("keys", "#");
    fs::write(room.path().join("still.toml"), still).unwrap();
    for (arguments, words) in [
        ("render walk.toml --frames 4..2", "2 comes before 4"),
        ("render walk.toml --frames all", "expected A..B"),
        ("render walk.toml --frames 9..", "the last, 4, comes before the first, 9"),
        ("render still.toml --frames ..", "no [frames]"),
        ("render walk.toml --video a.mp4", "--frames"),
        ("render walk.toml --frames 1 --video a.avi", ".mp4"),
        ("render walk.toml --frames 1 --fps 10", "--video"),
        ("render walk.toml --frames 1 -o none/a.exr", "none/a.0001.exr"),
    ] {
        failure(room.path(), arguments, 2, words);
    }
}

/// A program named ffmpeg in `folder` that writes down what it is told and does `then`.
#[cfg(unix)]
fn pretend_ffmpeg(folder: &Path, then: &str) {
    use std::os::unix::fs::PermissionsExt;
    let file = folder.join("ffmpeg");
    let text = format!(
        "#!/bin/sh\n[ \"$1\" = -version ] && exit 0\necho \"$@\" > told\nfor out; do :; done\n{then}\n"
    );
    fs::write(&file, text).unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o755)).unwrap();
}

#[cfg(unix)]
#[test]
fn a_video_is_made_of_all_frames() {
    let room = room();
    let path = room.path();
    pretend_ffmpeg(path, "echo video > \"$out\"");
    assert!(success(path, "render walk.toml --frames 2..4 --video walk.mp4").contains("and walk.mp4"));
    assert_eq!(bytes(path, "walk.mp4"), b"video\n");
    let told = fs::read_to_string(path.join("told")).unwrap();
    assert!(told.contains("-framerate 12 -start_number 2 -i ./walk.%04d.png -frames:v 3"), "{told}");
    success(path, "render walk.toml --frames 2..4 --video walk.mp4 --fps 30");
    assert!(fs::read_to_string(path.join("told")).unwrap().contains("-framerate 30"));
    pretend_ffmpeg(path, "echo first >&2; echo 'no such codec' >&2; exit 1");
    failure(
        path,
        "render walk.toml --frames 2..4 --video walk.mp4",
        1,
        "ffmpeg made no video: no such codec",
    );
    assert_eq!(bytes(path, "walk.mp4"), b"video\n");
}

#[cfg(unix)]
#[test]
fn without_ffmpeg_there_are_pictures_and_a_clear_word() {
    let room = room();
    let words = "error: no video: the program ffmpeg is not installed; the frames are complete";
    failure(room.path(), "render walk.toml --frames 1..2 --video walk.mp4", 1, words);
    assert!(room.path().join("walk.0002.png").exists() && !room.path().join("walk.mp4").exists());
}

#[test]
fn a_frame_of_another_criterion_is_another_frame() {
    let room = room();
    let options = "render walk.toml --frames 2..2";
    success(room.path(), options);
    let file = room.path().join("walk.0002.exr");
    let mut picture = read_exr(&file).unwrap();
    let asked = picture.attributes.insert("criterion".into(), "sample".into());
    assert_eq!(asked.as_deref(), Some("mean"));
    write_exr(&file, &picture).unwrap();
    failure(room.path(), options, 2, "is another frame: criterion was 'sample', now it is 'mean'");
}

#[test]
fn history_blends_filtered_frames_and_says_so() {
    let room = room();
    let guided = "render walk.toml --frames 1..3 --estimator guided";
    success(room.path(), &format!("{guided} -o alone.exr"));
    success(room.path(), &format!("{guided} --history -o with.exr --threads 1"));
    success(room.path(), &format!("{guided} --history -o again.exr --threads 3"));
    let picture = |name: &str| read_exr(&room.path().join(name)).unwrap();
    let (alone, with) = (picture("alone.0003.exr"), picture("with.0003.exr"));
    assert!(picture("alone.0001.exr").rgb == picture("with.0001.exr").rgb, "the first has none before it");
    assert!(alone.rgb != with.rgb && with.rgb == picture("again.0003.exr").rgb);
    assert_eq!((alone.attributes.get("history"), with.attributes["history"].as_str()), (None, "true"));
    failure(room.path(), "render walk.toml --frames 1..3 --history", 2, "--estimator guided");
    failure(room.path(), "render walk.toml --estimator guided --history", 2, "--frames");
    failure(room.path(), &format!("{guided} -o with.exr"), 2, "history was 'true'");
}
