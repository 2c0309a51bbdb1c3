//! What the scene loader makes of OBJ and scene files.

mod scene_files;

use pmcip::frame::render;
use pmcip::frame::settings::{Method, Settings};
use pmcip::scene::{LoadedScene, load, load_lit};
use pmcip_core::tracer::scene::{Scattering, Scene};
use scene_files::{SQUARE, folder, load_files};
use std::path::Path;

fn load_obj(text: &str) -> LoadedScene {
    load_files(&[("scene.obj", text)])
}

/// Unnormalised geometric normal of a triangle.
fn front(scene: &LoadedScene, i: usize) -> glam::Vec3 {
    let [a, b, c] = scene.triangles[i].corners.map(glam::Vec3::from);
    (b - a).cross(c - a)
}

fn total_area(scene: &LoadedScene) -> f32 {
    (0..scene.triangles.len()).map(|i| 0.5 * front(scene, i).length()).sum()
}

fn close(a: [f32; 3], b: [f32; 3]) -> bool {
    glam::Vec3::from(a).distance(b.into()) < 1e-5
}

#[test]
fn polygons_become_triangles_of_the_same_area() {
    let scene = load_obj(&format!("{SQUARE}f 1 2 3 4\n"));
    assert_eq!((scene.triangles.len(), total_area(&scene)), (2, 1.0));
    let hexagon = load_obj("v 0 0 0\nv 1 0 0\nv 2 1 0\nv 2 2 0\nv 1 2 0\nv 0 1 0\nf 1 2 3 4 5 6\n");
    assert_eq!((hexagon.triangles.len(), total_area(&hexagon)), (4, 3.0));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

#[test]
fn negative_indices_count_back_from_where_they_stand() {
    let relative = load_obj("v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 5 5\n");
    let absolute = load_obj("v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 2 3 4\nv 5 5 5\n");
    assert_eq!(relative.triangles, absolute.triangles);
}

#[test]
fn odd_but_legal_lines_are_understood() {
    let text = "# comment\r\n\tv 0 0 0 1.0\r\nv 1 0 \\\r\n0\r\nv 0 1 0 0.5 0.5 0.5\r\nvt 0.5\r\ns off\r\nl 1 2\r\n\
                o thing\r\ng a b\r\nf 1 2 3 # a face\r\n";
    assert_eq!(load_obj(text).triangles[0].corners, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
}

#[test]
fn faces_may_come_before_their_vertices() {
    assert_eq!(load_obj("usemtl a\nf 1 2 3\nusemtl b\nv 0 0 0\nv 1 0 0\nv 0 1 0\n").triangles.len(), 1);
}

#[test]
fn groups_objects_and_materials_all_arrive() {
    let text = format!(
        "mtllib m.mtl\n{SQUARE}o one\nusemtl red\nf 1 2 3\ng two\nf 1 3 4\nusemtl blue\nf 1 2 4\no three\nusemtl red\nf 2 3 4\n"
    );
    let mtl = "newmtl blue\nKd 0 0 1\nnewmtl red\nKd 1 0 0\n";
    let scene = load_files(&[("scene.obj", &text), ("m.mtl", mtl)]);
    let red =
        scene.surfaces.iter().filter(|s| scene.materials[s.material as usize].diffuse == [1.0, 0.0, 0.0]);
    assert_eq!((scene.triangles.len(), red.count()), (4, 3));
}

#[test]
fn normals_are_unit_on_the_front_and_flat_where_missing() {
    let normals = "vn 0 0 2\nvn 0.1 0 1\nvn 0 0 0\nvn nan 0 0\n";
    let smooth = load_obj(&format!("{SQUARE}{normals}f 1//1 2//2 3//1\n"));
    let given = smooth.surfaces[0].normals;
    assert!(close(given[0], [0.0, 0.0, 1.0]));
    assert!(given.iter().all(|n| (glam::Vec3::from(*n).length() - 1.0).abs() < 1e-6));
    for face in ["f 1 2 3", "f 1//1 2//1 3//3", "f 1//1 2//1 3//4", "f 1//1 2//1 3"] {
        let scene = load_obj(&format!("{SQUARE}{normals}{face}\n"));
        assert_eq!(scene.surfaces[0].normals, [[0.0; 3]; 3], "{face}");
    }
}

#[test]
fn attributes_of_some_corners_do_not_slip_to_others() {
    // One face with all attributes, one with none, one with some.
    let text = format!("{SQUARE}vt 0.25 0.75\nvn 0 0 1\nf 1 2 3\nf 1/1/1 3/1/1 4/1/1\nf 1/1 2 4//1\n");
    let scene = load_obj(&text);
    let smooth = scene.surfaces.iter().filter(|s| s.normals == [[0.0, 0.0, 1.0]; 3]);
    assert_eq!(smooth.map(|s| s.uv).collect::<Vec<_>>(), [[[0.25, 0.75]; 3]]);
}

#[test]
fn the_winding_decides_the_front() {
    let scene = load_obj("v 0 0 0\nv 0 1 0\nv 1 0 0\nvn 0 0 1\nf 1//1 2//1 3//1\n");
    assert!(close(scene.surfaces[0].normals[0], [0.0, 0.0, -1.0]));
    assert!(scene.warnings[0].contains("1 triangles have normals on the back"), "{:?}", scene.warnings);
}

#[test]
fn degenerate_triangles_are_left_out_and_counted() {
    let scene = load_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0.1 0.3 0\nv 0.2 0.6 0\nf 1 2 3\nf 1 1 2\nf 1 4 5\n");
    assert_eq!(scene.triangles.len(), 1);
    assert!(
        scene.warnings[0].ends_with("scene.obj: 2 triangles without area left out"),
        "{:?}",
        scene.warnings
    );
}

#[test]
fn a_bare_obj_is_framed_and_lit_by_its_materials() {
    let obj = "mtllib m.mtl\nv -1 -1 -1\nv 1 -1 1\nv 1 1 1\nusemtl m\nf 1 2 3\n";
    let scene = load_files(&[("box.obj", obj), ("m.mtl", "newmtl m\nKe 1 1 1\n")]);
    assert_eq!((scene.name.as_str(), scene.width, scene.height), ("box", 512, 512));
    assert_eq!((scene.lights.len(), scene.cd_per_unit), (1, 100.0));
    assert_eq!(scene.view.at, [0.0; 3]);
    let [x, y, z] = scene.view.from;
    assert_eq!((x, y), (0.0, 0.0));
    // The nearest face of the box, at z = 1, just fits into the view.
    let seen = (z - 1.0) * (0.5 * scene.view.fov).to_radians().tan();
    assert!((1.0..1.1).contains(&seen), "{seen}");
    assert!(scene.require_light().is_ok());
}

const TRIANGLE: (&str, &str) = ("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n");

/// A grey square that faces +z, in the given size, without a light.
fn square_in_the_dark(size: f32) -> LoadedScene {
    let text = format!("v 0 0 0\nv {size} 0 0\nv {size} {size} 0\nv 0 {size} 0\nf 1 2 3 4\n");
    assert!(load_obj(&text).lights.is_empty());
    let folder = folder(&[("s.obj", &text)]);
    load_lit(&folder.path().join("s.obj")).unwrap()
}

#[test]
fn an_obj_without_light_is_lit_from_behind_the_camera() {
    for size in [1e-3, 1.0, 1e4] {
        let scene = square_in_the_dark(size);
        assert!(
            scene.warnings[0].contains("no light: no material has an emission (Ke)"),
            "{:?}",
            scene.warnings
        );
        assert!(scene.require_light().is_ok());
        assert_eq!((scene.triangles.len(), scene.lights.len()), (2, 0));
        let sky = scene.sky.as_ref().unwrap();
        assert!(!sky.visible);
        // The lamp gives white that faces it 0.75, and stands 1 back, 0.75 up and 0.65 left. The sky is 0.32 + 0.2 cos by the
        // angle from above, of which a wall gets the mean. Reflectance is ½.
        let key = 0.75 / glam::Vec3::new(1.0, 0.75, 0.65).length();
        let expected = 0.5 * (key + 0.32);
        let mut settings = Settings::new(&scene, Method::Uniform, Some(1024), Some((3, 3)));
        settings.max_depth = 2;
        let frame = render::render(&scene, &settings, Some(1), &|_| ()).unwrap();
        let middle = frame.rgb[4][0];
        assert!((middle / expected - 1.0).abs() < 0.01, "{size}: {middle} instead of {expected}");
    }
}

#[test]
fn an_obj_with_light_keeps_its_own() {
    let obj = format!("mtllib m.mtl\n{SQUARE}usemtl lamp\nf 1 2 3 4\n");
    let folder = folder(&[("s.obj", &obj), ("m.mtl", "newmtl lamp\nKe 1 1 1\n")]);
    let scene = load_lit(&folder.path().join("s.obj")).unwrap();
    assert_eq!((scene.triangles.len(), scene.lights.len(), scene.warnings.len()), (2, 2, 0));
}

/// The only triangle of a scene whose mesh has the given transform keys.
fn placed(keys: &str) -> LoadedScene {
    load_files(&[("s.toml", &format!("[[meshes]]\nfile = \"t.obj\"\n{keys}")), TRIANGLE])
}

#[test]
fn meshes_are_scaled_then_turned_then_moved() {
    let scene = placed("translate = [10, 0, 0]\nrotate = [0, 0, 90]\nscale = [2, 3, 1]\n");
    let [a, b, c] = scene.triangles[0].corners;
    assert!(
        close(a, [10.0, 0.0, 0.0]) && close(b, [10.0, 2.0, 0.0]) && close(c, [7.0, 0.0, 0.0]),
        "{a:?}{b:?}{c:?}"
    );
    let turned = placed("rotate = [90, 90, 0]\n");
    assert!(close(turned.triangles[0].corners[2], [1.0, 0.0, 0.0]), "{:?}", turned.triangles);
}

#[test]
fn normals_follow_stretched_meshes() {
    // A plane of slope 1 stretched along z: its normal keeps pointing away from it.
    let slope = "v 0 0 0\nv 1 0 1\nv 0 1 0\nvn -1 0 1\nf 1//1 2//1 3//1\n";
    let scene =
        load_files(&[("s.toml", "[[meshes]]\nfile = \"t.obj\"\nscale = [1, 1, 4]\n"), ("t.obj", slope)]);
    assert!(close(scene.surfaces[0].normals[0], front(&scene, 0).normalize().to_array()));
}

#[test]
fn mirrored_meshes_keep_their_front() {
    let scene = placed("scale = [-1, 1, 1]\n");
    assert!(front(&scene, 0).z > 0.0);
    assert_eq!(scene.surfaces[0].normals, [[0.0, 0.0, 1.0]; 3]);
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let inside_out = placed("scale = -1\n");
    assert!(front(&inside_out, 0).z < 0.0);
    assert_eq!(inside_out.surfaces[0].normals, [[0.0, 0.0, -1.0]; 3]);
}

#[test]
fn spheres_are_closed_round_and_smooth() {
    let text = "[[spheres]]\ncenter = [1, 2, 3]\nradius = 2\nsubdivisions = 4\nmaterial = \"g\"\n[materials.g]\nkind = \"glass\"\nior = 1.33\n";
    let scene = load_files(&[("s.toml", text)]);
    assert_eq!(scene.triangles.len(), 20 * 256);
    assert_eq!((scene.materials[0].scattering, scene.materials[0].ior), (Scattering::Dielectric, 1.33));
    assert!((total_area(&scene) / (16.0 * std::f32::consts::PI) - 1.0).abs() < 5e-3);
    let centre = glam::Vec3::new(1.0, 2.0, 3.0);
    for (i, (triangle, surface)) in scene.triangles.iter().zip(&scene.surfaces).enumerate() {
        for (corner, normal) in triangle.corners.iter().zip(&surface.normals) {
            let out = (glam::Vec3::from(*corner) - centre) / 2.0;
            assert!(out.distance((*normal).into()) < 1e-5 && front(&scene, i).dot(out) > 0.0);
        }
    }
}

#[test]
fn the_whole_scene_file_arrives() {
    let text = "[film]\nwidth = 30\nheight = 20\ncd_per_unit = 50\n[render]\nspp = 12\nmax_depth = 5\n\
        [camera]\nfrom = [0, 0, 5]\nat = [0, 0, 0]\nup = [1, 0, 0]\nfov = 30\n\
        [[meshes]]\nfile = \"t.obj\"\nmaterial = \"m\"\n\
        [[lights]]\ncenter = [0, 3, 0]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\nradiance = [1, 2, 3]\n\
        [materials.m]\ndiffuse = [0.1, 0.2, 0.3]\nspecular = [0.2, 0.2, 0.2]\nroughness = 0.5\n";
    let scene = load_files(&[("s.toml", text), TRIANGLE]);
    assert_eq!((scene.width, scene.height, scene.cd_per_unit), (30, 20, 50.0));
    assert_eq!((scene.spp, scene.max_depth), (Some(12), Some(5)));
    assert_eq!((scene.view.from, scene.view.up, scene.view.fov), ([0.0, 0.0, 5.0], [1.0, 0.0, 0.0], 30.0));
    assert_eq!((scene.triangles.len(), scene.lights.len()), (3, 2));
    assert_eq!((scene.materials[0].diffuse, scene.materials[0].roughness), ([0.1, 0.2, 0.3], 0.5));
    for light in &scene.lights {
        let i = light.triangle as usize;
        assert_eq!(scene.materials[scene.surfaces[i].material as usize].emission, [1.0, 2.0, 3.0]);
        // edge_u × edge_v points down.
        assert!(front(&scene, i).y < 0.0);
    }
}

#[test]
fn a_material_override_needs_no_material_file() {
    let obj = "mtllib gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nusemtl x\nf 1 2 3\n";
    let text = "[[meshes]]\nfile = \"o.obj\"\nmaterial = \"m\"\n[materials.m]\nkind = \"mirror\"\n";
    let scene = load_files(&[("s.toml", text), ("o.obj", obj)]);
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    assert!(
        scene.surfaces.iter().all(|s| scene.materials[s.material as usize].scattering == Scattering::Mirror)
    );
}

#[test]
fn the_projects_own_scenes_load_without_warnings() {
    for (name, triangles) in [("cornell", 10 + 10 + 10 + 2), ("caustic", 10 + 10 + 81920 + 2)] {
        let scene = load(&Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{name}.toml"))).unwrap();
        assert_eq!((scene.name.as_str(), scene.triangles.len()), (name, triangles));
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        assert!(Scene::new(scene.data()).is_ok());
        assert_eq!((scene.width, scene.height, scene.lights.len()), (512, 512, 2));
        let lamps = scene.lights.iter().map(|l| l.triangle as usize);
        assert!(lamps.into_iter().all(|i| front(&scene, i).y < 0.0), "{name}: the light shines up");
        // Red stands on the left of the image: on the side against forward × up.
        let forward = glam::Vec3::from(scene.view.at) - glam::Vec3::from(scene.view.from);
        let right = forward.cross(scene.view.up.into());
        let at = glam::Vec3::from(scene.view.at);
        let is_red = |i: usize| scene.materials[scene.surfaces[i].material as usize].diffuse[0] == 0.570068;
        let red = (0..scene.triangles.len()).find(|&i| is_red(i)).unwrap();
        assert!((glam::Vec3::from(scene.triangles[red].corners[0]) - at).dot(right) < 0.0, "{name}");
    }
}

#[test]
fn the_room_of_the_box_faces_inwards() {
    let scene = load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell-room.obj")).unwrap();
    let centre = glam::Vec3::new(278.0, 274.0, 280.0);
    for i in 0..scene.triangles.len() {
        let corner = glam::Vec3::from(scene.triangles[i].corners[0]);
        assert!(front(&scene, i).dot(centre - corner) > 0.0);
    }
}
