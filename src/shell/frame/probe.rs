//! A look before the render: does the camera stand where a picture can be made?

use crate::error::Error;
use crate::frame::render;
use crate::frame::settings::{Integrator, Layer, Method, Settings};
use crate::picture::metrics::luminance;
use crate::scene::LoadedScene;
use glam::Vec3;
use pmcip_core::maths::vec3::Vec3x8;
use pmcip_core::tracer::scene::{Scattering, Scene};
use pmcip_core::tracer::trace::{MISS, Rays8, Tracer};
use wide::f32x8;

/// Side of the trial picture in pixels, a multiple of eight.
const SIDE: u32 = 32;
/// Samples a pixel of the trial picture.
const SPP: u32 = 16;

/// Side in pixels of the blocks by which a trial picture is judged: 256 samples each.
const BLOCK: u32 = 4;
/// Luminance below which a block is black to the eye: code 12 of 255.
const BLACK: f64 = 0.004;
/// Part of what is seen that must not be black.
const LEAST_LIT: f64 = 0.25;

/// Whether less than a quarter of what the camera sees of the scene is lit, in a tiny trial picture at `exposure` stops. Where
/// nothing is seen there is no matter of light.
///
/// # Errors
/// As [`render::render`].
pub fn is_dark(scene: &LoadedScene, settings: &Settings, exposure: f32) -> Result<bool, Error> {
    let mut trial = trial(scene, settings);
    trial.layers = [Layer::Coverage].into_iter().collect();
    let frame = render::render(scene, &trial, Some(1), &|_| ())?;
    let coverage = &frame.layers[Layer::Coverage.channels()[0]];
    let starts = (0..SIDE).step_by(BLOCK as usize);
    let blocks = starts.clone().flat_map(|y| starts.clone().map(move |x| (x, y)));
    let (mut seen, mut lit) = (0.0, 0.0);
    for (x, y) in blocks {
        let pixels = (0..BLOCK * BLOCK).map(|i| ((y + i / BLOCK) * SIDE + x + i % BLOCK) as usize);
        let covered: f32 = pixels.clone().map(|pixel| coverage[pixel]).sum();
        if covered < 0.5 * (BLOCK * BLOCK) as f32 {
            continue;
        }
        let light: f64 = pixels.map(|pixel| luminance(frame.rgb[pixel])).sum();
        seen += 1.0;
        lit += f64::from(u8::from(light / f64::from(covered) * f64::from(exposure).exp2() > BLACK));
    }
    Ok(seen > 0.0 && lit < LEAST_LIT * seen)
}

/// The settings of a tiny trial picture.
fn trial(scene: &LoadedScene, settings: &Settings) -> Settings {
    let mut trial = Settings::new(scene, Method::Uniform, Some(SPP), Some((SIDE, SIDE)));
    (trial.view, trial.closing_view) = (settings.view, settings.closing_view);
    trial.max_depth = settings.max_depth;
    // Paths see what the photon map shows, without shooting it.
    trial.integrator = match settings.integrator {
        Integrator::Gather { .. } => Integrator::Path,
        other => other,
    };
    trial
}

/// Renders a tiny trial picture. If no light arrives in it at all, says so: as an error where the camera is
/// enclosed by the backs of surfaces, else as a warning.
///
/// # Errors
/// [`Error::Setting`] if the camera is inside a wall, and as [`render::render`].
pub fn look(scene: &LoadedScene, settings: &Settings) -> Result<Option<String>, Error> {
    let frame = render::render(scene, &trial(scene, settings), Some(1), &|_| ())?;
    if frame.rgb.iter().flatten().any(|v| *v > 0.0) {
        return Ok(None);
    }
    let [x, y, z] = [0, 1, 2].map(|i| f64::from(settings.view.from[i]) + scene.origin[i]);
    if sees_only_backs(scene, settings)? {
        let why = "every ray from it meets the back of a surface and no light arrives";
        return Err(Error::Setting(format!("the camera at {x},{y},{z} is inside a wall: {why}")));
    }
    Ok(Some(format!("no light reached the camera at {x},{y},{z} in a trial: the picture may be black")))
}

/// Whether all rays of a coarse grid end on the backs of opaque surfaces.
fn sees_only_backs(scene: &LoadedScene, settings: &Settings) -> Result<bool, Error> {
    let camera = settings.view.camera(SIDE, SIDE).map_err(Error::setting)?;
    let checked = Scene::new(scene.data()).map_err(Error::setting)?;
    let mut tracer = Tracer::new(checked);
    let columns = f32x8::new([0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5]);
    let starts = (0..SIDE).flat_map(|y| (0..SIDE).step_by(8).map(move |x| (x as f32, y as f32 + 0.5)));
    Ok(starts.into_iter().all(|(x, y)| {
        let direction = camera.directions(columns + f32x8::splat(x), f32x8::splat(y));
        let origin = Vec3x8::splat(camera.origin());
        let rays = Rays8 { origin, direction, t_max: f32x8::splat(f32::INFINITY), ..Rays8::default() };
        let hit = tracer.closest(&rays).triangle.to_array();
        let [dx, dy, dz] = [direction.x, direction.y, direction.z].map(f32x8::to_array);
        (0..8).all(|lane| is_back(scene, hit[lane], Vec3::new(dx[lane], dy[lane], dz[lane])))
    }))
}

fn is_back(scene: &LoadedScene, triangle: u32, direction: Vec3) -> bool {
    if triangle == MISS {
        return false;
    }
    let surface = &scene.surfaces[triangle as usize];
    let opaque = scene.materials[surface.material as usize].scattering != Scattering::Dielectric;
    let [a, b, c] = scene.triangles[triangle as usize].corners.map(Vec3::from_array);
    opaque && (b - a).cross(c - a).dot(direction) > 0.0
}
