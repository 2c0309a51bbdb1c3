//! Frames of a scene from one place, turned: pictures between which the true motion is a homography.

use pmcip::frame::render;
use pmcip::frame::settings::{Method, Settings};
use pmcip::scene::{LoadedScene, View};
use pmcip_core::predict::features::{self, Picture};
use pmcip_core::predict::homography::{Homography, Pair};

/// Side of the pictures in pixels.
pub const SIDE: usize = 512;
/// Where the camera looks and what is up: moved by 18 pixels, by 100, and rolled by 22 degrees as well.
pub const TURNS: [(&str, [f32; 3], [f32; 3]); 3] = [
    ("small", [290.0, 268.0, 0.0], [0.0, 1.0, 0.0]),
    ("large", [218.0, 303.0, 0.0], [0.1, 1.0, 0.0]),
    ("rolled", [120.0, 373.0, 0.0], [0.4, 1.0, 0.0]),
];

/// A uniformly sampled frame in steps of 1/255 of white, median filtered.
pub fn coded(scene: &LoadedScene, view: View, spp: u32, seed: u32) -> Vec<f32> {
    let side = SIDE as u32;
    let mut settings = Settings::new(scene, Method::Uniform, Some(spp), Some((side, side)));
    (settings.view, settings.sampler.seed) = (view, seed);
    let frame = render::render(scene, &settings, None, &|_| ()).expect("a frame renders");
    let code = |rgb: &[f32; 3]| {
        let luminance = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
        (255.0 * luminance.clamp(0.0, 1.0).powf(1.0 / 2.2)).round() / 255.0
    };
    let coded: Vec<f32> = frame.picture(&settings, scene).rgb.iter().map(code).collect();
    let mut filtered = vec![0.0; coded.len()];
    let picture = Picture::new(&coded, SIDE, SIDE).expect("a picture of that size");
    features::median3(picture, &mut filtered).expect("as many values");
    filtered
}

/// The homography from one view to another from the same place.
pub fn motion(from: &View, to: &View) -> Homography {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| {
        let from_pixel = [x * SIDE as f64, y * SIDE as f64];
        let (a, b) = (axes(from), axes(to));
        let half = (f64::from(from.fov) / 2.0).to_radians().tan();
        let (u, v) = (half * (2.0 * x - 1.0), half * (2.0 * y - 1.0));
        let direction = [0, 1, 2].map(|i| u * a[0][i] + v * a[1][i] + a[2][i]);
        let [r, d, f] = b.map(|axis| (0..3).map(|i| axis[i] * direction[i]).sum::<f64>());
        let pixel = |t: f64| (t / f / half + 1.0) / 2.0 * SIDE as f64;
        Pair { from: from_pixel, to: [pixel(r), pixel(d)] }
    });
    Homography::through(&corners).expect("the views overlap")
}

/// A view's right, down and forward.
fn axes(view: &View) -> [[f64; 3]; 3] {
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [0, 1, 2].map(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            a[j] * b[k] - a[k] * b[j]
        })
    };
    let unit = |a: [f64; 3]| {
        let length = a.iter().map(|c| c * c).sum::<f64>().sqrt();
        a.map(|c| c / length)
    };
    let forward = unit([0, 1, 2].map(|i| f64::from(view.at[i]) - f64::from(view.from[i])));
    let right = unit(cross(forward, view.up.map(f64::from)));
    [right, cross(forward, right), forward]
}
