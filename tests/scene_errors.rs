//! Bad input: one clear line that names the file and, where it can, the line and the field.

mod scene_files;

use pmcip::scene::{Animation, LightChoice, Options, load};
use scene_files::folder;
use std::path::Path;

/// The message for the first of the given files, taken strictly, without the path of its folder.
fn message(files: &[(&str, &str)]) -> String {
    let dir = folder(files);
    let options = Options { strict: true, light: LightChoice::Own, ..Options::default() };
    let error = match Animation::open(&dir.path().join(files[0].0), &options) {
        Ok(animation) => animation.scene().require_light().expect_err("the input is accepted"),
        Err(error) => error,
    };
    let message = error.to_string();
    assert!(!message.contains('\n'), "more than one line: {message}");
    message.replace(&format!("{}{}", dir.path().display(), std::path::MAIN_SEPARATOR), "")
}

#[track_caller]
fn obj_fails(text: &str, expected: &str) {
    assert_eq!(message(&[("s.obj", text)]), expected);
}

#[track_caller]
fn mtl_fails(text: &str, expected: &str) {
    let obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";
    assert_eq!(message(&[("s.obj", obj), ("m.mtl", text)]), expected);
}

#[track_caller]
fn toml_fails(text: &str, expected: &str) {
    assert_eq!(message(&[("s.toml", text)]), expected);
}

const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[test]
fn files_that_are_not_there_are_named() {
    for name in ["nowhere/x.obj", "nowhere/x.toml"] {
        let message = load(Path::new(name)).unwrap_err().to_string();
        assert!(message.starts_with(&format!("{name}: ")), "{message}");
    }
    let message = message(&[("s.toml", "[[meshes]]\nfile = \"gone.obj\"\n")]);
    assert!(message.starts_with("gone.obj: "), "{message}");
}

#[test]
fn truncated_objs_name_the_line() {
    obj_fails(&format!("{CORNERS}v 1 1"), "s.obj:4: vertex: expected 3 numbers, found 2");
    obj_fails(&format!("{CORNERS}v 1 1 -"), "s.obj:4: vertex: expected a finite number, found \"-\"");
    obj_fails(&format!("{CORNERS}f 1 2"), "s.obj:4: face: expected at least 3 corners, found 2");
    obj_fails(&format!("{CORNERS}f"), "s.obj:4: face: expected at least 3 corners, found 0");
    obj_fails(
        &format!("{CORNERS}f 1 2 3/"),
        "s.obj: no light: give a material in the MTL file an emission (Ke)",
    );
    obj_fails(CORNERS, "s.obj: no faces");
    obj_fails("", "s.obj: no faces");
}

#[test]
fn indices_out_of_range_name_the_line_and_the_range() {
    let face = |f: &str| format!("{CORNERS}vt 0 0\n\nf {f}\n");
    let vertex = |given: &str| {
        format!("s.obj:6: face corner \"{given}\": index {given} is out of range, there are 3 so far")
    };
    obj_fails(&face("1 2 4"), "s.obj:6: face: vertex index 4 is out of range, there are 3");
    for index in ["0", "-4", "99999999999999"] {
        obj_fails(&face(&format!("1 {index} 2")), &vertex(index));
    }
    obj_fails(&face("1/1 2/2 3/1"), "s.obj:6: face: texture coordinate index 2 is out of range, there are 1");
    obj_fails(&face("1//1 2 3"), "s.obj:6: face: normal index 1 is out of range, there are 0");
    obj_fails(&face("1 2 x"), "s.obj:6: face corner \"x\": index is not a whole number");
    obj_fails(&face("1 2 3/1/1/1"), "s.obj:6: face corner \"3/1/1/1\": expected at most three indices");
}

#[test]
fn numbers_that_are_not_finite_name_the_line() {
    obj_fails(
        &format!("{CORNERS}v 0 nan 0\nf 1 2 3\n"),
        "s.obj:4: vertex: expected a finite number, found \"nan\"",
    );
    obj_fails(
        &format!("{CORNERS}v 0 1e99 0\nf 1 2 3\n"),
        "s.obj:4: vertex: expected a finite number, found \"1e99\"",
    );
    obj_fails(
        &format!("{CORNERS}vt inf 0\n"),
        "s.obj:4: texture coordinate: expected a finite number, found \"inf\"",
    );
}

#[test]
fn scenes_without_area_are_empty() {
    obj_fails("v 0 0 0\nv 1 0 0\nf 1 2 1\n", "s.obj: the scene is empty: no triangle has an area");
    toml_fails("", "s.toml: the scene is empty: no triangle has an area");
}

#[test]
fn material_files_name_line_material_and_key() {
    mtl_fails("newmtl m\nKd 1 x 1\n", "m.mtl:2: material \"m\": Kd: expected a finite number, found \"x\"");
    mtl_fails(
        "newmtl m\nKe 1 1\n",
        "m.mtl:2: material \"m\": Ke: expected a number, found the end of the line",
    );
    mtl_fails("newmtl m\nKs nan\n", "m.mtl:2: material \"m\": Ks: expected a finite number, found \"nan\"");
    mtl_fails("newmtl m\nNs\n", "m.mtl:2: material \"m\": Ns: expected a number, found the end of the line");
    mtl_fails("newmtl m\nTf a\n", "m.mtl:2: material \"m\": Tf: expected a finite number, found \"a\"");
    mtl_fails(
        "newmtl m\nillum two\n",
        "m.mtl:2: material \"m\": illum: expected a finite number, found \"two\"",
    );
    mtl_fails("newmtl\n", "m.mtl:1: material \"\": newmtl: expected a name");
    mtl_fails("newmtl m\nmap_Kd\n", "m.mtl:2: material \"m\": map_Kd: expected a name");
    mtl_fails("newmtl m\nNi 0\nillum 7\n", "m.mtl:2: material \"m\": Ni: expected an index above 0");
}

#[test]
fn scenes_without_light_say_what_to_add() {
    obj_fails(
        &format!("{CORNERS}f 1 2 3\n"),
        "s.obj: no light: give a material in the MTL file an emission (Ke)",
    );
    let sphere =
        "[[spheres]]\ncenter = [0, 0, 0]\nradius = 1\nsubdivisions = 1\nmaterial = \"m\"\n[materials.m]\n";
    toml_fails(sphere, "s.toml: no light: add [[lights]], a [sky] or a material with emission");
}

#[test]
fn meshes_that_can_be_made_say_how() {
    let mesh = "[[meshes]]\nfile = \"m.obj\"\n";
    toml_fails(&format!("made_by = \"make m\"\n{mesh}"), "m.obj: not there: run `make m` first");
    toml_fails(
        &format!("made_by = 1\n{mesh}"),
        "s.toml:1: invalid type: integer `1`, expected a string in `made_by`",
    );
}

#[test]
fn unknown_keys_name_key_and_line() {
    toml_fails(
        "[film]\nwidth = 8\nheigth = 8\n",
        "s.toml:3: unknown field `heigth`, expected one of `width`, `height`, `cd_per_unit`, `exposure` in `film`",
    );
    assert!(
        message(&[("s.toml", "\n[fog]\n")]).starts_with("s.toml:2: unknown field `fog`, expected one of")
    );
}

#[test]
fn values_out_of_range_name_key_and_line() {
    let size = "expected a size from 1 to 16384";
    toml_fails("[film]\nwidth = 0\n", &format!("s.toml:2: {size} in `film.width`"));
    toml_fails("[film]\nheight = 16385\n", &format!("s.toml:2: {size} in `film.height`"));
    toml_fails(
        "[film]\ncd_per_unit = inf\n",
        "s.toml:2: expected a finite number above 0 in `film.cd_per_unit`",
    );
    assert!(message(&[("s.toml", "[film]\nwidth = -1\n")]).starts_with("s.toml:2: "));
    assert!(message(&[("s.toml", "[film]\nwidth = \"a\"\n")]).starts_with("s.toml:2: "));
    assert!(message(&[("s.toml", "[render]\nspp = 0\n")]).starts_with("s.toml:2: "));
    let mesh = |key: &str| format!("[[meshes]]\nfile = \"a.obj\"\n{key}\n");
    toml_fails(&mesh("scale = 0"), "s.toml:3: expected finite factors other than 0 in `meshes.scale`");
    toml_fails(&mesh("scale = \"big\""), "s.toml:3: expected a number or three numbers in `meshes.scale`");
    toml_fails(
        &mesh("translate = [0, nan, 0]"),
        "s.toml:3: expected three finite numbers in `meshes.translate`",
    );
    let red = "[materials.red]\ndiffuse = [2, 0, 0]\n";
    toml_fails(red, "s.toml:2: expected three numbers from 0 to 1 in `materials.red.diffuse`");
    for roughness in ["0", "9e-7", "1.01", "nan"] {
        toml_fails(
            &format!("[materials.red]\nroughness = {roughness}\n"),
            "s.toml:2: expected a number from 0.000001 to 1 in `materials.red.roughness`",
        );
    }
    toml_fails("[film\n", "s.toml:1: unclosed table, expected `]`");
}

#[test]
fn cameras_that_see_nothing_name_the_line() {
    let camera = |from: &str, up: &str, fov: &str| {
        format!("[camera]\nfrom = {from}\nat = [0, 0, 0]\nup = {up}\nfov = {fov}\n")
    };
    let up = "[0, 1, 0]";
    toml_fails(&camera("[0, 0, 0]", up, "40"), "s.toml:1: camera: from and at are the same point");
    toml_fails(&camera("[0, 5, 0]", up, "40"), "s.toml:1: camera: up is parallel to the view");
    toml_fails(&camera("[0, 0, 5]", "[0, 0, 0]", "40"), "s.toml:1: camera: up has no direction");
    let angle = "s.toml:5: expected an angle between 0 and 180 degrees in `camera.fov`";
    toml_fails(&camera("[0, 0, 5]", up, "180"), angle);
    toml_fails(&camera("[0, 0, 5]", up, "nan"), angle);
    assert!(
        message(&[("s.toml", "[camera]\nfrom = [0, 0, 1]\n")]).starts_with("s.toml:1: missing field `at`")
    );
}

#[test]
fn names_that_lead_nowhere_name_the_line() {
    toml_fails(
        "[[meshes]]\nfile = \"a.obj\"\nmaterial = \"gold\"\n",
        "s.toml:3: material \"gold\" is not among [materials]",
    );
    let light =
        "[[lights]]\ncenter = [0, 0, 0]\nedge_u = [1, 0, 0]\nedge_v = [2, 0, 0]\nradiance = [1, 1, 1]\n";
    toml_fails(light, "s.toml:1: lights: edge_u and edge_v span no area");
}

#[test]
fn binary_files_do_no_harm() {
    let dir = tempfile::tempdir().unwrap();
    for name in ["s.obj", "s.toml"] {
        let path = dir.path().join(name);
        std::fs::write(&path, (0..=255u8).cycle().take(4096).collect::<Vec<_>>()).unwrap();
        assert!(!load(&path).unwrap_err().to_string().contains('\n'));
    }
}

/// The message of the first of the given files where a scene has so many bytes of memory.
fn message_within(memory: u64, files: &[(&str, &str)]) -> String {
    let dir = folder(files);
    let options = Options { light: LightChoice::Own, memory: Some(memory), ..Options::default() };
    let message =
        Animation::open(&dir.path().join(files[0].0), &options).map(|_| ()).unwrap_err().to_string();
    message.replace(&format!("{}{}", dir.path().display(), std::path::MAIN_SEPARATOR), "")
}

/// 360 bytes a triangle: 10 GB are full at the 22nd of these spheres, before any is made.
#[test]
fn spheres_of_more_triangles_than_there_is_memory_for_name_the_line() {
    let sphere = "[[spheres]]\ncenter = [0, 0, 0]\nradius = 1\nsubdivisions = 8\nmaterial = \"m\"\n";
    let text = format!("{}[materials.m]\n", sphere.repeat(40));
    assert_eq!(
        message_within(10_000_000_000, &[("s.toml", &text)]),
        "s.toml:109: subdivisions: not enough memory: with 28835840 triangles the scene takes 10.4 GB to load, \
         10.0 GB are free"
    );
    // No machine has 1.9 TB.
    let text = format!("{}[materials.m]\n", sphere.repeat(4096));
    let message = message(&[("s.toml", &text)]);
    assert!(message.contains(": subdivisions: ") && message.ends_with("are free"), "{message}");
    // A sphere that does not say how fine it is has a line, too.
    let message = message_within(1_000_000, &[("s.toml", &text.replace("subdivisions = 8\n", ""))]);
    assert!(
        message.starts_with("s.toml:4: subdivisions: not enough memory: with 81920 triangles"),
        "{message}"
    );
}

#[test]
fn what_a_few_words_repeat_is_counted() {
    let meshes = "[[meshes]]\nfile = \"m.obj\"\n".repeat(1000);
    let triangles = format!("{CORNERS}{}", "f 1 2 3\n".repeat(20));
    let refusal = message_within(20_000, &[("s.toml", &meshes), ("m.obj", &triangles)]);
    assert_eq!(
        refusal,
        "m.obj: not enough memory: with 60 triangles the scene takes 0.0 GB to load, 0.0 GB are free"
    );
    // Materials that nothing is made of.
    let names: String = (0..100).map(|i| format!("usemtl m{i}\n")).collect();
    let materials = format!("{CORNERS}{names}f 1 2 3\n");
    let refusal = message_within(200_000, &[("s.toml", &meshes), ("m.obj", &materials)]);
    assert!(refusal.starts_with("m.obj: not enough memory: with 800 materials"), "{refusal}");
}

#[test]
fn a_picture_without_room_is_an_error() {
    let obj = format!("mtllib m.mtl\n{CORNERS}usemtl m\nf 1 2 3\n");
    let dir = folder(&[("s.obj", &obj), ("m.mtl", "newmtl m\nmap_Kd t.png\n")]);
    image::RgbImage::new(100, 50).save(dir.path().join("t.png")).unwrap();
    let open = |memory| {
        let options = Options { light: LightChoice::Own, memory: Some(memory), ..Options::default() };
        Animation::open(&dir.path().join("s.obj"), &options).map(|animation| animation.scene().texels.len())
    };
    // Three times 12 bytes for each of 5000 texels while it is made linear, and a triangle.
    assert_eq!(open(181_000).unwrap(), 5000);
    let refusal = open(179_000).unwrap_err().to_string();
    assert!(
        refusal.contains("s.obj: a picture of 100×50: not enough memory: with 15000 texels"),
        "{refusal}"
    );
}

/// A file that is as long as it likes and holds nothing.
#[cfg(unix)]
#[test]
fn files_larger_than_memory_are_not_read() {
    let dir = tempfile::tempdir().unwrap();
    for name in ["s.obj", "s.toml", "s.gltf"] {
        let path = dir.path().join(name);
        std::fs::File::create(&path).unwrap().set_len(1 << 43).unwrap();
        let message = load(&path).unwrap_err().to_string();
        assert!(message.contains("not enough memory: the file has 8796.1 GB, "), "{message}");
    }
}
