//! Animated scenes: what keys do to camera, objects and lights, and what is wrong with them.

mod scene_files;

use pmcip::scene::{Animation, Change};
use scene_files::{SQUARE, folder};
use tempfile::TempDir;

const FRAMES: &str = "[frames]\nfirst = 1\nlast = 21\n";

/// A scene of one square mesh, a sphere and a light, with these keys for each.
fn scene(camera: &str, mesh: &str, sphere: &str, light: &str) -> (TempDir, Animation) {
    let text = format!(
        "{FRAMES}[camera]\nfrom = [0, 0, 9]\nat = [0, 0, 0]\nfov = 40\n{camera}\n\
         [[meshes]]\nfile = \"s.obj\"\n{mesh}\n\
         [[spheres]]\ncenter = [0, 4, 0]\nradius = 1\nsubdivisions = 1\nmaterial = \"m\"\n{sphere}\n\
         [[lights]]\ncenter = [0, 9, 0]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\nradiance = [4, 2, 1]\n{light}\n\
         [materials.m]\n"
    );
    let dir = folder(&[("a.toml", &text), ("s.obj", &format!("{SQUARE}f 1 2 3 4\n"))]);
    let animation = Animation::load(&dir.path().join("a.toml")).unwrap();
    (dir, animation)
}

/// The box around an object.
fn bounds(animation: &Animation, object: u32) -> [[f32; 3]; 2] {
    let scene = animation.scene();
    let triangles = scene.triangles.iter().zip(&scene.objects).filter(|(_, o)| **o == object);
    let corners = triangles.flat_map(|(t, _)| t.corners);
    corners.fold([[f32::MAX; 3], [f32::MIN; 3]], |[low, high], p| {
        [[0, 1, 2].map(|i| low[i].min(p[i])), [0, 1, 2].map(|i| high[i].max(p[i]))]
    })
}

#[track_caller]
fn near(a: [[f32; 3]; 2], b: [[f32; 3]; 2]) {
    let close = a.as_flattened().iter().zip(b.as_flattened()).all(|(a, b)| (a - b).abs() < 1e-5);
    assert!(close, "{a:?} is not {b:?}");
}

#[test]
fn a_camera_that_moves_alone_leaves_the_scene_as_it_is() {
    let keys = "keys = [{ frame = 1, fov = 40 }, { frame = 21, from = [4, 0, 9], fov = 60 }]";
    let (_dir, mut animation) = scene(keys, "", "", "");
    let before = animation.scene().clone();
    let change = animation.seek(11).unwrap();
    assert_eq!(change, Change { view: true, light: false, geometry: None });
    let now = animation.scene();
    // `from` has but one key, so it holds; `fov` is half-way.
    assert_eq!((now.view.from, now.view.fov), ([4.0, 0.0, 9.0], 50.0));
    assert_eq!((&now.triangles, &now.nodes), (&before.triangles, &before.nodes));
    assert_eq!(animation.seek(11).unwrap(), Change::default());
    assert_eq!(animation.seek(99).unwrap(), Change { view: true, ..Change::default() });
    assert_eq!(animation.scene().view.fov, 60.0);
}

#[test]
fn meshes_move_turn_and_grow_as_their_keys_say() {
    let keys = "interpolation = \"linear\"\nkeys = [\n\
                { frame = 1, translate = [0, 0, 0], rotate = [0, 0, 0], scale = 1 },\n\
                { frame = 21, translate = [10, 0, -2], rotate = [0, 0, 90], scale = 3 }]";
    let (_dir, mut animation) = scene("", keys, "", "");
    near(bounds(&animation, 0), [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0]]);
    assert!(animation.seek(21).unwrap().geometry.is_some());
    near(bounds(&animation, 0), [[7.0, 0.0, -2.0], [10.0, 3.0, -2.0]]);
    animation.seek(11).unwrap();
    // Turned by 45° and twice as large: a square on its corner.
    let side = 2.0 / 2f32.sqrt();
    near(bounds(&animation, 0), [[5.0 - side, 0.0, -1.0], [5.0 + side, 2.0 * side, -1.0]]);
    // The others stand still, and the hierarchy fits.
    near(bounds(&animation, 2), [[-1.0, 9.0, -1.0], [1.0, 9.0, 1.0]]);
    let data = animation.scene().data();
    assert!(pmcip_core::tracer::scene::Scene::new(data).is_ok());
}

#[test]
fn spheres_and_lights_move() {
    let sphere = "keys = [{ frame = 1, center = [0, 4, 0], radius = 1 }, { frame = 21, center = [2, 4, 0], radius = 2 }]";
    let light =
        "keys = [{ frame = 1, center = [0, 9, 0] }, { frame = 21, center = [0, 7, 0], edge_u = [2, 0, 0] }]";
    let (_dir, mut animation) = scene("", "", sphere, light);
    animation.seek(11).unwrap();
    let [low, high] = bounds(&animation, 1);
    assert!(
        (low[1] - 2.5).abs() < 0.1 && (high[1] - 5.5).abs() < 0.1 && (low[0] + 0.5).abs() < 0.1,
        "{low:?}"
    );
    near(bounds(&animation, 2), [[-2.0, 8.0, -1.0], [2.0, 8.0, 1.0]]);
    assert_eq!(animation.scene().lights.len(), 2);
    // A point of the light goes where the light goes.
    let now = animation.scene().placements[2];
    animation.seek(21).unwrap();
    let shift = now.towards(&animation.scene().placements[2]);
    assert!(shift.position([1.0, 8.0, 0.5].into()).distance([1.0, 7.0, 0.5].into()) < 1e-5);
}

#[test]
fn lamps_and_materials_glow_as_their_keys_say() {
    let light = "interpolation = \"linear\"\nkeys = [{ frame = 1, power = 1 }, { frame = 11, power = 0 },\n\
                 { frame = 21, power = 3, radiance = [2, 2, 2] }]";
    let (_dir, mut animation) = scene("", "", "", light);
    let all = |animation: &Animation| -> Vec<[f32; 3]> {
        animation.scene().materials.iter().map(|m| m.emission).filter(|e| e[0] > 0.0).collect()
    };
    assert_eq!(all(&animation), [[2.0, 2.0, 2.0]]);
    assert_eq!(animation.seek(6).unwrap(), Change { light: true, ..Change::default() });
    assert_eq!(all(&animation), [[1.0, 1.0, 1.0]]);
    animation.seek(11).unwrap();
    assert!(animation.scene().lights.is_empty() && animation.scene().require_light().is_err());
    animation.seek(21).unwrap();
    assert_eq!(all(&animation), [[6.0, 6.0, 6.0]]);
    assert_eq!(animation.scene().lights.len(), 2);
}

#[test]
fn going_back_makes_the_same_scene() {
    let keys = "keys = [{ frame = 1, rotate = [0, 0, 0] }, { frame = 9, rotate = [50, 20, 0] }, { frame = 21, rotate = [0, 90, 9] }]";
    let (_dir, mut animation) = scene("", keys, "", "");
    animation.seek(14).unwrap();
    let there = animation.scene().clone();
    animation.seek(3).unwrap();
    assert_ne!(animation.scene().triangles, there.triangles);
    animation.seek(14).unwrap();
    assert_eq!(animation.scene().triangles, there.triangles);
    assert_eq!(animation.scene().nodes, there.nodes);
}

/// The message for a scene file of this text.
#[track_caller]
fn fails(text: &str, expected: &str) {
    let dir = folder(&[("a.toml", text), ("s.obj", &format!("{SQUARE}f 1 2 3 4\n"))]);
    let error = Animation::load(&dir.path().join("a.toml")).expect_err("the input is accepted").to_string();
    let error = error.replace(&format!("{}{}", dir.path().display(), std::path::MAIN_SEPARATOR), "");
    assert!(error.starts_with(expected), "{error}");
}

#[test]
fn keys_that_make_no_sense_name_the_line() {
    let mesh = "[[meshes]]\nfile = \"s.obj\"\n";
    let sphere = "[[spheres]]\ncenter = [0, 0, 0]\nradius = 1\nmaterial = \"m\"\n";
    fails(
        &format!("{mesh}keys = [{{ frame = 1 }}]\n"),
        "a.toml:3: keys need a table [frames] with first and last",
    );
    fails(
        &format!("{FRAMES}{mesh}keys = [\n{{ frame = 4 }},\n{{ frame = 4 }}]\n"),
        "a.toml:8: keys: frame 4 does not come after frame 4",
    );
    fails(
        &format!("{FRAMES}{mesh}keys = [\n{{ frame = 4, rotation = [0, 0, 0] }}]\n"),
        "a.toml:7: unknown field `rotation`",
    );
    fails(
        &format!("{FRAMES}{mesh}[[meshes.keys]]\nframe = 1\nscale = 0\n"),
        "a.toml:8: expected finite factors other than 0",
    );
    fails(&format!("{FRAMES}{mesh}[[meshes.keys]]\nscale = 1\n"), "a.toml:6: missing field `frame`");
    fails(&format!("{FRAMES}{mesh}[[meshes.keys]]\nframe = -1\n"), "a.toml:7: ");
    fails(
        &format!(
            "{FRAMES}{mesh}keys = [\n{{ frame = 1, scale = [1, 1, 1] }},\n{{ frame = 2, scale = [1, -1, 1] }}]\n"
        ),
        "a.toml:8: keys: a factor of scale changes its sign",
    );
    fails(
        &format!("{FRAMES}{mesh}interpolation = \"cubic\"\n"),
        "a.toml:6: unknown variant `cubic`, expected `linear` or `smooth`",
    );
    fails(
        &format!("{FRAMES}{sphere}keys = [{{ frame = 1, radius = 0 }}]\n"),
        "a.toml:8: expected a finite number above 0",
    );
    fails("[frames]\nfirst = 5\nlast = 4\n", "a.toml:1: frames: the first, 5, is after the last, 4");
    fails("[frames]\nfirst = 5\nlast = 9\nfps = 0\n", "a.toml:4: expected a finite number above 0");
    fails(
        "[frames]\nfirst = 5\nend = 9\n",
        "a.toml:3: unknown field `end`, expected one of `first`, `last`, `fps`",
    );
}

#[test]
fn frames_that_cannot_be_seen_are_named() {
    let keys = "keys = [{ frame = 1, from = [0, 0, 9] }, { frame = 21, from = [0, 0, -9] }]";
    let (_dir, mut animation) = scene(keys, "", "", "");
    let message = animation.seek(11).unwrap_err().to_string();
    assert!(message.ends_with("a.toml: frame 11: camera: from and at are the same point"), "{message}");
    let keys = "keys = [{ frame = 1, edge_u = [1, 0, 0] }, { frame = 21, edge_u = [0, 0, 1] }]";
    let (_dir, mut animation) = scene("", "", "", keys);
    let message = animation.seek(21).unwrap_err().to_string();
    assert!(message.ends_with("frame 21: lights: edge_u and edge_v span no area"), "{message}");
}

#[test]
fn a_turn_of_more_than_half_a_circle_is_worth_a_warning() {
    let keys = "keys = [{ frame = 1, rotate = [0, 0, 0] }, { frame = 21, rotate = [0, 360, 0] }]";
    let (_dir, animation) = scene("", keys, "", "");
    assert!(animation.scene().warnings[0].contains("from frame 1 to 21 angles differ by more than 180°"));
}

#[test]
fn the_animated_scenes_of_this_project_load_at_every_frame() {
    let scenes = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    for name in ["cornell-anim"] {
        let mut animation = Animation::load(&scenes.join(name).with_extension("toml")).unwrap();
        let frames = animation.frames().unwrap();
        for frame in [frames.first, frames.first + 1, (frames.first + frames.last) / 2, frames.last] {
            animation.seek(frame).unwrap();
            assert!(animation.scene().require_light().is_ok(), "{name}, frame {frame}");
        }
    }
}
