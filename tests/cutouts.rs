//! Surfaces that are only partly there, lamps that are pictures, colours of vertices: what arrives in the picture.

mod scene_files;

use pmcip::frame::render;
use pmcip::frame::settings::{Integrator, Layer, Method, Settings};
use pmcip::scene::{Animation, LightChoice, LoadedScene, Options, View};
use pmcip_core::tracer::scene::{Light, LightNode8, light, light_tree};
use scene_files::folder;

/// A lamp of radiance 20 that looks down from y = 2, a floor, and between them a sheet at y = 1 that is larger than both.
const OBJ: &str = "mtllib s.mtl\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
    v -1 0 1\nv 1 0 1\nv 1 0 -1\nv -1 0 -1\nusemtl floor\nf 1/1 2/2 3/3 4/4\n\
    v -.5 2 .5\nv .5 2 .5\nv .5 2 -.5\nv -.5 2 -.5\nusemtl lamp\nf 8/4 7/3 6/2 5/1\n";
const SHEET: &str = "v -4 1 4\nv 4 1 4\nv 4 1 -4\nv -4 1 -4\nusemtl sheet\nf 9/1 10/2 11/3 12/4\n";
const MTL: &str =
    "newmtl lamp\nKd 0 0 0\nKe 20 20 20\nnewmtl floor\nKd 0.8 0.8 0.8\nnewmtl sheet\nKd 0 0 0\n";

const INTEGRATORS: [Integrator; 2] =
    [Integrator::Path, Integrator::Direct { light_samples: 2, bsdf_samples: 2 }];

/// The scene of these files, seen from below the sheet, or from where `view` says.
fn scene(obj: &str, mtl: &str, pictures: &[(&str, image::RgbaImage)], view: [f64; 3]) -> LoadedScene {
    let folder = folder(&[("s.obj", obj), ("s.mtl", mtl)]);
    for (name, pixels) in pictures {
        pixels.save(folder.path().join(name)).unwrap();
    }
    let options = Options { light: LightChoice::Own, ..Options::default() };
    let mut scene = Animation::open(&folder.path().join("s.obj"), &options).unwrap().into_scene();
    let from = view.map(|v| v as f32);
    scene.view = View { from, at: [0.0; 3], up: [0.0, 0.0, -1.0], fov: 40.0, aperture: 0.0, focus: None };
    scene
}

const BELOW: [f64; 3] = [0.0, 0.9, 0.3];

/// Mean luminance of a picture, and its standard error.
fn mean(scene: &LoadedScene, integrator: Integrator, seed: u32) -> (f64, f64) {
    let mut settings = Settings::new(scene, Method::Uniform, Some(2048), Some((8, 8)));
    (settings.integrator, settings.max_depth, settings.sampler.seed) = (integrator, 2, seed);
    let frame = render::render(scene, &settings, None, &|_| ()).unwrap();
    assert_eq!(frame.tally.rejected, 0);
    let sum: f64 = frame.rgb.iter().map(|rgb| f64::from(rgb[1])).sum();
    let variance: f64 = frame.variance.iter().map(|v| f64::from(*v)).sum();
    (sum / 64.0, variance.sqrt() / 64.0)
}

/// Whether two means are the same but for noise, at four standard errors; the layer's variances overstate.
#[track_caller]
fn same((a, ea): (f64, f64), (b, eb): (f64, f64), what: &str) {
    let limit = 4.0 * ea.hypot(eb);
    assert!((a - b).abs() <= limit, "{what}: {a} and {b} differ by more than {limit}");
    assert!(limit < 0.05 * a.max(b), "{what}: {limit} of {a} proves nothing");
}

fn times((mean, error): (f64, f64), factor: f64) -> (f64, f64) {
    (mean * factor, error * factor)
}

/// A mask of 8×8 pixels of these values in columns.
fn stripes(values: [u8; 8]) -> image::RgbaImage {
    image::RgbaImage::from_fn(8, 8, |x, _| image::Rgba([200, 100, 50, values[x as usize]]))
}

#[test]
fn a_sheet_passes_the_part_that_is_not_there() {
    let open = scene(OBJ, MTL, &[], BELOW);
    let half = stripes([255, 0, 255, 0, 255, 0, 255, 0]);
    let grey = image::RgbaImage::from_fn(4, 4, |_, _| image::Rgba([51, 51, 51, 255]));
    for integrator in INTEGRATORS {
        let whole = mean(&open, integrator, 1);
        for (sheet, pictures, passes) in [
            ("d 0.3", vec![], 0.7),
            ("Tr 0.6", vec![], 0.6),
            ("d 1", vec![], 0.0),
            ("map_d g.png", vec![("g.png", grey.clone())], 0.8),
            ("d 0.5\nmap_d g.png", vec![("g.png", grey.clone())], 0.9),
            ("map_d -s 16 16 1 h.png", vec![("h.png", half.clone())], 0.5),
            ("map_Kd -s 16 16 1 h.png", vec![("h.png", half.clone())], 0.5),
        ] {
            let veiled = scene(&format!("{OBJ}{SHEET}"), &format!("{MTL}{sheet}\n"), &pictures, BELOW);
            let seen = mean(&veiled, integrator, 2);
            match passes {
                0.0 => assert_eq!(seen.0, 0.0, "{sheet}"),
                passes => same(seen, times(whole, passes), sheet),
            }
        }
    }
}

/// From above the sheet the floor is seen through it, by light that passes it too.
#[test]
fn sight_passes_as_light_does_and_coverage_says_so() {
    let above = [0.0, 1.5, 0.5];
    let open = scene(OBJ, MTL, &[], above);
    let veiled = scene(&format!("{OBJ}{SHEET}"), &format!("{MTL}d 0.25\n"), &[], above);
    for integrator in INTEGRATORS {
        same(mean(&veiled, integrator, 2), times(mean(&open, integrator, 1), 0.75 * 0.75), "twice through");
    }
    let mut settings = Settings::new(&veiled, Method::Uniform, Some(1), Some((64, 64)));
    settings.view.at = [40.0, 1.2, 0.0];
    settings.layers = [Layer::Coverage].into_iter().collect();
    let frame = render::render(&veiled, &settings, None, &|_| ()).unwrap();
    assert!(frame.layers["A"].iter().any(|a| *a > 0.0 && *a < 1.0), "the sheet is seen in part");
}

/// A lamp with holes gives the part of its light that is there; seen, it hides that part of what is behind.
#[test]
fn lamps_may_have_holes() {
    let open = scene(OBJ, MTL, &[], BELOW);
    let holed = MTL.replace("Ke 20 20 20", "Ke 20 20 20\nd 0.4");
    let holed = scene(OBJ, &holed, &[], BELOW);
    for integrator in INTEGRATORS {
        same(mean(&holed, integrator, 2), times(mean(&open, integrator, 1), 0.4), "a lamp of 0.4");
    }
    let mut looking = scene(OBJ, &MTL.replace("Ke 20 20 20", "Ke 20 20 20\nd 0.4"), &[], [0.0, 0.5, 0.0]);
    (looking.view.at, looking.view.up, looking.view.fov) = ([0.0, 2.0, 0.0], [0.0, 0.0, 1.0], 20.0);
    same(mean(&looking, Integrator::Path, 3), (8.0, 0.01), "the lamp itself");
}

/// The lamp as a picture, in texels of these rows.
fn picture_lamp(side: u32, emission: impl Fn(f32) -> [f32; 3]) -> LoadedScene {
    let pixels = image::RgbaImage::from_fn(side, side, |x, y| {
        let value = if (x * 7 + y * 3) % 5 == 0 { 255 } else { 0 };
        image::Rgba([value, value, value, 255])
    });
    let mtl = MTL.replace("Ke 20 20 20", "Ke 20 20 20\nmap_Ke p.png");
    let mut scene = scene(OBJ, &mtl, &[("p.png", pixels)], BELOW);
    // What lamps are chosen by may be anything: it must not show.
    let mut factor = 1.0;
    for material in scene.materials.iter_mut().filter(|material| material.emission[0] > 0.0) {
        material.emission = emission(material.emission[0] * factor);
        factor *= 20.0;
    }
    list_lights(&mut scene);
    scene
}

fn list_lights(scene: &mut LoadedScene) {
    scene.lights = vec![Light::default(); light::count(&scene.surfaces, &scene.materials)];
    let used = light::build(&scene.triangles, &scene.surfaces, &scene.materials, &mut scene.lights);
    scene.lights.truncate(used);
    scene.light_nodes = vec![LightNode8::default(); light_tree::required(used)];
    let mut order = vec![0; used];
    let (lights, nodes) = (&mut scene.lights, &mut scene.light_nodes);
    let used = light_tree::build(
        &scene.triangles,
        &[],
        &scene.surfaces,
        &scene.materials,
        lights,
        &mut order,
        nodes,
    );
    scene.light_nodes.truncate(used);
}

#[test]
fn pictures_shine_whatever_they_are_chosen_by() {
    for integrator in INTEGRATORS {
        let fair = mean(&picture_lamp(16, |v| [v; 3]), integrator, 1);
        same(mean(&picture_lamp(16, |v| [v, 2.0 * v, 0.1 * v]), integrator, 2), fair, "chosen otherwise");
        // A texture of a fifth white, so fine that the floor sees its mean.
        let white = mean(&scene(OBJ, MTL, &[], BELOW), integrator, 3);
        let even = mean(&picture_lamp(80, |v| [v; 3]), integrator, 4);
        same(even, times(white, 0.2), "a fifth of a lamp");
    }
}

/// The part of the lamp's triangles where the picture is black is no lamp.
#[test]
fn black_parts_of_pictures_are_no_lamps() {
    let pixels = image::RgbaImage::from_fn(64, 64, |x, y| {
        let value = if x + 8 < y { 255 } else { 0 };
        image::Rgba([value, value, value, 255])
    });
    let mtl = MTL.replace("Ke 20 20 20", "map_Ke -clamp on p.png");
    let lit = scene(OBJ, &mtl, &[("p.png", pixels)], BELOW);
    assert_eq!(lit.lights.len(), 1);
    let dark = scene(OBJ, &mtl, &[("p.png", image::RgbaImage::new(4, 4))], BELOW);
    assert_eq!(dark.lights.len(), 0);
}

#[test]
fn normal_maps_are_read_as_they_are_written() {
    let pixels = image::RgbaImage::from_pixel(2, 1, image::Rgba([255, 51, 0, 255]));
    let obj = "mtllib s.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\n";
    let bent = scene(obj, "newmtl m\nKd 1 1 1\nnorm -s 2 -2 p.png\n", &[("p.png", pixels.clone())], BELOW);
    let texture = bent.textures[bent.normal_maps[bent.surfaces[0].material as usize] as usize];
    assert_eq!(
        (texture.scale, bent.texels[texture.first as usize]),
        ([2.0, -2.0], [1.0, 2.0 * 0.2 - 1.0, -1.0])
    );
    let glass = scene(obj, "newmtl m\nd 0\nNi 1.5\nnorm p.png\n", &[("p.png", pixels)], BELOW);
    assert!(glass.normal_maps.is_empty());
    assert!(glass.warnings.iter().any(|w| w.contains("norm is without effect on mirrors and glass")));
}

#[test]
fn vertices_bring_colours_where_there_is_no_texture() {
    let obj = "mtllib s.mtl\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 0.5\nv 1 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 2 4 3\n";
    let mtl = "newmtl a\nKd 1 1 1\nnewmtl b\nKd 1 1 1\nmap_Kd p.png\n";
    let white = image::RgbaImage::from_pixel(1, 1, image::Rgba([255; 4]));
    let scene = scene(obj, mtl, &[("p.png", white)], BELOW);
    let textured =
        scene.surfaces.iter().position(|s| scene.materials[s.material as usize].texture == 0).unwrap();
    assert_eq!(scene.colours[textured], [[1.0; 3]; 3]);
    let half = 0.214_041_14;
    let [a, b, c] = scene.colours[1 - textured];
    assert_eq!((a, b), ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]));
    assert!(c[0] == 0.0 && (c[2] - half).abs() < 1e-6, "{c:?}");
}
