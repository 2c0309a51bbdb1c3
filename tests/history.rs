//! Filtered frames blended with those before them: what stands still becomes quiet, and what changes does not lag.

mod scene_files;

use pmcip::animation::startup::Predictor;
use pmcip::frame::render::{render, render_next};
use pmcip::frame::settings::{Method, Settings};
use pmcip::picture::metrics::luminance;
use pmcip::scene::Animation;
use pmcip_core::maths::tvi::tvi;
use pmcip_core::sampler::Error;
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::guide::Feature;
use pmcip_core::sampler::guide::history::{Blend, Past, carry};
use scene_files::folder;
use tempfile::TempDir;
use wide::f32x8;

const SIDE: u32 = 64;

/// The Cornell box with these keys of camera and lamp, and a second lamp without keys.
fn scene(camera: &str, lamp: &str) -> (TempDir, Animation) {
    let text = format!(
        "[film]\nwidth = {SIDE}\nheight = {SIDE}\n[frames]\nfirst = 1\nlast = 9\n\
         [camera]\nfrom = [278, 273, -800]\nat = [278, 273, 0]\nfov = 39.3\n{camera}\n\
         [[meshes]]\nfile = \"cornell-room.obj\"\n[[meshes]]\nfile = \"cornell-tall-block.obj\"\n\
         [[lights]]\ncenter = [278, 547, 279]\nedge_u = [65, 0, 0]\nedge_v = [0, 0, 52]\nradiance = [18, 11, 3]\n{lamp}\n\
         [[lights]]\ncenter = [100, 540, 100]\nedge_u = [20, 0, 0]\nedge_v = [0, 0, 20]\nradiance = [4, 4, 4]\n"
    );
    let names = ["cornell-room.obj", "cornell-tall-block.obj", "cornell.mtl"];
    let files = names.map(|name| (name, std::fs::read_to_string(format!("scenes/{name}")).unwrap()));
    let files: Vec<_> = files.iter().map(|(name, text)| (*name, text.as_str())).collect();
    let dir = folder(&[&[("a.toml", text.as_str())][..], &files].concat());
    let animation = Animation::load(&dir.path().join("a.toml")).unwrap();
    (dir, animation)
}

/// The frames from the first to `last`, each on its own or with history.
fn frames(animation: &mut Animation, last: u32, history: bool) -> Vec<Vec<[f32; 3]>> {
    let mut predictor = Predictor::default();
    let frame = |frame| {
        animation.seek(frame).unwrap();
        let scene = animation.scene();
        let mut settings = Settings::new(scene, Method::Pmc, Some(16), None);
        settings.set_estimator(Estimator::Guided);
        (settings.sampler.frame, settings.history) = (frame, history);
        render_next(scene, &settings, Some(2), &|_| (), &mut predictor).unwrap().rgb
    };
    (1..=last).map(frame).collect()
}

/// What a frame would be with very many samples.
fn truth(animation: &mut Animation, frame: u32) -> Vec<[f32; 3]> {
    animation.seek(frame).unwrap();
    let settings = Settings::new(animation.scene(), Method::Uniform, Some(1024), None);
    render(animation.scene(), &settings, Some(2), &|_| ()).unwrap().rgb
}

fn err(picture: &[[f32; 3]], truth: &[[f32; 3]]) -> f64 {
    let pixel = |(a, b): (&[f32; 3], &[f32; 3])| {
        let e = 100.0 * (luminance(*a) - luminance(*b));
        let threshold = tvi(f32x8::splat(100.0 * luminance(*b) as f32)).to_array()[0];
        e * e / f64::from(threshold)
    };
    picture.iter().zip(truth).map(pixel).sum::<f64>() / truth.len() as f64
}

fn energy(picture: &[[f32; 3]]) -> f64 {
    picture.iter().map(|rgb| luminance(*rgb)).sum()
}

/// Frame by frame, a picture with history has the energy of the one without: that of the frame's own samples.
fn same_energy(with: &[Vec<[f32; 3]>], without: &[Vec<[f32; 3]>]) {
    for (with, without) in with.iter().zip(without) {
        assert!((energy(with) / energy(without) - 1.0).abs() < 1e-5);
    }
}

#[test]
fn what_stands_still_becomes_quiet() {
    let (_dir, mut still) = scene("", "");
    let (with, without) = (frames(&mut still, 6, true), frames(&mut still, 6, false));
    let truth = truth(&mut still, 1);
    assert!(with[0] == without[0], "a first frame has no history");
    same_energy(&with, &without);
    for (with, without) in with.iter().zip(&without).skip(1) {
        let (with, without) = (err(with, &truth), err(without, &truth));
        assert!(with < 0.9 * without, "{with}, without history {without}");
    }
    let change = |frames: &[Vec<[f32; 3]>]| err(&frames[5], &frames[4]);
    assert!(change(&with) < 0.5 * change(&without), "{} and {}", change(&with), change(&without));
}

/// Err of the frame in which something happens and of the next is at most 1.05 times what it is without history.
#[track_caller]
fn does_not_lag(what: (TempDir, Animation)) {
    let (_dir, mut animation) = what;
    let (with, without) = (frames(&mut animation, 5, true), frames(&mut animation, 5, false));
    same_energy(&with, &without);
    for frame in [4, 5] {
        let truth = truth(&mut animation, frame);
        let i = frame as usize - 1;
        let (with, without) = (err(&with[i], &truth), err(&without[i], &truth));
        assert!(with < 1.05 * without, "frame {frame}: {with}, without history {without}");
    }
}

fn lamp(powers: [f32; 3]) -> String {
    let [before, then, after] = powers;
    let keys = [(3, before), (4, then), (5, after)];
    let keys = keys.map(|(frame, power)| format!("{{ frame = {frame}, power = {power} }}"));
    format!("keys = [{}]", keys.join(", "))
}

#[test]
fn a_flash_is_gone_when_it_is_over() {
    does_not_lag(scene("", &lamp([1.0, 20.0, 1.0])));
}

#[test]
fn a_lamp_that_is_switched_off_is_dark_at_once() {
    does_not_lag(scene("", &lamp([1.0, 0.0, 0.0])));
}

#[test]
fn a_camera_that_jumps_sees_the_new_view() {
    let keys = "keys = [{ frame = 3, from = [278, 273, -800] }, { frame = 4, from = [150, 400, -300] }]";
    does_not_lag(scene(keys, ""));
}

#[test]
fn a_lamp_that_fades_does_not_leave_its_light_behind() {
    let (_dir, mut fading) = scene("", "keys = [{ frame = 1, power = 1 }, { frame = 9, power = 0.1 }]");
    let (with, without) = (frames(&mut fading, 8, true), frames(&mut fading, 8, false));
    same_energy(&with, &without);
    let truth = truth(&mut fading, 8);
    let (with, without) = (err(&with[7], &truth), err(&without[7], &truth));
    assert!(with < 1.05 * without, "{with}, without history {without}");
}

/// What is carried is interpolated between pixels of the same surface.
#[test]
fn the_past_is_fetched_between_pixels_of_one_surface() {
    let wall = |normal: f32, depth| Feature { albedo: [0.5; 3], normal: [normal, 0.0, 0.0], depth };
    let past =
        |light: f32, normal, depth| Past { light: [light; 3], variance: 1.0, feature: wall(normal, depth) };
    let before = [past(1.0, 1.0, 5.0), past(3.0, 1.0, 5.0), past(9.0, -1.0, 5.0), past(9.0, 1.0, 8.0)];
    let mut out = [Past::NONE; 4];
    let now = [wall(1.0, 5.0); 4];
    let positions = [[1.0, 0.5], [1.9, 0.5], [2.5, 0.5], [f32::NAN, 0.5]];
    carry(&before, 4, &positions, &now, &[], &mut out).unwrap();
    assert_eq!(out[0].light, [2.0; 3]);
    // The right neighbour is another wall: what is left has weight 0.6 and counts alone.
    assert_eq!(out[1].light, [3.0; 3]);
    assert_eq!([out[2].variance, out[3].variance], [f32::INFINITY; 2]);
    assert_eq!(carry(&before, 3, &positions, &now, &[], &mut out), Err(Error::Guide));
    assert_eq!(carry(&before, 4, &positions, &now, &[], &mut out[1..]), Err(Error::Output));
}

/// Whatever past and present are, the blend is finite, and where there is no past it is the present.
#[test]
fn any_past_blends_to_what_is_finite() {
    let odd = [0.0, 1.0, -3.0, f32::NAN, f32::INFINITY, f32::MAX, f32::MIN, 1e-40, 1e15];
    let (width, pixels) = (9, 63);
    let value = |i: usize| odd[(i * 7 + i / 5) % odd.len()];
    let features: Vec<Feature> = (0..pixels)
        .map(|i| Feature { albedo: [value(i), 0.5, 2.0], normal: [value(i + 1); 3], depth: value(i + 2) })
        .collect();
    let filtered: Vec<[f32; 3]> = (0..pixels).map(|i| [i as f32, 1.0, -1.0]).collect();
    let variance: Vec<f32> = (0..pixels).map(|i| (i % 3) as f32).collect();
    let wild: Vec<Past> = (0..pixels)
        .map(|i| Past { light: [value(i), value(2 * i), 1.0], variance: value(i + 4), feature: features[i] })
        .collect();
    for carried in [vec![Past::NONE; pixels], wild] {
        let blend = Blend {
            width,
            filtered: &filtered,
            variance: &variance,
            features: &features,
            carried: &carried,
            labels: &[],
        };
        let (mut work, mut kept, mut out) =
            (vec![[0.0; 2]; pixels], vec![Past::NONE; pixels], vec![[0.0; 3]; pixels]);
        blend.run(&mut work, &mut kept, &mut out).unwrap();
        assert!(out.as_flattened().iter().all(|v| v.is_finite()));
        if carried[0].variance == f32::INFINITY {
            let near = |(a, b): (&f32, &f32)| (a - b).abs() <= 1e-5 * b.abs();
            assert!(out.as_flattened().iter().zip(filtered.as_flattened()).all(near));
        }
        assert_eq!(blend.run(&mut work, &mut kept, &mut out[1..]), Err(Error::Output));
    }
}
