//! glTF files: what stands in them is what arrives in the scene and in the picture, and what cannot be is said.

mod gltf_files;
mod program;

use gltf_files::{Gltf, U8, U16, U32, picture, png};
use pmcip::bake::atlas::Fineness;
use pmcip::bake::second;
use pmcip::frame::render::render;
use pmcip::frame::settings::{Method, Settings};
use pmcip::scene::{Animation, LightChoice, LoadedScene, Options, load};
use pmcip_core::tracer::scene::{Material, NO_TEXTURE, Scattering};
use serde_json::{Value, json};
use std::f64::consts::PI;

fn loaded(gltf: &Gltf) -> LoadedScene {
    let (_folder, path) = gltf.written();
    load(&path).unwrap()
}

fn refused(gltf: &Gltf) -> String {
    let (_folder, path) = gltf.written();
    let message = load(&path).unwrap_err().to_string();
    assert!(!message.contains('\n'), "{message}");
    message
}

/// The material of the first triangle.
fn material(scene: &LoadedScene) -> Material {
    scene.materials[scene.surfaces[0].material as usize]
}

/// The material that comes of one.
fn converted(stated: Value) -> (Material, Vec<String>) {
    let scene = loaded(&Gltf::new().with_square(stated));
    (material(&scene), scene.warnings)
}

#[track_caller]
fn near<const N: usize>(a: [f32; N], b: [f32; N], limit: f32) {
    assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= limit), "{a:?} is not {b:?}");
}

/// The sums of all triangles' area vectors and positions, which no order of them changes.
fn sums(scene: &LoadedScene) -> (usize, [f32; 3], [f32; 3]) {
    let mut sums = ([0.0; 3], [0.0; 3]);
    for triangle in &scene.triangles {
        let [a, b, c] = triangle.corners.map(glam::Vec3::from);
        let area = 0.5 * (b - a).cross(c - a);
        (0..3).for_each(|i| (sums.0[i], sums.1[i]) = (sums.0[i] + area[i], sums.1[i] + (a + b + c)[i]));
    }
    (scene.triangles.len(), sums.0, sums.1)
}

#[test]
fn all_kinds_of_triangles_are_read_from_text_and_binary() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    let unindexed = [0, 1, 2, 2, 1, 3].map(|i: usize| corners[i]);
    let fan = [corners[0], corners[1], corners[3], corners[2]];
    let folder = tempfile::tempdir().unwrap();
    for (mode, positions, indices) in [
        (4, corners.to_vec(), Some((vec![0, 1, 2, 2, 1, 3], U8))),
        (4, corners.to_vec(), Some((vec![0, 1, 2, 2, 1, 3], U16))),
        (4, corners.to_vec(), Some((vec![0, 1, 2, 2, 1, 3], U32))),
        (4, unindexed.to_vec(), None),
        (5, corners.to_vec(), None),
        (5, corners.to_vec(), Some((vec![0, 1, 2, 3], U16))),
        (6, fan.to_vec(), None),
    ] {
        let mut gltf = Gltf::new();
        let mut primitive = json!({ "attributes": { "POSITION": gltf.vectors(&positions) }, "mode": mode });
        if let Some((indices, component)) = indices {
            primitive["indices"] = json!(gltf.indices(&indices, component));
        }
        let mesh = gltf.mesh(primitive);
        gltf.add("nodes", json!({ "mesh": mesh }));
        for name in ["s.gltf", "s.glb"] {
            let scene = load(&gltf.write(folder.path(), name)).unwrap();
            assert_eq!(sums(&scene).0, 2, "{mode}");
            near(sums(&scene).1, [0.0, 0.0, 1.0], 1e-6);
        }
    }
}

#[test]
fn nodes_carry_one_another() {
    let mut gltf = Gltf::new();
    let mesh = gltf.square(None);
    // x to y, y to −x, then five up z; a child that is mirrored in x and twice as high.
    gltf.add(
        "nodes",
        json!({ "children": [1], "matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1] }),
    );
    gltf.add(
        "nodes",
        json!({ "mesh": mesh, "translation": [3, 0, 0], "scale": [-1, 2, 1], "children": [2] }),
    );
    gltf.add("nodes", json!({ "mesh": mesh, "translation": [0, 0, -1], "rotation": [0, 0, 1, 0] }));
    // A node of no scene is not shown.
    gltf.add("nodes", json!({ "mesh": mesh }));
    gltf.add("scenes", json!({ "nodes": [0] }));
    let scene = loaded(&gltf);
    let (count, areas, positions) = sums(&scene);
    assert_eq!(count, 4);
    // Both squares have 8 units, and still face +z: winding is that of the placed corners.
    near(areas, [0.0, 0.0, 16.0], 1e-5);
    // Six corners each around (0, 3, 5) and (0, 3, 4).
    near(positions, [0.0, 36.0, 54.0], 1e-4);
    assert_eq!(scene.objects.iter().max(), Some(&1));
}

#[test]
fn sparse_and_normalised_numbers_are_read() {
    let mut gltf = Gltf::new();
    let mesh = gltf.square(None);
    let (indices, values) = (gltf.view(&[2]), gltf.view(&[5.0f32, 6.0, 0.0].map(f32::to_le_bytes).concat()));
    gltf.json["accessors"][0]["sparse"] = json!({ "count": 1, "indices": { "bufferView": indices, "componentType": U8 },
        "values": { "bufferView": values } });
    let uvs = gltf.view(&[0, 51, 0, 0, 255, 102, 0, 0, 255, 255, 0, 0, 0, 0, 0, 0]);
    gltf.json["bufferViews"][uvs]["byteStride"] = json!(4);
    let uvs = gltf.add(
        "accessors",
        json!({ "bufferView": uvs, "componentType": U8, "normalized": true, "count": 4, "type": "VEC2" }),
    );
    gltf.json["meshes"][mesh]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uvs);
    gltf.add("nodes", json!({ "mesh": mesh }));
    let scene = loaded(&gltf);
    let corners: Vec<_> = scene
        .triangles
        .iter()
        .zip(&scene.surfaces)
        .flat_map(|(t, s)| t.corners.into_iter().zip(s.uv))
        .collect();
    let uv = |at: [f32; 3]| corners.iter().find(|corner| corner.0 == at).unwrap().1;
    // v is counted upwards.
    near(uv([-1.0, -1.0, 0.0]), [0.0, 0.8], 1e-6);
    near(uv([1.0, -1.0, 0.0]), [1.0, 0.6], 1e-6);
    near(uv([5.0, 6.0, 0.0]), [1.0, 0.0], 1e-6);
}

#[test]
fn metal_and_plastic_are_diffuse_and_a_lobe() {
    let of = |pbr: Value| converted(json!({ "pbrMetallicRoughness": pbr })).0;
    let plastic =
        of(json!({ "baseColorFactor": [0.5, 0.25, 1, 1], "metallicFactor": 0, "roughnessFactor": 0.5 }));
    near(plastic.diffuse, [0.48, 0.24, 0.96], 1e-6);
    near(plastic.specular, [0.04; 3], 1e-6);
    assert_eq!((plastic.roughness, plastic.opacity), (0.25, 1.0));
    let metal = of(json!({ "baseColorFactor": [1, 0.5, 0.25, 1], "roughnessFactor": 0.1 }));
    assert_eq!(metal.diffuse, [0.0; 3]);
    near(metal.specular, [1.0, 0.5, 0.25], 1e-6);
    near([metal.roughness], [0.01], 1e-6);
    let half = of(json!({ "baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0.5 }));
    near(half.diffuse, [0.24; 3], 1e-6);
    near(half.specular, [0.27; 3], 1e-6);
    let with = |extensions: Value| {
        converted(json!({ "pbrMetallicRoughness": { "metallicFactor": 0 }, "extensions": extensions })).0
    };
    assert_eq!(with(json!({ "KHR_materials_ior": { "ior": 1.0 } })).specular, [0.0; 3]);
    near(with(json!({ "KHR_materials_ior": { "ior": 3.0 } })).specular, [0.25; 3], 1e-6);
    let specular = json!({ "specularFactor": 0.5, "specularColorFactor": [1, 2, 100] });
    near(with(json!({ "KHR_materials_specular": specular })).specular, [0.02, 0.04, 0.5], 1e-6);
    let unlit = with(json!({ "KHR_materials_unlit": {} }));
    assert_eq!((unlit.diffuse, unlit.specular), ([1.0; 3], [0.0; 3]));
}

#[test]
fn what_shines_has_its_strength() {
    let stated = json!({ "emissiveFactor": [1, 0.5, 0], "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 8 } } });
    let scene = loaded(&Gltf::new().with_square(stated));
    assert_eq!(material(&scene).emission, [8.0, 4.0, 0.0]);
    assert_eq!(scene.cd_per_unit, 1.0);
    // By a texture: half of it black.
    let mut gltf = Gltf::new();
    let texture = gltf.texture(&picture(2, &[[255, 255, 255, 255], [0, 0, 0, 255]]));
    let stated = json!({ "emissiveFactor": [1, 0.5, 0], "emissiveTexture": { "index": texture } });
    let scene = loaded(&gltf.with_square(stated));
    let shine = material(&scene).emission_texture;
    let texture = scene.textures[shine as usize];
    assert_eq!(scene.texels[texture.first as usize..][..2], [[1.0, 0.5, 0.0], [0.0; 3]]);
}

#[test]
fn glass_is_what_encloses_a_volume_or_is_closed() {
    let glass = json!({ "pbrMetallicRoughness": { "baseColorFactor": [0.5, 1, 1, 1], "metallicFactor": 0, "roughnessFactor": 0 },
        "extensions": { "KHR_materials_transmission": { "transmissionFactor": 1 }, "KHR_materials_ior": { "ior": 1.4 } } });
    let mut solid = glass.clone();
    solid["extensions"]["KHR_materials_volume"] = json!({ "thicknessFactor": 1 });
    let (solid, _) = converted(solid);
    assert_eq!((solid.scattering, solid.ior, solid.specular), (Scattering::Dielectric, 1.4, [0.5, 1.0, 1.0]));
    // A sheet is mostly not there, and what is there mirrors.
    let (sheet, _) = converted(glass.clone());
    let reflected = (0.4f32 / 2.4).powi(2);
    assert_eq!(sheet.scattering, Scattering::Rough);
    near([sheet.opacity], [reflected], 1e-6);
    near(sheet.diffuse, [0.0; 3], 1e-6);
    near(sheet.specular, [1.0; 3], 1e-5);
    // A tetrahedron has no border.
    let mut gltf = Gltf::new();
    let stated = gltf.add("materials", glass);
    let positions = gltf.vectors(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let indices = gltf.indices(&[0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3], U16);
    let mesh =
        gltf.mesh(json!({ "attributes": { "POSITION": positions }, "indices": indices, "material": stated }));
    gltf.add("nodes", json!({ "mesh": mesh }));
    assert_eq!(material(&loaded(&gltf)).scattering, Scattering::Dielectric);
}

#[test]
fn each_alpha_mode_is_what_it_says() {
    let of = |mode: &str, cutoff: Option<f32>, factor: f32, textured: bool| {
        let mut gltf = Gltf::new();
        let mut stated =
            json!({ "alphaMode": mode, "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, factor] } });
        if let Some(cutoff) = cutoff {
            stated["alphaCutoff"] = json!(cutoff);
        }
        if textured {
            let texture = gltf.texture(&picture(3, &[[9, 9, 9, 0], [9, 9, 9, 102], [9, 9, 9, 255]]));
            stated["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": texture });
        }
        let scene = loaded(&gltf.with_square(stated));
        let material = material(&scene);
        let mask = scene.textures.get(material.opacity_texture as usize);
        let alphas = mask.map(|mask| scene.texels[mask.first as usize..][..3].iter().map(|t| t[0]).collect());
        (material.opacity, alphas.unwrap_or_default())
    };
    assert_eq!(of("OPAQUE", None, 0.5, true), (1.0, vec![]));
    assert_eq!(of("MASK", None, 1.0, true), (1.0, vec![0.0, 0.0, 1.0]));
    assert_eq!(of("MASK", Some(0.4), 1.0, true), (1.0, vec![0.0, 1.0, 1.0]));
    assert_eq!(of("MASK", Some(0.4), 0.5, true), (1.0, vec![0.0, 0.0, 1.0]));
    assert_eq!(of("MASK", Some(0.4), 0.5, false), (1.0, vec![]));
    assert_eq!(of("MASK", None, 0.4, false), (0.0, vec![]));
    assert_eq!(of("BLEND", None, 0.25, false), (0.25, vec![]));
    let (opacity, alphas) = of("BLEND", None, 0.5, true);
    assert_eq!(opacity, 1.0);
    near([alphas[0], alphas[1], alphas[2]], [0.0, 0.2, 0.5], 1e-6);
}

/// A square of radiance 2 that just fills the view, half of its texture opaque: what is there shines.
#[test]
fn alpha_modes_are_seen() {
    let of = |mode: &str, factor: f32| {
        let mut gltf = Gltf::new();
        let texture = gltf.texture(&picture(2, &[[255, 255, 255, 0], [255, 255, 255, 255]]));
        let lens = json!({ "yfov": 2.0 * 0.5f64.atan(), "znear": 0.1 });
        let camera = gltf.add("cameras", json!({ "type": "perspective", "perspective": lens }));
        gltf.add("nodes", json!({ "camera": camera, "translation": [0, 0, 2] }));
        let pbr = json!({ "baseColorFactor": [1, 1, 1, factor], "baseColorTexture": { "index": texture } });
        let stated = json!({ "alphaMode": mode, "emissiveFactor": [2, 2, 2], "pbrMetallicRoughness": pbr });
        loaded(&gltf.with_square(stated))
    };
    for (mode, factor, expected) in [("OPAQUE", 0.5, 2.0), ("MASK", 1.0, 1.0), ("BLEND", 0.5, 0.5)] {
        shows(&of(mode, factor), expected, mode);
    }
    assert_eq!(mean(&of("MASK", 0.4), 16).0, 0.0);
}

#[test]
fn pictures_come_from_views_data_and_files() {
    let red_green = picture(2, &[[255, 0, 0, 255], [0, 188, 0, 255]]);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a picture.png"), png(&red_green)).unwrap();
    for kind in ["view", "data:image/png;base64,", "a%20picture.png"] {
        let mut gltf = Gltf::new();
        let texture = gltf.texture(&red_green);
        let encoded = base64::Engine::encode(&base64::prelude::BASE64_STANDARD, png(&red_green));
        match kind {
            "view" => {}
            "a%20picture.png" => gltf.json["images"][0] = json!({ "uri": kind }),
            _ => gltf.json["images"][0] = json!({ "uri": format!("{kind}{encoded}") }),
        }
        let gltf = gltf.with_square(json!({ "pbrMetallicRoughness": { "metallicFactor": 0, "baseColorTexture": { "index": texture } } }));
        let scene = load(&gltf.write(folder.path(), "s.glb")).unwrap();
        let texture = scene.textures[material(&scene).texture as usize];
        assert_eq!((texture.width, texture.height), (2, 1), "{kind}");
        let texels: Vec<[f32; 3]> = scene.texels[texture.first as usize..][..2].to_vec();
        assert_eq!(texels[0], [1.0, 0.0, 0.0]);
        // 188 is 0.5029 by IEC 61966-2-1.
        near(texels[1], [0.0, 0.5029, 0.0], 1e-4);
    }
}

#[test]
fn transforms_of_textures_are_those_of_the_extension() {
    let laid = |transform: Value| {
        let mut gltf = Gltf::new();
        let texture = gltf.texture(&picture(1, &[[255; 4]]));
        let info = json!({ "index": texture, "extensions": { "KHR_texture_transform": transform } });
        let stated = json!({ "pbrMetallicRoughness": { "metallicFactor": 0, "baseColorTexture": info } });
        let scene = loaded(&gltf.with_square(stated));
        let texture = scene.textures[material(&scene).texture as usize];
        // Where the texture is looked up at the corner (1, 1, 0), whose coordinates are (1, 0), and at (−1, −1, 0), of (0, 1);
        // v counted downwards.
        [[1.0, 1.0, 0.0], [-1.0, -1.0, 0.0]].map(|at: [f32; 3]| {
            let corners = scene
                .triangles
                .iter()
                .zip(&scene.surfaces)
                .flat_map(|(t, s)| t.corners.into_iter().zip(s.uv));
            let uv = corners.into_iter().find(|corner| corner.0 == at).unwrap().1;
            let [u, v] = [0, 1].map(|i| uv[i] * texture.scale[i] + texture.offset[i]);
            [u, 1.0 - v]
        })
    };
    let [right, below] = laid(json!({ "offset": [0.25, 0.5], "scale": [2, 3] }));
    near(right, [2.25, 0.5], 1e-6);
    near(below, [0.25, 3.5], 1e-6);
    // A quarter of a turn counter-clockwise as it is seen: what was to the right is above, at −v.
    let [right, below] = laid(json!({ "rotation": PI / 2.0 }));
    near(right, [0.0, -1.0], 1e-6);
    near(below, [1.0, 0.0], 1e-6);
    let [right, below] = laid(json!({ "rotation": PI / 2.0, "scale": [2, 3], "offset": [0.5, 0.25] }));
    near(right, [0.5, -1.75], 1e-6);
    near(below, [3.5, 0.25], 1e-6);
}

#[test]
fn mirrored_textures_are_followed_by_their_image() {
    let mut gltf = Gltf::new();
    let texture = gltf.texture(&picture(2, &[[255, 0, 0, 255], [0, 0, 255, 255]]));
    gltf.add("samplers", json!({ "wrapS": 33648, "wrapT": 10497 }));
    gltf.json["textures"][texture]["sampler"] = json!(0);
    let stated =
        json!({ "pbrMetallicRoughness": { "metallicFactor": 0, "baseColorTexture": { "index": texture } } });
    let scene = loaded(&gltf.with_square(stated));
    let texture = scene.textures[material(&scene).texture as usize];
    assert_eq!((texture.width, texture.height, texture.scale, texture.offset), (4, 1, [0.5, 1.0], [0.0; 2]));
    let (red, blue) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    assert_eq!(scene.texels[texture.first as usize..][..4], [red, blue, blue, red]);
}

#[test]
fn colours_of_vertices_are_linear() {
    let mut gltf = Gltf::new();
    let stated = gltf.add("materials", json!({ "pbrMetallicRoughness": { "metallicFactor": 0 } }));
    let mesh = gltf.square(Some(stated));
    let colours = gltf.vectors(&[[0.5, 0.25, 1.0]; 4]);
    gltf.json["meshes"][mesh]["primitives"][0]["attributes"]["COLOR_0"] = json!(colours);
    gltf.add("nodes", json!({ "mesh": mesh }));
    assert_eq!(loaded(&gltf).colours, [[[0.5, 0.25, 1.0]; 3]; 2]);
}

/// Mean of the green channel over a picture of 8×8 pixels, and its standard error.
fn mean(scene: &LoadedScene, spp: u32) -> (f64, f64) {
    let mut settings = Settings::new(scene, Method::Uniform, Some(spp), Some((8, 8)));
    settings.max_depth = 2;
    let frame = render(scene, &settings, None, &|_| ()).unwrap();
    assert_eq!(frame.tally.rejected, 0);
    let sum: f64 = frame.rgb.iter().map(|rgb| f64::from(rgb[1])).sum();
    let variance: f64 = frame.variance.iter().map(|v| f64::from(*v)).sum();
    (sum / 64.0, variance.sqrt() / 64.0)
}

/// A diffuse square of reflectance ½ at z = 0, a camera above it that looks straight down at its middle ±0.02, and a light
/// of `kind` and intensity 10 at a node.
fn lit(kind: Value, node: Value) -> LoadedScene {
    let stated = json!({ "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0 },
        "extensions": { "KHR_materials_ior": { "ior": 1 } } });
    let mut gltf = Gltf::new().with_square(stated);
    let camera =
        gltf.add("cameras", json!({ "type": "perspective", "perspective": { "yfov": 0.04, "znear": 0.1 } }));
    gltf.add("nodes", json!({ "camera": camera, "translation": [0, 0, 1] }));
    let mut light = kind;
    light["intensity"] = json!(10);
    gltf.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
    let mut node = node;
    node["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 } });
    gltf.add("nodes", node);
    loaded(&gltf)
}

/// Four standard errors, and what a lamp of some size and a picture of some width change: a thousandth.
#[track_caller]
fn shows(scene: &LoadedScene, expected: f64, what: &str) {
    let (mean, error) = mean(scene, 2048);
    let limit = 4.0 * error + 2e-3 * expected;
    assert!((mean - expected).abs() <= limit, "{what}: {mean}, expected {expected} within {limit}");
    assert!(limit <= 0.03 * expected, "{what}: {limit} of {expected} proves nothing");
}

#[test]
fn lights_give_what_their_units_say() {
    let reflected = 0.5 / PI;
    let aside = json!({ "translation": [1.5, 0, 2] });
    let (square, cosine) = (6.25, 2.0 / 2.5);
    shows(&lit(json!({ "type": "point" }), aside), 10.0 / square * cosine * reflected, "point");
    // About y by 30°: the light falls in from +x.
    let turned = json!({ "rotation": [0, (PI / 12.0).sin(), 0, (PI / 12.0).cos()] });
    shows(
        &lit(json!({ "type": "directional" }), turned.clone()),
        10.0 * (PI / 6.0).cos() * reflected,
        "directional",
    );
    // Straight from above, of the default cone.
    let above = json!({ "translation": [0.0, 0.0, 2.0] });
    shows(&lit(json!({ "type": "spot", "spot": {} }), above.clone()), 10.0 / 4.0 * reflected, "spot");
    // From 2 √(1 + tan²) away, aimed along −z: under 20°, within the inner cone.
    let angle = PI / 9.0;
    let beside = json!({ "translation": [2.0 * angle.tan(), 0, 2] });
    let cone = |inner: f64, outer: f64| json!({ "type": "spot", "spot": { "innerConeAngle": inner, "outerConeAngle": outer } });
    let expected = 10.0 / 4.0 * angle.cos().powi(3) * reflected;
    shows(&lit(cone(0.4, 0.5), beside.clone()), expected, "inside");
    // In the middle of its edge half of it is seen, less what the hole's rim curves over the disc: with the disc's radius r and
    // the rim's ρ, of r² π the part r³ / 3ρ.
    let (half, _) = mean(&lit(cone(angle - 0.1, angle + 0.1), beside.clone()), 2048);
    let part = 0.5 - 0.1f64.sin() / (3.0 * PI * angle.sin());
    assert!((half / expected - part).abs() < 0.01, "{half} of {expected}, not {part}");
    let (outside, _) = mean(&lit(cone(0.2, 0.3), beside), 2048);
    assert_eq!(outside, 0.0);
}

#[test]
fn more_than_one_directional_light_shines() {
    let mut gltf = Gltf::new().with_square(json!({ "pbrMetallicRoughness": { "metallicFactor": 0 } }));
    let light = |intensity: f64, green: f64| json!({ "type": "directional", "intensity": intensity, "color": [1, green, 1] });
    gltf.json["extensions"] =
        json!({ "KHR_lights_punctual": { "lights": [light(2.0, 1.0), light(3.0, 0.5), light(1.0, 1.0)] } });
    for (i, angle) in [0.0f64, 0.3, -0.4].into_iter().enumerate() {
        let rotation = json!([0, (0.5 * angle).sin(), 0, (0.5 * angle).cos()]);
        gltf.add(
            "nodes",
            json!({ "rotation": rotation, "extensions": { "KHR_lights_punctual": { "light": i } } }),
        );
    }
    let sky = loaded(&gltf).sky.unwrap();
    let sun = sky.sun.unwrap();
    near(sun.direction, [0.3f32.sin(), 0.0, 0.3f32.cos()], 1e-6);
    near(sun.radiance.map(|v| v * sun.solid_angle()), [3.0, 1.5, 3.0], 1e-3);
    assert!(!sky.visible);
    // The others' irradiance, all of it: the sum of texels times their solid angles.
    let (width, height) = (sky.width as usize, sky.height as usize);
    let solid_angle = |row: usize| {
        let edge = |row: usize| (PI * row as f64 / height as f64).cos();
        2.0 * PI / width as f64 * (edge(row) - edge(row + 1))
    };
    let all: f64 = sky.texels.iter().enumerate().map(|(i, t)| f64::from(t[1]) * solid_angle(i / width)).sum();
    assert!((all - 3.0).abs() < 1e-3, "{all}");
}

#[test]
fn the_first_camera_is_the_view() {
    let mut gltf = Gltf::new().with_square(json!({}));
    let lens = |aspect: f64| json!({ "type": "perspective", "perspective": { "yfov": PI / 3.0, "aspectRatio": aspect, "znear": 0.1 } });
    let flat =
        json!({ "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 1, "znear": 0.1, "zfar": 1 } });
    let cameras = [flat, lens(1.5), lens(1.0)].map(|camera| gltf.add("cameras", camera));
    gltf.add("nodes", json!({ "camera": cameras[0] }));
    // Turned about y by 90°: it looks along −x.
    gltf.add("nodes", json!({ "translation": [7, 1, 2], "rotation": [0, 0.5f64.sqrt(), 0, 0.5f64.sqrt()], "children": [3], "scale": [3, 3, 3] }));
    gltf.add("nodes", json!({ "camera": cameras[1] }));
    gltf.add("nodes", json!({ "camera": cameras[2] }));
    let scene = loaded(&gltf);
    assert_eq!((scene.width, scene.height), (768, 512));
    near(scene.view.from, [7.0, 1.0, 2.0], 1e-6);
    let toward = [0, 1, 2].map(|i| scene.view.at[i] - scene.view.from[i]);
    near(toward, [-1.0, 0.0, 0.0], 1e-6);
    near(scene.view.up, [0.0, 1.0, 0.0], 1e-6);
    near([scene.view.fov], [60.0], 1e-4);
    assert!(scene.warnings.iter().any(|w| w.contains("of 3 cameras")), "{:?}", scene.warnings);
    // Without any, all is seen.
    let scene = loaded(&Gltf::new().with_square(json!({})));
    assert_eq!((scene.width, scene.height, scene.view.at), (512, 512, [0.0; 3]));
}

/// A square on a node that is carried by another, which an animation moves in the three ways.
fn moving() -> Gltf {
    let mut gltf = Gltf::new();
    let mesh = gltf.square(None);
    gltf.add("nodes", json!({ "children": [1], "translation": [0, 0, 1] }));
    gltf.add("nodes", json!({ "mesh": mesh, "translation": [2, 0, 0] }));
    gltf.add("scenes", json!({ "nodes": [0] }));
    let times = gltf.fractions(&[0.0, 0.5, 1.5]);
    // About z by 0, 1 and −1 (the long way round written, the short one meant).
    let turn = |angle: f32| [0.0, 0.0, (0.5 * angle).sin(), (0.5 * angle).cos()];
    let turns = gltf.vectors(&[turn(0.0), turn(1.0), turn(-1.0).map(|v| -v)]);
    // y = t³ and its slope 3 t².
    let cubic: Vec<[f32; 3]> = [0.0f32, 0.5, 1.5]
        .into_iter()
        .flat_map(|t| [[0.0, 3.0 * t * t, 0.0], [2.0, t.powi(3), 0.0], [0.0, 3.0 * t * t, 0.0]])
        .collect();
    let moves = gltf.vectors(&cubic);
    let scales = gltf.vectors(&[[1.0, 1.0, 1.0], [2.0, 2.0, 2.0], [3.0, 3.0, 3.0]]);
    let channel = |sampler: usize, node: usize, path: &str| json!({ "sampler": sampler, "target": { "node": node, "path": path } });
    gltf.add(
        "animations",
        json!({
            "name": "all",
            "samplers": [
                { "input": times, "output": turns, "interpolation": "LINEAR" },
                { "input": times, "output": moves, "interpolation": "CUBICSPLINE" },
                { "input": times, "output": scales, "interpolation": "STEP" },
            ],
            "channels": [channel(0, 0, "rotation"), channel(1, 1, "translation"), channel(2, 1, "scale")],
        }),
    );
    gltf
}

#[test]
fn animations_move_nodes_by_a_closed_form() {
    let (_folder, path) = moving().written();
    let mut animation = Animation::load(&path).unwrap();
    let frames = animation.frames().unwrap();
    assert_eq!((frames.first, frames.last, frames.fps), (0, 36, 24.0));
    for frame in [0u32, 3, 6, 11, 12, 13, 24, 35, 36, 50] {
        animation.seek(frame).unwrap();
        let time = (f64::from(frame) / 24.0).min(1.5);
        let angle = if time < 0.5 { 2.0 * time } else { 1.0 - 2.0 * (time - 0.5) };
        let scale: f64 = if time < 0.5 {
            1.0
        } else if time < 1.5 {
            2.0
        } else {
            3.0
        };
        let (count, areas, positions) = sums(animation.scene());
        assert_eq!(count, 2);
        near(areas, [0.0, 0.0, (4.0 * scale * scale) as f32], 1e-4);
        // Six corners around the middle, which is turned with the node that carries it.
        let (x, y) = (2.0, time.powi(3));
        let middle = [x * angle.cos() - y * angle.sin(), x * angle.sin() + y * angle.cos(), 1.0];
        near(positions.map(|v| v / 6.0), middle.map(|v| v as f32), 1e-5);
    }
    // A second animation of the same node is another one's.
    let mut gltf = moving();
    let mut other = gltf.json["animations"][0].clone();
    other["name"] = json!("walk");
    gltf.add("animations", other);
    let warnings = loaded(&gltf).warnings;
    assert!(warnings.iter().any(|w| w.ends_with("left out: \"walk\"")), "{warnings:?}");
}

#[test]
fn lamps_and_cameras_move_with_their_nodes() {
    let mut gltf = moving();
    let camera =
        gltf.add("cameras", json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }));
    gltf.json["nodes"][1]["camera"] = json!(camera);
    gltf.json["nodes"][1]["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 } });
    gltf.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    let (_folder, path) = gltf.written();
    let mut animation = Animation::load(&path).unwrap();
    animation.seek(12).unwrap();
    let scene = animation.scene();
    let (sin, cos) = 1.0f32.sin_cos();
    near(scene.view.from, [2.0 * cos - 0.125 * sin, 2.0 * sin + 0.125 * cos, 1.0], 1e-5);
    // The lamp is there, and as large as before: its light is.
    let lamp: Vec<_> =
        scene.triangles.iter().zip(&scene.objects).filter(|(_, object)| **object == 1).collect();
    let corner = glam::Vec3::from(lamp[0].0.corners[0]).distance(scene.view.from.into());
    // It is in the square's plane, where the least radius is taken: a ten-thousandth of the square.
    assert!((1.98e-4..2.01e-4).contains(&corner), "{corner}");
}

#[test]
fn a_scene_file_takes_it_as_a_mesh() {
    let folder = tempfile::tempdir().unwrap();
    moving().write(folder.path(), "m.glb");
    let text = "[[meshes]]\nfile = \"m.glb\"\ntranslate = [0, 0, 4]\n[[meshes]]\nfile = \"m.glb\"\nmaterial = \"m\"\n\
        [materials.m]\nkind = \"mirror\"\n";
    std::fs::write(folder.path().join("s.toml"), text).unwrap();
    let scene = load(&folder.path().join("s.toml")).unwrap();
    let (count, areas, positions) = sums(&scene);
    assert_eq!(count, 4);
    near(areas, [0.0, 0.0, 8.0], 1e-5);
    near(positions, [24.0, 0.0, 36.0], 1e-4);
    let mirrors = scene
        .surfaces
        .iter()
        .filter(|s| scene.materials[s.material as usize].scattering == Scattering::Mirror);
    assert_eq!(mirrors.count(), 2);
    assert!(
        scene.warnings.iter().any(|w| w.contains("without cameras, lights and animations")),
        "{:?}",
        scene.warnings
    );
}

/// A turn about an axis.
fn about(axis: usize, angle: f64) -> Value {
    let mut turn = [0.0, 0.0, 0.0, (0.5 * angle).cos()];
    turn[axis] = (0.5 * angle).sin();
    json!(turn)
}

/// A room with a textured back, a floor of metal, a lamp, a glass cube and one of plaster, all carried by a turned node.
fn room() -> Gltf {
    let mut gltf = Gltf::new();
    let texture = gltf.texture(&picture(
        2,
        &[[200, 60, 40, 255], [60, 180, 60, 255], [40, 60, 200, 255], [220, 220, 220, 255]],
    ));
    let index = |ior: f64| json!({ "KHR_materials_ior": { "ior": ior } });
    let plain = |colour: [f64; 3]| {
        let [r, g, b] = colour;
        json!({ "pbrMetallicRoughness": { "baseColorFactor": [r, g, b, 1], "metallicFactor": 0 }, "extensions": index(1.0) })
    };
    let mut back = plain([1.0; 3]);
    back["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": texture });
    let metal =
        json!({ "pbrMetallicRoughness": { "baseColorFactor": [0.9, 0.6, 0.3, 1], "roughnessFactor": 0.5 } });
    let mut lamp = plain([0.0; 3]);
    lamp["emissiveFactor"] = json!([1, 0.8, 0.6]);
    lamp["extensions"]["KHR_materials_emissive_strength"] = json!({ "emissiveStrength": 12 });
    let mut glass = json!({ "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0 }, "extensions": index(1.5) });
    glass["extensions"]["KHR_materials_transmission"] = json!({ "transmissionFactor": 1 });
    let quarter = PI / 2.0;
    let walls = [
        (back, json!({ "translation": [0, 0, -1] })),
        (metal, json!({ "translation": [0, -1, 0], "rotation": about(0, -quarter) })),
        (plain([0.75; 3]), json!({ "translation": [0, 1, 0], "rotation": about(0, quarter) })),
        (plain([0.7, 0.2, 0.1]), json!({ "translation": [-1, 0, 0], "rotation": about(1, quarter) })),
        (plain([0.2, 0.6, 0.2]), json!({ "translation": [1, 0, 0], "rotation": about(1, -quarter) })),
        (
            lamp,
            json!({ "translation": [0, 0.98, 0], "rotation": about(0, quarter), "scale": [0.3, 0.25, 1] }),
        ),
    ];
    for (stated, mut node) in walls {
        let stated = gltf.add("materials", stated);
        node["mesh"] = json!(gltf.square(Some(stated)));
        gltf.add("nodes", node);
    }
    let corners: Vec<[f32; 3]> =
        (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|bit| 2.0 * bit as f32 - 1.0)).collect();
    let positions = gltf.vectors(&corners);
    let faces = [
        0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1,
        7, 5,
    ];
    let faces = gltf.indices(&faces, U8);
    let cubes = [
        (
            glass,
            json!({ "translation": [-0.4, -0.6, 0.2], "rotation": about(1, 0.4), "scale": [0.25, 0.25, 0.25] }),
        ),
        (
            plain([0.6; 3]),
            json!({ "translation": [0.45, -0.5, -0.3], "rotation": about(1, -0.3), "scale": [0.3, 0.5, 0.3] }),
        ),
    ];
    for (stated, mut node) in cubes {
        let stated = gltf.add("materials", stated);
        let primitive =
            json!({ "attributes": { "POSITION": positions }, "indices": faces, "material": stated });
        node["mesh"] = json!(gltf.mesh(primitive));
        gltf.add("nodes", node);
    }
    let lens = json!({ "yfov": 40f64.to_radians(), "aspectRatio": 1, "znear": 0.1 });
    let camera = gltf.add("cameras", json!({ "type": "perspective", "perspective": lens }));
    gltf.add("nodes", json!({ "camera": camera, "translation": [0, 0, 3.6] }));
    let children: Vec<usize> = (0..9).collect();
    let root = gltf
        .add("nodes", json!({ "children": children, "translation": [0, 1, 0], "rotation": about(1, 0.3) }));
    gltf.add("scenes", json!({ "nodes": [root] }));
    gltf
}

/// Against Mitsuba 3.9.1: the same room, number by number, with `diffuse`, `principled` (metallic 1) and `dielectric`, by `path`
/// to depth 8 with a box filter at 64×64. 0.5 % is four standard errors of these 192 samples a pixel.
#[test]
fn a_room_is_as_bright_as_in_mitsuba() {
    let scene = loaded(&room());
    let mut settings = Settings::new(&scene, Method::Uniform, Some(192), Some((64, 64)));
    settings.max_depth = 8;
    let frame = render(&scene, &settings, None, &|_| ()).unwrap();
    let means = [0, 1, 2].map(|c| frame.rgb.iter().map(|rgb| f64::from(rgb[c])).sum::<f64>() / 4096.0);
    for (mean, expected) in means.into_iter().zip(MITSUBA) {
        assert!((mean / expected - 1.0).abs() < 0.005, "{means:?}, expected {MITSUBA:?}");
    }
}

/// Means of red, green and blue of 4096 samples a pixel, which have a standard error of 0.03 %.
const MITSUBA: [f64; 3] = [0.24469, 0.17533, 0.10995];

/// A square whose second coordinates are these, a light before it.
fn unwrapped(second: [[f32; 2]; 4]) -> Gltf {
    let mut gltf = Gltf::new().with_square(json!({ "pbrMetallicRoughness": { "metallicFactor": 0 } }));
    let second = gltf.vectors(&second);
    gltf.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = json!(second);
    gltf.json["extensions"] =
        json!({ "KHR_lights_punctual": { "lights": [{ "type": "point", "intensity": 10 }] } });
    gltf.add(
        "nodes",
        json!({ "translation": [0, 0, 2], "extensions": { "KHR_lights_punctual": { "light": 0 } } }),
    );
    gltf
}

/// The middle quarter of the square, its lower left corner (v downwards) that of the mesh.
const MIDDLE: [[f32; 2]; 4] = [[0.25, 0.75], [0.75, 0.75], [0.75, 0.25], [0.25, 0.25]];

#[test]
fn second_coordinates_are_places_in_the_lightmap() {
    let scene = loaded(&unwrapped(MIDDLE));
    let atlas = second::atlas(&scene, Fineness::Size(64)).unwrap();
    // 32 texels for two units; those whose border is the square's are touched, too.
    assert_eq!((atlas.size, atlas.density, atlas.charts()), (64, 16.0, 1));
    assert!((32 * 32..=34 * 34).contains(&atlas.used()), "{}", atlas.used());
    let flats = scene.triangles.iter().zip(&atlas.corners).filter_map(|(t, flat)| Some((t, (*flat)?)));
    for (triangle, flat) in flats {
        for ([x, y, _], at) in triangle.corners.into_iter().zip(flat) {
            near(at, [32.0 + 16.0 * x, 32.0 - 16.0 * y], 1e-4);
        }
    }
    assert_eq!(second::atlas(&scene, Fineness::Density(17.0)).unwrap().size, 128);
    let why = |gltf: &Gltf, fineness: Fineness| second::atlas(&loaded(gltf), fineness).err().unwrap();
    let size = Fineness::Size(64);
    assert!(why(&unwrapped(MIDDLE.map(|[u, v]| [u + 0.5, v])), size).contains("leave the square"));
    assert!(why(&unwrapped([[0.5; 2]; 4]), size).contains("no area"));
    assert!(why(&unwrapped(MIDDLE), Fineness::Both(64, 17.0)).contains("too few"));
    let mut twice = unwrapped(MIDDLE);
    twice.add("nodes", json!({ "mesh": 0, "translation": [3, 0, 0] }));
    assert!(why(&twice, size).contains("show two places"));
    let mut partly = unwrapped(MIDDLE);
    let bare = partly.square(Some(0));
    partly.add("nodes", json!({ "mesh": bare, "translation": [3, 0, 0] }));
    assert!(why(&partly, size).contains("not all surfaces"));
    assert!(why(&Gltf::new().with_square(json!({})), size).contains("there are none"));
}

#[test]
fn bake_uses_second_coordinates_or_says_why_not() {
    let folder = tempfile::tempdir().unwrap();
    unwrapped(MIDDLE).write(folder.path(), "a.glb");
    unwrapped(MIDDLE.map(|[u, v]| [2.0 * u, v])).write(folder.path(), "b.glb");
    for (name, warnings, corner) in [("a", 0, Some("vt 0.25 0.25")), ("b", 1, None)] {
        let command = format!("bake {name}.glb -o {name}.exr --size 32 --spp 2");
        let output = program::pmcip(folder.path(), &command);
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{stderr}");
        assert_eq!(stderr.matches("second texture coordinates are not used").count(), warnings, "{stderr}");
        let mesh = std::fs::read_to_string(folder.path().join(format!("{name}.obj"))).unwrap();
        assert!(corner.is_none_or(|corner| mesh.contains(corner)), "{mesh}");
    }
}

#[test]
fn what_is_wrong_is_said() {
    let square = || Gltf::new().with_square(json!({}));
    let with = |change: fn(&mut Value)| {
        let mut gltf = square();
        change(&mut gltf.json);
        refused(&gltf)
    };
    for (message, expected) in [
        (with(|j| j["asset"]["version"] = json!("1.0")), "s.gltf: it is glTF of version 1.0, expected 2.0"),
        (with(|j| j["asset"] = Value::Null), "asset: expected a version"),
        (
            with(|j| {
                j["extensionsRequired"] =
                    json!(["KHR_texture_transform", "KHR_draco_mesh_compression", "X_y"])
            }),
            "it needs extensions that are not supported: KHR_draco_mesh_compression, X_y",
        ),
        (with(|j| j["nodes"][0]["mesh"] = json!(7)), "nodes[0].mesh: the index leads nowhere"),
        (
            with(|j| j["accessors"][0]["count"] = json!(5)),
            "accessor 0: 5 items of 12 bytes are more than its bufferView holds",
        ),
        (with(|j| j["accessors"][0]["count"] = json!(4_000_000_000u32)), "more than its bufferView holds"),
        (with(|j| j["accessors"][0]["count"] = json!(u64::MAX)), "expected 1 to 4294967295"),
        (with(|j| j["accessors"][0]["count"] = json!(0)), "0 items"),
        (with(|j| j["accessors"][0]["byteOffset"] = json!(u64::MAX)), "more than its bufferView holds"),
        (
            with(|j| j["bufferViews"][0]["byteLength"] = json!(u64::MAX)),
            "bufferView 0 ends beyond its buffer",
        ),
        (with(|j| j["bufferViews"][0]["byteStride"] = json!(8)), "more than its bufferView holds"),
        (with(|j| j["accessors"][0]["type"] = json!("VEC2")), "accessor 0: expected vectors of 3 numbers"),
        (
            with(|j| j["accessors"][1]["count"] = json!(3)),
            "mesh 0, primitive 0: 3 of TEXCOORD_0 for 4 positions",
        ),
        (
            with(|j| {
                j["accessors"][0] = json!({ "componentType": 5126, "count": 1_000_000_000, "type": "VEC3",
            "sparse": { "count": 1, "indices": { "bufferView": 2, "componentType": 5123 }, "values": { "bufferView": 0 } } })
            }),
            "1000000000 items, more than the file can mean",
        ),
        (
            with(|j| j["buffers"] = json!([{ "byteLength": 9, "uri": "../x.bin" }])),
            "buffer 0: ../x.bin: expected a file in the folder",
        ),
        (
            with(|j| j["buffers"] = json!([{ "byteLength": 9, "uri": "/etc/passwd" }])),
            "expected a file in the folder",
        ),
        (with(|j| j["buffers"] = json!([{ "byteLength": 9, "uri": "x.bin" }])), "x.bin"),
        (
            with(|j| j["buffers"] = json!([{ "byteLength": 4_000_000_000u32, "uri": "data:;base64,AAAA" }])),
            "3 of 4000000000 bytes are there",
        ),
        (with(|j| j["nodes"][0]["children"] = json!([0])), "no triangles"),
        (
            with(|j| {
                j["nodes"][0]["children"] = json!([0]);
                j["scenes"] = json!([{ "nodes": [0] }]);
            }),
            "node 0 is reached in two ways",
        ),
        (with(|j| j["meshes"][0]["primitives"][0]["mode"] = json!(1)), "no triangles"),
        (with(|j| j["meshes"] = json!({})), "expected"),
    ] {
        assert!(message.contains(expected), "{message}: expected {expected}");
    }
    let mut deep = square();
    (0..5000).for_each(|i| {
        deep.add("nodes", json!({ "children": [i] }));
    });
    deep.json["scenes"] = json!([{ "nodes": [5000] }]);
    assert!(refused(&deep).contains("nodes are nested more than 1024 deep"));
}

#[test]
fn damaged_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let glb = Gltf::new().with_square(json!({})).binary();
    let changed = |at: usize, byte: u8| {
        let mut bytes = glb.clone();
        bytes[at] = byte;
        bytes
    };
    for (name, bytes, expected) in [
        ("a.glb", glb[..200].to_vec(), "it is cut off: 200 of"),
        ("a.glb", glb[..10].to_vec(), "it ends within its header"),
        ("a.glb", changed(4, 1), "it is binary glTF of version 1, expected 2"),
        ("a.glb", changed(15, 9), "ends beyond the file"),
        ("a.glb", changed(16, b'X'), "it has no JSON chunk"),
        ("a.gltf", b"{\n\n\"asset\": nothing }".to_vec(), "a.gltf:3: expected ident"),
        ("a.gltf", b"{ \"made\": \"elsewhere\" }".to_vec(), "it has no asset: it is JSON, but no glTF"),
        ("a.gltf", [b"[".repeat(100_000), b"]".repeat(100_000)].concat(), "a.gltf:1:"),
        ("a.gltf", b"v 0 0 0\n".to_vec(), "a.gltf:1:"),
        ("a.glb", b"\x1f\x8b\x08\0".to_vec(), "it seems to be a gzip archive"),
        ("a.obj", glb.clone(), "it seems to be a binary glTF: its name should end in .glb"),
        ("a.toml", b"{\"asset\": {}}".to_vec(), "if it is glTF, its name should end in .gltf"),
    ] {
        std::fs::write(folder.path().join(name), bytes).unwrap();
        let message = load(&folder.path().join(name)).unwrap_err().to_string();
        assert!(message.contains(expected) && !message.contains('\n'), "{message}: expected {expected}");
    }
    // Binary is known by its beginning, whatever its name.
    std::fs::write(folder.path().join("b.gltf"), &glb).unwrap();
    assert_eq!(load(&folder.path().join("b.gltf")).unwrap().triangles.len(), 2);
}

/// A white surface that faces a lamp, all of its normals leaning by the same angle, reflects that angle's cosine.
#[test]
fn normal_maps_bend_what_is_lit() {
    let mut bare = Gltf::new();
    // 2 · 204/255 − 1 = 0.6 along u, 0.8039 up.
    let texture = bare.texture(&picture(1, &[[204, 128, 230, 255]]));
    let lights = json!([{ "type": "directional", "intensity": 1 }]);
    bare.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": lights } });
    bare.add("nodes", json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } } }));
    let lit = |normal: Value| {
        let mut stated = json!({ "extensions": { "KHR_materials_unlit": {} } });
        if !normal.is_null() {
            stated["normalTexture"] = normal;
        }
        let gltf = Gltf { json: bare.json.clone(), bin: bare.bin.clone() }.with_square(stated);
        let scene =
            loaded(&gltf.using(&["KHR_lights_punctual", "KHR_materials_unlit", "KHR_texture_transform"]));
        let maps = scene.normal_maps.iter().filter(|map| **map != NO_TEXTURE).count();
        (mean(&scene, 64), maps)
    };
    let ((flat, _), none) = lit(Value::Null);
    let ratio = |normal: Value, cosine: f64| {
        let ((leaning, error), maps) = lit(normal);
        assert_eq!(maps, 1);
        // The lamp is half a degree wide.
        let off = (leaning / flat - cosine).abs();
        assert!(off < 4.0 * error / flat + 1e-3, "{off} ± {}", error / flat);
    };
    assert!(none == 0 && flat > 0.0);
    let cosine = |along: f64| 0.8039 / along.hypot(0.8039);
    ratio(json!({ "index": texture }), cosine(0.6));
    ratio(json!({ "index": texture, "scale": 0.5 }), cosine(0.3));
    // Turned in its plane by a quarter it leans elsewhere, as far.
    let turn = json!({ "KHR_texture_transform": { "rotation": PI / 2.0, "scale": [2, 3] } });
    ratio(json!({ "index": texture, "extensions": turn }), cosine(0.6));
}

#[test]
fn what_has_no_effect_is_named_once() {
    let mut gltf = Gltf::new();
    let texture = gltf.texture(&picture(2, &[[255, 128, 0, 255], [255, 64, 128, 255]]));
    let info = json!({ "index": texture });
    let stated = json!({ "doubleSided": true, "emissiveFactor": [1, 1, 1], "normalTexture": info, "occlusionTexture": info,
        "pbrMetallicRoughness": { "metallicRoughnessTexture": info, "baseColorTexture": info },
        "extensions": { "KHR_materials_unlit": {} } });
    let mut gltf = gltf.with_square(stated.clone());
    gltf.add("materials", stated);
    let second = gltf.square(Some(1));
    gltf.json["meshes"][second]["primitives"][0]["targets"] = json!([{ "POSITION": 0 }]);
    gltf.add("nodes", json!({ "mesh": second, "translation": [3, 0, 0], "skin": 0 }));
    gltf.add("skins", json!({ "joints": [0] }));
    gltf.json["extensionsUsed"] = json!(["KHR_materials_unlit", "KHR_materials_clearcoat", "X_y"]);
    gltf.add(
        "animations",
        json!({ "samplers": [], "channels": [{ "sampler": 0, "target": { "path": "pointer" } }] }),
    );
    let warnings = loaded(&gltf).warnings;
    for expected in [
        "extensions without effect here: KHR_materials_clearcoat, X_y",
        "animations of anything but nodes are left out",
        "skins are left out",
        "morph targets are left out",
        "occlusionTexture is not needed",
        "metallicRoughnessTexture: lobes are even here: its mean is taken (2 times)",
        "shines on its front alone (2 times)",
        "KHR_materials_unlit",
    ] {
        let count = warnings.iter().filter(|w| w.contains(expected)).count();
        assert_eq!(count, 1, "{expected} in {warnings:#?}");
    }
    // Green is roughness: the mean of 128 and 64, squared. Blue is metal: that of 0 and 128.
    let mut gltf = Gltf::new();
    let texture = gltf.texture(&picture(2, &[[255, 128, 0, 255], [255, 64, 128, 255]]));
    let scene = loaded(&gltf.with_square(
        json!({ "pbrMetallicRoughness": { "metallicRoughnessTexture": { "index": texture } } }),
    ));
    near([material(&scene).roughness], [(96.0f32 / 255.0).powi(2)], 1e-5);
    near(material(&scene).diffuse, [0.96 * (1.0 - 64.0 / 255.0); 3], 1e-5);
    // Pictures that are not there.
    let mut gltf = Gltf::new();
    gltf.add("images", json!({ "uri": "gone.png" }));
    gltf.add("images", json!({ "uri": "../gone.png" }));
    gltf.add("textures", json!({ "source": 0 }));
    gltf.add("textures", json!({ "source": 1 }));
    let stated = json!({ "pbrMetallicRoughness": { "metallicFactor": 0, "baseColorTexture": { "index": 0 } },
        "emissiveFactor": [1, 1, 1], "emissiveTexture": { "index": 1 } });
    let scene = loaded(&gltf.with_square(stated));
    assert_eq!(material(&scene).texture, NO_TEXTURE);
    assert!(scene.warnings.iter().any(|w| w.contains("gone.png")), "{:?}", scene.warnings);
    assert!(
        scene.warnings.iter().any(|w| w.contains("expected a file in the folder")),
        "{:?}",
        scene.warnings
    );
}

#[test]
fn a_dark_file_gets_light() {
    let (_folder, path) = Gltf::new().with_square(json!({})).written();
    let lit = Animation::open(&path, &Options { light: LightChoice::Auto, ..Options::default() }).unwrap();
    assert!(lit.scene().sky.is_some());
    assert!(
        lit.scene().warnings.iter().any(|w| w.contains("no light: it has none")),
        "{:?}",
        lit.scene().warnings
    );
    let own = load(&path).unwrap().require_light().unwrap_err().to_string();
    assert!(own.contains("emissiveFactor"), "{own}");
}

#[test]
fn the_program_renders_it_frame_by_frame() {
    let folder = tempfile::tempdir().unwrap();
    moving().write(folder.path(), "m.glb");
    program::success(folder.path(), "render m.glb --frames 1..2 --size 16x16 --spp 2 -o f.exr");
    let written = std::fs::read_dir(folder.path())
        .unwrap()
        .filter(|entry| entry.as_ref().unwrap().file_name().to_string_lossy().ends_with(".exr"));
    assert_eq!(written.count(), 2);
}

/// A mesh at many nodes, numbers in many primitives, keys in many animations, a file in many buffers, lamps: what a few words
/// repeat is counted before it is made.
#[test]
fn what_there_is_no_memory_for_is_refused() {
    let within = |memory: u64, gltf: &Gltf| {
        let (_folder, path) = gltf.written();
        let options = Options { light: LightChoice::Own, memory: Some(memory), ..Options::default() };
        let message = Animation::open(&path, &options).map(|_| ()).unwrap_err().to_string();
        let (_, message) = message.split_once(": ").unwrap();
        message.to_owned()
    };
    let lamps =
        json!({ "KHR_lights_punctual": { "lights": [{ "type": "spot", "spot": {}, "intensity": 1 }] } });
    let square = || Gltf::new().with_square(json!({}));
    let mut nodes = square();
    for _ in 0..1000 {
        nodes.add("nodes", json!({ "mesh": 0 }));
    }
    let refusal = within(100_000, &nodes);
    assert!(refusal.starts_with("not enough memory: with 2002 triangles"), "{refusal}");
    let mut primitives = square();
    let primitive = json!({ "attributes": { "POSITION": 0 }, "indices": 2, "mode": 5 });
    primitives.json["meshes"][0]["primitives"] = json!(vec![primitive; 1000]);
    let refusal = within(10_000, &primitives);
    assert!(refusal.contains("accessor 0: not enough memory: with 2478 numbers of meshes"), "{refusal}");
    let mut keys = square();
    let (input, output) = (keys.fractions(&[0.0, 1.0, 2.0]), keys.vectors(&[[0.0; 3]; 3]));
    let sampler = json!({ "input": input, "output": output });
    for node in 0..1000 {
        keys.add("nodes", json!({}));
        let channel = json!({ "sampler": 0, "target": { "node": node, "path": "translation" } });
        keys.add("animations", json!({ "samplers": [sampler], "channels": [channel] }));
    }
    let refusal = within(100_000, &keys);
    assert!(refusal.contains("not enough memory") && refusal.contains("keys"), "{refusal}");
    let mut buffers = square();
    let data = format!("data:;base64,{}", "A".repeat(4000));
    buffers.json["buffers"] = json!(vec![json!({ "byteLength": 1, "uri": data }); 100]);
    let refusal = within(100_000, &buffers);
    assert!(refusal.contains("not enough memory: with 102000 bytes of files"), "{refusal}");
    let mut lit = square().using(&["KHR_lights_punctual"]);
    lit.json["extensions"] = lamps;
    for _ in 0..100 {
        lit.add("nodes", json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } } }));
    }
    let refusal = within(1_000_000, &lit);
    assert!(refusal.contains("not enough memory: with 1") && refusal.contains("triangles"), "{refusal}");
}

/// What a file takes while it is read is given back: it may stand in a scene often.
#[test]
fn what_was_only_read_is_given_back() {
    let mut gltf = Gltf::new().with_square(json!({}));
    gltf.view(&[0; 100_000]);
    let (folder, _) = gltf.written();
    let name = folder.path().read_dir().unwrap().next().unwrap().unwrap().file_name();
    let mesh = format!("[[meshes]]\nfile = {name:?}\n");
    let scene = folder.path().join("s.toml");
    std::fs::write(&scene, mesh.repeat(10)).unwrap();
    let options = Options { light: LightChoice::Own, memory: Some(200_000), ..Options::default() };
    assert_eq!(Animation::open(&scene, &options).unwrap().scene().triangles.len(), 20);
}
