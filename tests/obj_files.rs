//! OBJ and MTL files as people have them: each kind of oddity, what is made of it, and what is said.

mod scene_files;

use pmcip::frame::render;
use pmcip::frame::settings::{Method, Settings};
use pmcip::scene::{Animation, Error, LightChoice, LoadedScene, Options, load};
use pmcip_core::tracer::scene::Scene;
use scene_files::folder;
use std::fs;
use std::path::Path;

/// A square that faces +z.
const V: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
const RED: &str = "newmtl m\nKd 1 0 0\n";

/// Files by name and content.
type Files<'a> = &'a [(&'a str, &'a [u8])];

fn open(files: Files<'_>, strict: bool) -> Result<LoadedScene, Error> {
    let dir = tempfile::tempdir().unwrap();
    for (name, content) in files {
        fs::create_dir_all(dir.path().join(name).parent().unwrap()).unwrap();
        fs::write(dir.path().join(name), content).unwrap();
    }
    let options = Options { strict, light: LightChoice::Own, ..Options::default() };
    Ok(Animation::open(&dir.path().join(files[0].0), &options)?.into_scene())
}

/// An OBJ of the square with material `m`, in these words.
fn red_square(obj: &str, mtl: &str) -> LoadedScene {
    open(&[("s.obj", obj.as_bytes()), ("s.mtl", mtl.as_bytes())], false).unwrap()
}

fn is_red(scene: &LoadedScene) -> bool {
    scene.surfaces.iter().all(|s| scene.materials[s.material as usize].diffuse == [1.0, 0.0, 0.0])
}

#[test]
fn lines_that_mean_nothing_are_left_out_and_counted_or_refused() {
    let square = |before: &str, after: &str| format!("{before}{V}{after}");
    let face = "f 1 2 3 4\n";
    // The file, triangles that remain, the line of the warning, its words.
    for (text, triangles, line, words) in [
        (
            square("", &format!("{face}f 1 2 9\nf 1 2 9\n")),
            2,
            6,
            "vertex index 9 is out of range, there are 4: face left out (2 of them)",
        ),
        (square("", &format!("{face}f 0 1 2\n")), 2, 6, "index 0 is out of range"),
        (square("", &format!("{face}f -5 1 2\n")), 2, 6, "index -5 is out of range"),
        (
            square("", &format!("{face}f 1 2\nf\n")),
            2,
            6,
            "at least 3 corners, found 2: face left out (2 of them)",
        ),
        (square("", &format!("{face}f 1 2 x\n")), 2, 6, "index is not a whole number"),
        (
            square("", "f 1//1 2//2 3//3 4//4\n"),
            2,
            5,
            "normal index 1 is out of range, there are 0: taken as flat there (4 of them)",
        ),
        (square("", "f 1/7 2/7 3/7 4/7\n"), 2, 5, "texture coordinate index 7 is out of range"),
        (square("", &format!("v nan 0 0\n{face}")), 2, 5, "vertex: expected a finite number, found \"nan\""),
        (square("", &format!("v 1\n{face}f 1 2 5\n")), 2, 5, "vertex: expected 3 numbers, found 1"),
        (square("vt nan 0\n", "f 1/1 2/1 3/1 4/1\n"), 2, 1, "texture coordinate: expected a finite number"),
        (square("vn 0 inf 0\n", "f 1//1 2//1 3//1 4//1\n"), 2, 1, "normal: expected a finite number"),
        (square("", &format!("usemtl\n{face}")), 2, 5, "usemtl: expected the name of a material"),
    ] {
        let scene = open(&[("s.obj", text.as_bytes())], false).unwrap();
        assert_eq!(scene.triangles.len(), triangles, "{text}");
        assert!(scene.surfaces.iter().all(|s| s.normals == [[0.0; 3]; 3]), "{text}");
        let said = scene.warnings.iter().any(|w| w.contains(&format!("s.obj:{line}: ")) && w.contains(words));
        assert!(said && scene.warnings.len() == 1, "{text}: {:?}", scene.warnings);
        let refused = open(&[("s.obj", text.as_bytes())], true).unwrap_err().to_string();
        assert!(refused.contains(&format!("s.obj:{line}: ")), "{refused}");
    }
    let nothing = open(&[("s.obj", b"v 0 0 0\nf 1 2 3\n")], false).unwrap_err().to_string();
    assert!(nothing.ends_with("s.obj:2: face: vertex index 2 is out of range, there are 1"), "{nothing}");
}

#[test]
fn material_lines_that_mean_nothing_are_left_out_or_refused() {
    let obj = format!("mtllib s.mtl\n{V}usemtl m\nf 1 2 3 4\n");
    for (line, words) in [
        ("Ks 1 x 1", "Ks: expected a finite number, found \"x\""),
        ("map_Kd", "map_Kd: expected a name"),
        ("Ns nan", "Ns: expected a finite number"),
        ("Ni 0", "Ni: expected an index above 0"),
        ("Ke", "Ke: expected a number, found the end of the line"),
        ("Ks spectral file.rfl 1", "another kind of colour"),
    ] {
        let mtl = format!("{RED}{line}\n");
        let scene = red_square(&obj, &mtl);
        assert!(is_red(&scene), "{line}");
        assert!(
            scene.warnings.iter().any(|w| w.contains("s.mtl:3: ") && w.contains(words)),
            "{:?}",
            scene.warnings
        );
        let files: Files<'_> = &[("s.obj", obj.as_bytes()), ("s.mtl", mtl.as_bytes())];
        assert!(open(files, true).unwrap_err().to_string().contains(words), "{line}");
    }
}

#[test]
fn text_is_read_however_it_is_written() {
    let obj = format!("mtllib s.mtl\n{V}usemtl m\nf 1 2 \\\n 3 4\n");
    let wide = |text: &str, word: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(word).collect::<Vec<u8>>();
    let ways: [fn(&str) -> Vec<u8>; 4] = [
        |text| [b"\xef\xbb\xbf", text.as_bytes()].concat(),
        |text| text.replace('\n', "\r\n").into_bytes(),
        |text| text.replace('\n', "\r").into_bytes(),
        |text| text.replace('\n', " \t\n").replace(' ', "\t  ").into_bytes(),
    ];
    for way in ways {
        let scene = open(&[("s.obj", &way(&obj)), ("s.mtl", &way(RED))], true).unwrap();
        assert!(
            is_red(&scene) && scene.triangles.len() == 2 && scene.warnings.is_empty(),
            "{:?}",
            scene.warnings
        );
    }
    let little = |text: &str| [b"\xff\xfe".to_vec(), wide(text, u16::to_le_bytes)].concat();
    let big = |text: &str| [b"\xfe\xff".to_vec(), wide(text, u16::to_be_bytes)].concat();
    assert!(is_red(&open(&[("s.obj", &little(&obj)), ("s.mtl", &big(RED))], true).unwrap()));
    // Decimal commas, as some countries write them.
    assert_eq!(
        red_square("v 0,5 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "").triangles[0].corners[0],
        [0.5, 0.0, 0.0]
    );
}

#[test]
fn names_are_found_with_comments_and_in_other_letters() {
    for (uses, defines, note) in [
        ("m # the floor", "m", None),
        ("m", "m # red", None),
        ("m\t# a", "m # b", None),
        ("a #1", "a #1", None),
        ("M", "m", Some("case of letters")),
    ] {
        let scene = red_square(
            &format!("mtllib s.mtl # here\n{V}usemtl {uses}\nf 1 2 3 4 # face\n"),
            &format!("newmtl other\nKd 0 0 0\nnewmtl {defines}\nKd 1 0 0 # red\n"),
        );
        assert!(is_red(&scene), "{uses} {defines}: {:?}", scene.warnings);
        assert_eq!(
            scene.warnings.iter().any(|w| w.contains(note.unwrap_or("grey"))),
            note.is_some(),
            "{uses}"
        );
    }
    // Two names that differ in what might be a comment stay two.
    let scene = red_square(
        &format!("mtllib s.mtl\n{V}usemtl a #2\nf 1 2 3 4\n"),
        "newmtl a #2\nKd 1 0 0\nnewmtl a #1\nKd 0 1 0\n",
    );
    assert!(is_red(&scene));
    let scene = red_square(&format!("mtllib s.mtl\n{V}usemtl m\nf 1 2 3 4\n"), "NEWMTL m\nkd 1 0 0\n");
    assert!(is_red(&scene) && scene.warnings[0].contains("NEWMTL (for newmtl)"), "{:?}", scene.warnings);
}

#[test]
fn material_files_are_found_by_what_they_are_called_elsewhere() {
    let name = |mtllib: &str| format!("{mtllib}{V}usemtl m\nf 1 2 3 4\n");
    for (mtllib, file) in [
        ("mtllib S.MTL\n", "s.mtl"),
        ("mtllib \"s.mtl\"\n", "s.mtl"),
        ("mtllib C:\\Users\\me\\s.mtl\n", "s.mtl"),
        ("mtllib /home/me/s.mtl\n", "s.mtl"),
        ("mtllib ./Mats\\s.mtl\n", "mats/s.mtl"),
        ("", "s.mtl"),
        ("mtllib gone.mtl\n", "s.mtl"),
    ] {
        let scene = open(&[("s.obj", name(mtllib).as_bytes()), (file, RED.as_bytes())], false).unwrap();
        assert!(is_red(&scene), "{mtllib}: {:?}", scene.warnings);
        assert!(!scene.warnings.is_empty(), "{mtllib}: found without a note");
    }
}

/// A picture of 2×1 pixels, red and green, in some format.
fn picture(format: image::ImageFormat) -> Vec<u8> {
    let pixels =
        image::RgbImage::from_fn(2, 1, |x, _| image::Rgb(if x == 0 { [255, 0, 0] } else { [0, 255, 0] }));
    let mut bytes = std::io::Cursor::new(Vec::new());
    let picture = image::DynamicImage::ImageRgb8(pixels);
    let picture = match format {
        image::ImageFormat::Hdr | image::ImageFormat::OpenExr => {
            image::DynamicImage::ImageRgb32F(picture.into_rgb32f())
        }
        _ => picture,
    };
    picture.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

#[test]
fn pictures_of_every_format_and_name_are_found() {
    use image::ImageFormat::{Bmp, Gif, Hdr, OpenExr, Png, Tga, Tiff, WebP};
    for (statement, file, format, note) in [
        ("t.tga", "t.tga", Tga, false),
        ("t.bmp", "t.bmp", Bmp, false),
        ("t.tif", "t.tif", Tiff, false),
        ("t.webp", "t.webp", WebP, false),
        ("t.gif", "t.gif", Gif, false),
        ("t.hdr", "t.hdr", Hdr, false),
        ("t.exr", "t.exr", OpenExr, false),
        ("a b.png", "a b.png", Png, false),
        ("t.png # wood", "t.png", Png, false),
        ("\"a b.png\"", "a b.png", Png, true),
        ("T.PNG", "t.png", Png, true),
        ("C:\\tex\\t.png", "t.png", Png, true),
        ("textures\\T.png", "Textures/t.png", Png, true),
        ("t.png", "t.png", Bmp, false),
        ("t.jpg", "t.jpg", Png, false),
        ("-clamp on t.png -s 2 2 2", "t.png", Png, false),
        ("t.png -s 2 2 2 -clamp on", "t.png", Png, false),
    ] {
        let obj = format!("mtllib s.mtl\n{V}vt 0 0\nusemtl m\nf 1/1 2/1 3/1 4/1\n");
        let mtl = format!("newmtl m\nmap_Kd {statement}\n");
        let files: Files<'_> =
            &[("s.obj", obj.as_bytes()), ("s.mtl", mtl.as_bytes()), (file, &picture(format))];
        let scene = open(files, false).unwrap();
        assert_eq!(scene.textures.len(), 1, "{statement}: {:?}", scene.warnings);
        let close = |a: [f32; 3], b: [f32; 3]| (0..3).all(|i| (a[i] - b[i]).abs() < 0.01);
        let [first, second] = [scene.texels[0], scene.texels[1]];
        assert!(
            close(first, [1.0, 0.0, 0.0]) && close(second, [0.0, 1.0, 0.0]),
            "{statement}: {first:?} {second:?}"
        );
        assert_eq!(!scene.warnings.is_empty(), note, "{statement}: {:?}", scene.warnings);
        let has_options = statement.contains("-clamp");
        assert_eq!((scene.textures[0].clamp, scene.textures[0].scale[0] == 2.0), (has_options, has_options));
    }
}

#[test]
fn concave_polygons_keep_their_notches() {
    let area = |text: &str| {
        let scene = open(&[("s.obj", text.as_bytes())], true).unwrap();
        let area = |t: &pmcip_core::tracer::scene::Triangle| {
            let [a, b, c] = t.corners.map(glam::Vec3::from);
            (b - a).cross(c - a)
        };
        scene.triangles.iter().map(area).sum::<glam::Vec3>() * 0.5
    };
    let corners = "v -1 .1 1\nv 1 .1 1\nv 0 .1 0\nv 1 .1 -1\nv -1 .1 -1\n";
    for face in ["f 1 2 3 4 5", "f 2 3 4 5 1", "f 3 4 5 1 2"] {
        assert!(
            (area(&format!("{corners}{face}\n")) - glam::Vec3::new(0.0, 3.0, 0.0)).length() < 1e-5,
            "{face}"
        );
    }
    assert!((area(&format!("{corners}f 5 4 3 2 1\n")).y + 3.0).abs() < 1e-5);
}

/// Triangles that no box tells apart: equal ones, fans, discs.
#[test]
fn any_number_of_equal_or_coplanar_triangles_is_a_scene() {
    let disc: String = (0..1000)
        .map(|i| {
            let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 1000.0).sin_cos();
            format!("v {cos} {sin} 0\n")
        })
        .collect();
    let corners: String = (1..=1000).map(|i| format!(" {i}")).collect();
    let cube = "f 1 2 3 4\nf 5 8 7 6\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 5 1 4 8\n".repeat(150);
    let cube = format!("{V}v 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n{cube}");
    for (text, triangles) in [
        (format!("{V}{}", "f 1 2 3 4\n".repeat(300)), 600),
        (format!("{V}{}", "f 1 2 3\n".repeat(20_000)), 20_000),
        (format!("{disc}f{corners}\n"), 998),
        (cube, 1800),
    ] {
        let scene = open(&[("s.obj", text.as_bytes())], false).unwrap();
        assert_eq!(scene.triangles.len(), triangles);
        assert_eq!(Scene::new(scene.data()).err(), None);
    }
}

/// The box of the project's own scene, moved away.
fn box_at([x, y, z]: [f64; 3]) -> LoadedScene {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let room = fs::read_to_string(scenes.join("cornell-room.obj")).unwrap();
    let moved: String = room
        .lines()
        .map(|line| match line.strip_prefix("v ") {
            Some(rest) => {
                let v: Vec<f64> = rest.split_whitespace().map(|v| v.parse().unwrap()).collect();
                format!("v {} {} {}\n", v[0] + x, v[1] + y, v[2] + z)
            }
            None => format!("{line}\n"),
        })
        .collect();
    let toml = format!(
        "[camera]\nfrom = [{}, {}, {}]\nat = [{}, {}, {}]\nfov = 39.3\n[[meshes]]\nfile = \"room.obj\"\n\
         [[lights]]\ncenter = [{}, {}, {}]\nedge_u = [65, 0, 0]\nedge_v = [0, 0, 52.5]\nradiance = [18, 11, 3]\n",
        278.0 + x,
        273.0 + y,
        -800.0 + z,
        278.0 + x,
        273.0 + y,
        z,
        278.0 + x,
        547.8 + y,
        279.5 + z,
    );
    let dir = folder(&[("s.toml", &toml), ("room.obj", &moved)]);
    fs::copy(scenes.join("cornell.mtl"), dir.path().join("cornell.mtl")).unwrap();
    load(&dir.path().join("s.toml")).unwrap()
}

fn energy(scene: &LoadedScene) -> f64 {
    let settings = Settings::new(scene, Method::Uniform, Some(32), Some((32, 32)));
    let frame = render::render(scene, &settings, None, &|_| ()).unwrap();
    frame.rgb.as_flattened().iter().map(|v| f64::from(*v)).sum()
}

/// With the same random numbers, so that noise is the same as well: a room keeps its energy at a million units.
#[test]
fn rooms_keep_their_energy_far_from_the_origin() {
    let near = energy(&box_at([0.0; 3]));
    for place in [[1e6, 0.0, 0.0], [500_000.0, 4e6, 100.0], [-3e5, 2e4, 1e6]] {
        let scene = box_at(place);
        assert!(scene.origin != [0.0; 3]);
        let far = energy(&scene);
        assert!((far / near - 1.0).abs() < 5e-4, "{place:?}: {far} instead of {near}");
    }
}

#[test]
fn colours_of_vertices_are_read_in_every_dialect() {
    let triangle = |colour: [&str; 3], more: &str| {
        let [a, b, c] = colour;
        let text = format!("v 0 0 0{a}\nv 1 0 0{b}\nv 0 1 0{c}\n{more}f 1 2 3\n");
        open(&[("s.obj", text.as_bytes())], false).unwrap()
    };
    let red = [1.0, 0.0, 0.0];
    let expected = [[red, [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]];
    assert_eq!(triangle([" 1 0 0", " 0 1 0", " 0 0 1"], "").colours, expected);
    assert_eq!(triangle([" 255 0 0", " 0 255 0", " 0 0 255"], "").colours, expected);
    assert_eq!(triangle([" 1 0 0 1", " 0 1 0 1", " 0 0 1 1"], "").colours, expected);
    assert_eq!(triangle(["", "", ""], "#MRGB ffff0000ff00ff00ff0000ff\n").colours, expected);
    assert_eq!(triangle([" 1 0 0", "", ""], "").colours, [[red, [1.0; 3], [1.0; 3]]]);
    assert!(triangle([" 1", " 1", " 1"], "").colours.is_empty());
}

#[test]
fn other_files_are_told_what_they_are() {
    for (name, content, words) in [
        ("s.obj", &b"version https://git-lfs.github.com/spec/v1\n"[..], "Git LFS pointer"),
        ("s.obj", b"\x1f\x8b\x08\0\0\0", "gzip"),
        ("s.obj", b"<!DOCTYPE html>\n<html>", "HTML"),
        ("s.ply", b"ply\nformat ascii 1.0\n", "PLY"),
        ("s.stl", b"solid thing\n", "STL"),
        ("s.toml", b"v 0 0 0\nv 1 0 0\nf 1 2 3\n", "seems to be an OBJ"),
    ] {
        let message = open(&[(name, content)], false).unwrap_err().to_string();
        assert!(message.contains(words) && !message.contains('\n'), "{message}");
    }
}

/// Points, lines and curves make no surface: said once.
#[test]
fn what_is_no_surface_is_counted() {
    let text = format!("{V}l 1 2\nl 2 3\np 1\nf 1 2 3 4\n");
    let scene = open(&[("s.obj", text.as_bytes())], true).unwrap();
    assert!(
        scene.warnings[0].ends_with("points, lines and curves are left out: 2 l, 1 p"),
        "{:?}",
        scene.warnings
    );
}

/// Not a measurement: quadratic time would need minutes.
#[test]
fn many_materials_load() {
    let count = 20_000;
    let obj: String = (0..count).map(|i| format!("usemtl m{i}\nf 1 2 3\n")).collect();
    let mtl: String =
        (0..count).map(|i| format!("newmtl m{i}\nKd 2 0 0\nmap_Bump b.png\nmap_Kd gone{i}.png\n")).collect();
    let scene = red_square(&format!("mtllib s.mtl\n{V}{obj}"), &mtl);
    assert_eq!(scene.materials.len(), count);
    assert!(scene.warnings.len() < 8, "{} warnings", scene.warnings.len());
}
