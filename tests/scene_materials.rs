//! What the scene loader makes of MTL files and textures.

mod scene_files;

use pmcip::scene::{LoadedScene, load};
use pmcip_core::tracer::scene::{MIN_ROUGHNESS, Material, NO_TEXTURE, Scattering, Scene};
use scene_files::{SQUARE, folder, load_files};

/// The material of an OBJ that uses one called `m`.
fn material(mtl: &str) -> (Material, Vec<String>) {
    let obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";
    let scene = load_files(&[("scene.obj", obj), ("m.mtl", &format!("newmtl m\n{mtl}"))]);
    (scene.materials[scene.surfaces[0].material as usize], scene.warnings)
}

#[test]
fn materials_that_are_missing_are_grey_and_named() {
    let text = format!("mtllib gone.mtl\n{SQUARE}usemtl velvet\nf 1 2 3\n");
    let scene = load_files(&[("s.obj", &text)]);
    assert_eq!(scene.materials[0], Material::default());
    assert!(scene.warnings[0].contains("gone.mtl is missing"), "{:?}", scene.warnings);
    assert!(scene.warnings[1].contains("no MTL file defines \"velvet\""), "{:?}", scene.warnings);
    assert!(load_files(&[("s.obj", &format!("{SQUARE}f 1 2 3\n"))]).warnings.is_empty());
}

#[test]
fn material_files_may_have_blanks_in_their_names_or_be_several() {
    let mtl = |name: &str| format!("newmtl {name}\nKd 0 0 0\n");
    let both = format!(
        "mtllib a.mtl b.mtl\nmtllib c d.mtl\n{SQUARE}usemtl a\nf 1 2 3\nusemtl b\nf 1 2 4\nusemtl c d\nf 2 3 4\n"
    );
    let scene = load_files(&[
        ("scene.obj", &both),
        ("a.mtl", &mtl("a")),
        ("b.mtl", &mtl("b")),
        ("c d.mtl", &mtl("c d")),
    ]);
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    assert!(scene.materials.iter().all(|m| m.diffuse == [0.0; 3]));
}

#[test]
fn illumination_models_choose_the_scattering() {
    let kind = |mtl: &str| material(mtl).0.scattering;
    for model in [3, 5] {
        assert_eq!(kind(&format!("Ks 0.9 0.8 0.7\nillum {model}\n")), Scattering::Mirror);
    }
    // Something else is said: no mirror, but a lobe.
    for other in ["Kd 0.8 0.8 0.8\nKs 0.5 0.5 0.5\nNs 900", "Ks 1 1 1\nNs 1000", "Ks 1 1 1\nPr 0.1"] {
        assert_eq!(kind(&format!("{other}\nillum 3\n")), Scattering::Rough, "{other}");
    }
    assert_eq!(kind("Kd 0 0 0\nKs 0.9 0.9 0.9\nillum 3\n"), Scattering::Mirror);
    for model in [4, 6, 7, 9] {
        let model = |mtl: &str| kind(&format!("{mtl}\nillum {model}\n"));
        assert_eq!(model("Ni 1.33\nd 0.1"), Scattering::Dielectric);
        assert_eq!(model("Ni 1.33\nTf 0.9 0.9 0.9"), Scattering::Dielectric);
        // Where it is that or black, and nothing says opaque.
        assert_eq!(model("Kd 0 0 0\nNi 1.5"), Scattering::Dielectric);
        assert_eq!(model("Kd 0 0 0\nKs 1 1 1\nNi 1.5"), Scattering::Dielectric);
        for black in
            ["Ni 1.5\nd 1", "Ni 1.5\nTf 1 1 1", "Ni 1", "Ni 1.5\nKs 1 1 1\nNs 90", "Ni 1.5\nKe 1 1 1"]
        {
            assert_eq!(model(&format!("Kd 0 0 0\n{black}")), Scattering::Rough, "{black}");
        }
        for opaque in ["Ni 1.33", "Ni 1.33\nd 1", "Ni 1.45\nd 0.95", "d 0.1", "Ni 1\nTf 1 1 1", "Tf 0.5", ""]
        {
            assert_eq!(model(opaque), Scattering::Rough, "{opaque}");
        }
    }
    assert_eq!(kind("d 0.5\nNi 1.5\n"), Scattering::Dielectric);
    assert_eq!(kind("Tf 0.9 0.9 0.9\nNi 1.5\nillum 2\n"), Scattering::Dielectric);
    assert_eq!(kind("Tf 1 1 1\nd 1\nNi 1.5\nillum 2\n"), Scattering::Rough);
    assert_eq!(kind("d 0.5\nNi 1\n"), Scattering::Rough);
    assert_eq!(kind("d 0.5\n"), Scattering::Rough);
}

#[test]
fn material_values_arrive() {
    let (mirror, _) = material("Ks 0.9 0.8 0.7\nillum 5\n");
    assert_eq!(mirror.specular, [0.9, 0.8, 0.7]);
    let (glass, _) = material("Ks 0.1 0.1 0.1\nTf 0.2 0.2 0.2\nNi 1.33\nillum 7\n");
    assert_eq!((glass.ior, glass.specular), (1.33, [1.0; 3]));
    let (rough, warnings) = material("Kd 0.4\nKs 0.1 0.2 0.3 # comment\nNs 198\nKe 17 12 4\nillum 2\n");
    assert_eq!(
        (rough.diffuse, rough.specular, rough.emission),
        ([0.4; 3], [0.1, 0.2, 0.3], [17.0, 12.0, 4.0])
    );
    assert!((rough.roughness - 0.1).abs() < 1e-6);
    assert!(warnings.is_empty(), "{warnings:?}");
}

#[test]
fn what_is_there_is_stated_in_many_ways() {
    let opacity = |mtl: &str| material(mtl).0.opacity;
    for (mtl, part) in [
        ("", 1.0),
        ("d 0.25", 0.25),
        ("d -halo 0.25", 0.25),
        ("d 7", 1.0),
        ("Tr 0.25", 0.75),
        ("d 0.95\nNi 1.45\nillum 9", 0.95),
        ("d 1\nTr 1", 1.0),
        ("d 0.3\nTr 0.7", 0.3),
        ("Tr 1", 1.0),
        ("Tr 0", 1.0),
        ("Tf 0.5 0.5 0.5\nNi 1\nillum 4", 0.5),
        ("Tf 0 0 0\nillum 2", 1.0),
        // Glass is there as a whole.
        ("d 0.1\nNi 1.5", 1.0),
    ] {
        assert_eq!(opacity(mtl), part, "{mtl}");
    }
    for (mtl, word) in [("d 1\nTr 1", "contradict"), ("Tr 1", "Tr 1"), ("d 0", "d is 0"), ("Tf 0 0 0", "Tf")]
    {
        let (_, warnings) = material(mtl);
        assert!(warnings.iter().any(|w| w.contains(word)), "{mtl}: {warnings:?}");
    }
}

#[test]
fn metals_and_roughness_of_the_pbr_extension_arrive() {
    let (metal, _) = material("Kd 0.8 0.6 0.4\nPr 0.5\nPm 1\n");
    assert_eq!((metal.diffuse, metal.specular, metal.roughness), ([0.0; 3], [0.8, 0.6, 0.4], 0.25));
    let (plastic, _) = material("Kd 0.8 0.6 0.4\nPr 0.5\nPm 0\n");
    assert_eq!((plastic.diffuse, plastic.specular), ([0.8, 0.6, 0.4], [0.04; 3]));
}

#[test]
fn what_is_not_honoured_is_named_once() {
    let mtl = "Ka 1 1 1\nmap_Bump -bm 1 b.png\ndisp d.png\nPs 0.5\nnewmtl o\nmap_Bump b.png\nnewmtl p\nmap_Ns s.png\n";
    let (_, warnings) = material(mtl);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(
        warnings[0].ends_with("without effect here: Ps, disp, map_Bump (2 times), map_Ns"),
        "{warnings:?}"
    );
}

/// Exponents of which the lobe would be narrower than the core can make it, and those below 0.
#[test]
fn lobes_stay_within_the_range_of_widths() {
    for (exponent, width) in [("1e30", MIN_ROUGHNESS), ("2e12", MIN_ROUGHNESS), ("2e8", 1e-4), ("-3", 1.0)] {
        let (rough, _) = material(&format!("Ks 1 1 1\nNs {exponent}\n"));
        assert!((rough.roughness / width - 1.0).abs() < 1e-6, "Ns {exponent}: {}", rough.roughness);
    }
}

/// Whatever an MTL file holds, what is accepted must be a scene to the core.
#[test]
fn odd_material_values_make_a_scene_or_an_error() {
    for mtl in
        ["Ni 0", "Ns -3", "Ns 1e30", "Kd 9 9 9", "Ks -1 0 0", "illum 99", "d 0", "illum 5\nKs 2 2 2", "Tf 0"]
    {
        let scene = load_files(&[
            ("s.obj", &format!("mtllib m.mtl\n{SQUARE}usemtl m\nf 1 2 3\n")),
            ("m.mtl", &format!("newmtl m\n{mtl}\n")),
        ]);
        assert!(Scene::new(scene.data()).is_ok(), "{mtl}");
    }
}

#[test]
fn materials_that_would_make_light_are_clamped_or_named() {
    let (clamped, warnings) = material("Kd 1.5 0.5 -1\nKe -1 0 0\n");
    assert_eq!((clamped.diffuse, clamped.emission), ([1.0, 0.5, 0.0], [0.0; 3]));
    assert!(warnings.iter().any(|w| w.contains("material \"m\": Kd is outside 0 to 1")), "{warnings:?}");
    let (_, warnings) = material("Kd 0.8 0.8 0.8\nKs 0.9 0.9 0.9\n");
    assert!(warnings[0].contains("Kd + Ks is above 1"), "{warnings:?}");
}

/// A scene of one textured square; `image` is written as `picture.png`.
fn textured(map: &str, pixels: Option<image::RgbImage>) -> LoadedScene {
    let obj =
        format!("mtllib m.mtl\n{SQUARE}vt 0 0\nvt 1 0\nvt 1 1\nusemtl a\nf 1/1 2/2 3/3\nusemtl b\nf 1 3 4\n");
    let mtl = format!("newmtl a\nmap_Kd {map}\nnewmtl b\nKd 0.5 0.5 0.5\nmap_Kd {map}\n");
    let dir = folder(&[("scene.obj", &obj), ("m.mtl", &mtl)]);
    if let Some(pixels) = pixels {
        pixels.save(dir.path().join("picture.png")).unwrap();
    }
    load(&dir.path().join("scene.obj")).unwrap()
}

#[test]
fn textures_are_read_once_and_made_linear() {
    let pixels = image::RgbImage::from_fn(2, 1, |x, _| image::Rgb([255 * x as u8, 188, 10]));
    let scene = textured("picture.png", Some(pixels));
    assert_eq!((scene.textures.len(), scene.texels.len()), (1, 2));
    assert_eq!((scene.textures[0].width, scene.textures[0].height, scene.textures[0].first), (2, 1, 0));
    let error = |i: usize, v: f32| (scene.texels[0][i] - v).abs();
    assert!(error(0, 0.0) == 0.0 && error(1, 0.502_886) < 1e-5 && error(2, 0.003_035) < 1e-5);
    assert_eq!(scene.texels[1][0], 1.0);
    assert_eq!(
        scene.materials.iter().map(|m| (m.texture, m.diffuse[0])).collect::<Vec<_>>(),
        [(0, 1.0), (0, 0.5)]
    );
}

#[test]
fn textures_that_are_missing_or_broken_give_way_to_the_colour() {
    let scene = textured("picture.png", None);
    assert!(scene.warnings[0].contains("map_Kd") && scene.warnings[0].contains("picture.png"));
    assert!(scene.materials.iter().all(|m| m.texture == NO_TEXTURE && m.diffuse == [0.5; 3]));
    assert_eq!(textured("scene.obj", None).textures.len(), 0);
}

#[test]
fn texture_options_are_honoured_or_named() {
    let scene = textured("-s 2 3 1 -o 0.5 -clamp on picture.png", Some(image::RgbImage::new(1, 1)));
    let texture = scene.textures[0];
    assert_eq!((texture.scale, texture.offset, texture.clamp), ([2.0, 3.0], [0.5, 0.0], true));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    for map in ["-mm 0 1 picture.png", "picture.png -mm 0 1", "-bm 1 picture.png"] {
        let scene = textured(map, Some(image::RgbImage::new(1, 1)));
        assert_eq!(scene.textures.len(), 1, "{map}");
        assert!(
            scene.warnings.iter().any(|w| w.contains("without effect here: option -")),
            "{:?}",
            scene.warnings
        );
    }
}
