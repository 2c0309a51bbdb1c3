//! The lamp of last resort, and what a render says of light that is missing, wasted or too much.

mod program;

use pmcip::picture::frame_io::{Picture, read_exr};
use program::{failure, pmcip, success};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

const QUAD: &str = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nusemtl m\nf 1 2 3 4\n";
const LAMP: &str = "v -1 -1 3\nv 1 -1 3\nv 1 1 3\nusemtl lamp\n";

/// A folder with `s.obj` and `s.mtl`.
fn files(obj: &str, lamp: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("s.obj"), format!("mtllib s.mtl\n{obj}")).unwrap();
    let mtl = format!("newmtl m\nKd 0.5 0.5 0.5\nnewmtl lamp\nKd 0 0 0\n{lamp}\n");
    fs::write(folder.path().join("s.mtl"), mtl).unwrap();
    folder
}

/// Renders; returns the picture and what was said on stderr.
fn render(folder: &Path, options: &str) -> (Picture, String) {
    let output = pmcip(folder, &format!("render s.obj --size 16x16 --spp 16 {options}"));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{said}");
    (read_exr(&folder.join("s.exr")).unwrap(), said)
}

fn middle(picture: &Picture) -> f32 {
    picture.rgb[8 * 16 + 8][1]
}

#[test]
fn the_lamp_follows_the_camera() {
    let folder = files(QUAD, "");
    let front = middle(&render(folder.path(), "").0);
    for eye in ["0,0,4", "0,0,-4", "3,0,3", "0,-3,-3"] {
        let (picture, said) = render(folder.path(), &format!("--look-from={eye} --look-at=0,0,0"));
        assert!(middle(&picture) > 0.4 * front, "{eye}: {} of {front}", middle(&picture));
        assert!(said.contains("--light own"), "{said}");
    }
    failure(folder.path(), "render s.obj --size 8x8 --spp 1 --light own", 2, "no light");
}

/// Walls that hide a lamp behind the camera: it is inside with the eye, as bright as ever.
#[test]
fn the_lamp_is_in_the_room_with_the_eye() {
    let room = "v -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\nv -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nusemtl m\n\
        f 4 3 2 1\nf 6 5 8 7\nf 5 1 4 8\nf 2 6 7 3\nf 4 3 7 8\nf 5 6 2 1\n";
    let folder = files(room, "");
    for (eye, at) in [("0,0,0", "0,0,-1"), ("0.5,0.3,0.8", "-1,0,-1"), ("-0.9,-0.9,0.9", "50,0,-90")] {
        let (picture, _) = render(folder.path(), &format!("--look-from={eye} --look-at={at}"));
        assert!((0.1..3.0).contains(&middle(&picture)), "{eye}: {}", middle(&picture));
    }
    let (outside, _) = render(folder.path(), "");
    assert!(middle(&outside) > 0.1);
}

#[test]
fn light_that_leaves_the_picture_black_is_helped_or_left_as_asked() {
    for (lamp, faces) in [("Ke 1e-4 1e-4 1e-4", "f 7 6 5\n"), ("Ke 9 9 9", "f 5 6 7\n")] {
        let folder = files(&format!("{QUAD}{LAMP}{faces}"), lamp);
        let look = "--look-from=0,0,2.5 --look-at=0,0,0";
        let (auto, said) = render(folder.path(), look);
        assert!(middle(&auto) > 0.1, "{lamp}: {}", middle(&auto));
        assert!(said.contains("nearly black") && said.contains("--light own"), "{said}");
        assert_eq!(
            said.contains("the lamp \"lamp\" shines away from everything"),
            lamp.contains('9'),
            "{said}"
        );
        let (own, said) = render(folder.path(), &format!("{look} --light own"));
        assert!(middle(&own) < 0.01 && !said.contains("nearly black"), "{said}");
    }
    let folder = files(&format!("{QUAD}{LAMP}f 7 6 5\n"), "Ke 9 9 9");
    let (lit, said) = render(folder.path(), "--look-from=0,0,2.5 --look-at=0,0,0");
    assert!(said.is_empty(), "{said}");
    let (both, _) = render(folder.path(), "--look-from=0,0,2.5 --look-at=0,0,0 --light sky");
    assert!(middle(&both) > middle(&lit) + 0.1);
}

/// Scene files say what they want: they are told, not changed.
#[test]
fn scene_files_get_the_lamp_only_if_asked() {
    let folder = files(QUAD, "");
    let toml = "[[meshes]]\nfile = \"s.obj\"\n[[lights]]\ncenter = [0, 0, 9]\nedge_u = [1, 0, 0]\nedge_v = [0, 1, 0]\nradiance = [1, 1, 1]\n";
    fs::write(folder.path().join("t.toml"), toml).unwrap();
    let run = |options: &str| {
        let output = pmcip(folder.path(), &format!("render t.toml --size 16x16 --spp 4 {options}"));
        assert!(output.status.success());
        (read_exr(&folder.path().join("t.exr")).unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    let look = "--look-from=0,0,4 --look-at=0,0,0";
    let (dark, said) = run(look);
    assert!(middle(&dark) == 0.0 && said.contains("--light sky adds"), "{said}");
    assert!(said.contains("the lamp \"[[lights]] number 1\" shines away"), "{said}");
    let (lit, _) = run(&format!("{look} --light sky"));
    assert!(middle(&lit) > 0.1);
}

#[test]
fn samples_that_are_too_bright_are_counted_and_fail_above_a_hundredth() {
    let folder = files(&format!("{QUAD}{LAMP}f 7 6 5\n"), "Ke 1e25 1e25 1e25");
    let look = "--size 16x16 --spp 16 --look-from=0,0,2.5 --look-at=0,0,0 --quiet";
    for command in ["render s.obj", "render s.obj --frames 1", "reference s.obj -o r.exr"] {
        failure(folder.path(), &format!("{command} {look}"), 3, "are left out of the picture");
    }
    let folder = files(&format!("{QUAD}{LAMP}f 7 6 5\n"), "Ke 9 9 9");
    success(folder.path(), &format!("render s.obj {look}"));
}

#[test]
fn strict_files_are_refused() {
    let folder = files(&format!("{QUAD}f 1 2\n"), "");
    success(folder.path(), "render s.obj --size 8x8 --spp 1");
    for command in ["render s.obj --strict --size 8x8 --spp 1", "info s.obj --strict"] {
        failure(folder.path(), command, 2, "s.obj:8: face: expected at least 3 corners, found 2");
    }
}
