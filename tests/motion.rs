//! Motion vectors: a moving ball before a wall, and a moving camera, against geometry by hand.

mod scene_files;

use pmcip::animation::motion::{Motion, NO_OBJECT};
use pmcip::scene::{Animation, LoadedScene, View};
use scene_files::folder;

const WIDTH: u32 = 61;
const HEIGHT: u32 = 40;

/// A ball (object 1) that moves to the right by 0.2 a frame, before a wall at z = −3 (object 0) that ends at x = 4.
fn scene(camera_keys: &str) -> Animation {
    let text = format!(
        "[frames]\nfirst = 1\nlast = 11\n[camera]\nfrom = [0, 0, 5]\nat = [0, 0, 0]\nfov = 40\n\
         interpolation = \"linear\"\nkeys = [{camera_keys}]\n\
         [[meshes]]\nfile = \"wall.obj\"\n\
         [[spheres]]\ncenter = [-1, 0, 0]\nradius = 0.5\nmaterial = \"m\"\ninterpolation = \"linear\"\n\
         keys = [{{ frame = 1, center = [-1, 0, 0] }}, {{ frame = 11, center = [1, 0, 0] }}]\n[materials.m]\n"
    );
    let wall = "v -9 -9 -3\nv 4 -9 -3\nv 4 9 -3\nv -9 9 -3\nf 1 2 3 4\n";
    let dir = folder(&[("a.toml", &text), ("wall.obj", wall)]);
    Animation::load(&dir.path().join("a.toml")).unwrap()
}

/// The motion of a frame, and that of the frame before it.
fn motion(animation: &mut Animation, frame: u32) -> (Motion, Motion) {
    let look =
        |scene: &LoadedScene, before| Motion::new(scene, &scene.view, before, (WIDTH, HEIGHT), None).unwrap();
    animation.seek(frame - 1).unwrap();
    let pose = animation.scene().pose(animation.scene().view);
    let before = look(animation.scene(), &pose);
    animation.seek(frame).unwrap();
    (look(animation.scene(), &pose), before)
}

/// Film position of a point for a camera that looks along −z.
fn film(view: &View, point: [f32; 3]) -> [f32; 2] {
    let scale = HEIGHT as f32 / (2.0 * (0.5 * view.fov.to_radians()).tan());
    let [x, y, z] = [0, 1, 2].map(|i| point[i] - view.from[i]);
    [0.5 * WIDTH as f32 + scale * x / -z, 0.5 * HEIGHT as f32 - scale * y / -z]
}

/// The point that a pixel shows, for a camera that looks along −z.
fn point(view: &View, i: usize, depth: f32) -> [f32; 3] {
    let scale = 2.0 * (0.5 * view.fov.to_radians()).tan() / HEIGHT as f32;
    let x = ((i % WIDTH as usize) as f32 + 0.5 - 0.5 * WIDTH as f32) * scale;
    let y = (0.5 * HEIGHT as f32 - (i / WIDTH as usize) as f32 - 0.5) * scale;
    let length = (x * x + y * y + 1.0).sqrt();
    [0, 1, 2].map(|c| view.from[c] + depth / length * [x, y, -1.0][c])
}

#[track_caller]
fn near(a: [f32; 2], b: [f32; 2]) {
    assert!((a[0] - b[0]).abs() < 2e-3 && (a[1] - b[1]).abs() < 2e-3, "{a:?} is not {b:?}");
}

#[test]
fn a_ball_that_moves_takes_its_pixels_along() {
    let mut animation = scene("");
    let (now, before) = motion(&mut animation, 6);
    let view = animation.scene().view;
    let mut seen = [0; 3];
    for (i, sight) in now.sights.iter().enumerate() {
        let centre = [(i % WIDTH as usize) as f32 + 0.5, (i / WIDTH as usize) as f32 + 0.5];
        match sight.object {
            1 => {
                let [x, y, z] = point(&view, i, sight.depth);
                assert!((x * x + y * y + z * z - 0.25).abs() < 2e-3, "the ball is in the middle");
                near(sight.before.unwrap(), film(&view, [x - 0.2, y, z]));
            }
            object => {
                near(sight.before.unwrap(), centre);
                assert_eq!(object == NO_OBJECT, sight.depth.is_infinite());
                assert!(object == NO_OBJECT || (sight.depth_before / sight.depth - 1.0).abs() < 1e-5);
            }
        }
        // What the ball has uncovered was not there before; everything else was.
        let uncovered = sight.object == 0 && before.sights[i].object == 1;
        let source = now.source(i, &before);
        if sight.object != 1 {
            assert_eq!(source, (!uncovered).then_some(i), "pixel {i}");
        }
        seen[sight.object.min(2) as usize] += 1;
        if let Some(source) = source.filter(|_| sight.object == 1) {
            assert_eq!(before.sights[source].object, 1);
        }
    }
    assert!(seen[0] > 500 && seen[1] > 30 && seen[2] > 100, "{seen:?}");
    let lost = (0..now.sights.len()).filter(|&i| now.source(i, &before).is_none()).count();
    assert!((5..40).contains(&lost), "{lost} pixels have no source");
}

#[test]
fn a_camera_that_moves_shifts_what_is_near_and_not_what_is_far() {
    let keys =
        "{ frame = 1, from = [0, 0, 5], at = [0, 0, 0] }, { frame = 11, from = [2, 0, 5], at = [2, 0, 0] }";
    let mut animation = scene(keys);
    let (now, _) = motion(&mut animation, 6);
    let view = animation.scene().view;
    let then = View { from: [view.from[0] - 0.2, 0.0, 5.0], ..view };
    for (i, sight) in now.sights.iter().enumerate() {
        let centre = [(i % WIDTH as usize) as f32 + 0.5, (i / WIDTH as usize) as f32 + 0.5];
        match sight.object {
            // The ball moves as the camera does.
            1 => near(sight.before.unwrap(), centre),
            NO_OBJECT => near(sight.before.unwrap(), centre),
            _ => near(sight.before.unwrap(), film(&then, point(&view, i, sight.depth))),
        }
    }
    assert!(now.source(0, &now).is_some());
}

#[test]
fn another_scene_is_refused() {
    let animation = scene("");
    let mut pose = animation.scene().pose(animation.scene().view);
    pose.placements.pop();
    assert!(Motion::new(animation.scene(), &pose.view, &pose, (8, 8), None).is_err());
}
