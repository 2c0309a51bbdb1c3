//! The scene lit by its lightmap, beside the path tracer: whether the lightmap is what it should be.

use super::atlas::Atlas;
use super::light::Lightmap;
use crate::error::Error;
use crate::frame::features::Sight;
use crate::frame::render;
use crate::frame::settings::Settings;
use crate::frame::threads::{each, start_threads};
use crate::picture::frame_io::Picture;
use crate::picture::metrics::luminance;
use crate::scene::LoadedScene;
use pmcip_core::maths::sobol::{hash, point};
use pmcip_core::sampler::batch::Batch8;
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::tracer::camera::{Camera, Primary};
use pmcip_core::tracer::scene::{Scattering, Scene};
use pmcip_core::tracer::shade::cutout::seen;
use pmcip_core::tracer::trace::{MISS, Rays8, Tracer};
use std::f32::consts::PI;
use wide::{f32x8, u32x8};

/// Columns of black between the two pictures.
const GAP: u32 = 4;

/// The two pictures side by side, and how they differ.
#[derive(Clone, Debug)]
pub struct Check {
    /// Lightmap to the left, path tracer to the right.
    pub picture: Picture,
    /// How pixels differ that show nothing but baked, purely diffuse surfaces; none if there are none.
    pub difference: Option<Difference>,
}

/// How the lightmap's picture differs from the path tracer's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Its mean luminance over the path tracer's, less 1.
    pub energy_bias: f64,
    /// Root mean square difference of luminance, over the mean.
    pub rms: f64,
}

/// What eight rays through a pixel see of the lightmap.
#[derive(Clone, Copy, Default)]
struct Lit {
    irradiance: [f32; 3],
    emission: [f32; 3],
    /// Whether all of them met what the lightmap and its albedo say all about.
    whole: bool,
}

/// Renders the scene both ways, seen as `settings` say.
///
/// # Errors
/// As [`render::render`].
pub fn check(
    scene: &LoadedScene,
    atlas: &Atlas<'_>,
    lightmap: &Lightmap,
    settings: &Settings,
    threads: Option<usize>,
) -> Result<Check, Error> {
    let mut settings = *settings;
    settings.set_estimator(Estimator::Guided);
    let frame = render::render(scene, &settings, threads, &|_| ())?;
    let (width, height) = (settings.sampler.width, settings.sampler.height);
    let camera = settings.view.camera(width, height).map_err(Error::setting)?;
    let core = Scene::new(scene.data()).map_err(Error::setting)?;
    let pool = start_threads(threads)?;
    let sight = Sight { scene: core, camera, max_depth: 1, size: (width, height) };
    let shown = sight.look(false, pool.as_ref())?;
    let mut lit = vec![Lit::default(); frame.rgb.len()];
    each(pool.as_ref(), lit.chunks_mut(width as usize).enumerate().collect(), |(y, row)| {
        let mut tracer = Tracer::new(core);
        for (x, lit) in (0..).zip(row) {
            *lit = look(scene, atlas, lightmap, &mut tracer, &camera, (x, y as u32));
        }
    });
    let baked = lit.iter().zip(&shown.features);
    let baked: Vec<[f32; 3]> = baked
        .map(|(lit, feature)| [0, 1, 2].map(|c| lit.emission[c] + feature.albedo[c] * lit.irradiance[c] / PI))
        .collect();
    let whole = baked.iter().zip(&frame.rgb).zip(&lit).filter(|(_, lit)| lit.whole);
    let difference = difference(whole.map(|((baked, traced), _)| (luminance(*baked), luminance(*traced))));
    Ok(Check { picture: beside(&baked, &frame.rgb, width), difference })
}

/// How luminances differ from true ones; none if there are none or all is black.
fn difference(pairs: impl Iterator<Item = (f64, f64)>) -> Option<Difference> {
    let (mut ours, mut truth, mut square, mut count) = (0.0, 0.0, 0.0, 0.0);
    for (baked, traced) in pairs {
        (ours, truth, count) = (ours + baked, truth + traced, count + 1.0);
        square += (baked - traced) * (baked - traced);
    }
    let some = Difference { energy_bias: ours / truth - 1.0, rms: f64::sqrt(square * count) / truth };
    (truth > 0.0).then_some(some)
}

/// Looks through a pixel with eight rays.
fn look(
    scene: &LoadedScene,
    atlas: &Atlas<'_>,
    lightmap: &Lightmap,
    tracer: &mut Tracer<'_>,
    camera: &Camera,
    (x, y): (u32, u32),
) -> Lit {
    let index = u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]);
    let key = u32x8::splat(hash(y << 16 | x));
    let (u, v) = point(index, key, 0);
    let (x, y) = (f32x8::splat(x as f32) + u, f32x8::splat(y as f32) + v);
    let Primary { origin, direction } = camera.rays(&Batch8 { lanes: 8, x, y, index, key });
    let hits =
        seen(tracer, &Rays8 { origin, direction, t_max: f32x8::splat(f32::INFINITY), ..Rays8::default() });
    let direction = [direction.x, direction.y, direction.z].map(f32x8::to_array);
    let (triangles, u, v) = (hits.triangle.to_array(), hits.u.to_array(), hits.v.to_array());
    let mut lit = Lit { whole: true, ..Lit::default() };
    for lane in 0..8 {
        let triangle = triangles[lane] as usize;
        if triangles[lane] == MISS {
            lit.whole = false;
            continue;
        }
        let material = &scene.materials[scene.surfaces[triangle].material as usize];
        let front = faces(scene, triangle, direction.map(|axis| axis[lane]));
        lit.whole &= front && material.scattering == Scattering::Rough && material.specular == [0.0; 3];
        if let (Some(flat), true) = (atlas.corners[triangle], front) {
            let weights = [1.0 - u[lane] - v[lane], u[lane], v[lane]];
            let at = [0, 1].map(|k| (0..3).map(|i| weights[i] * flat[i][k]).sum());
            let value = lightmap.at(at);
            lit.irradiance = [0, 1, 2].map(|c| lit.irradiance[c] + value[c] / 8.0);
            lit.emission = [0, 1, 2].map(|c| lit.emission[c] + material.emission[c] / 8.0);
        }
    }
    lit
}

/// Whether a ray of this direction meets the front of a triangle.
fn faces(scene: &LoadedScene, triangle: usize, direction: [f32; 3]) -> bool {
    let [a, b, c] = scene.triangles[triangle].corners.map(glam::Vec3::from);
    (b - a).cross(c - a).dot(direction.into()) < 0.0
}

/// Two pictures of the same size as one.
fn beside(left: &[[f32; 3]], right: &[[f32; 3]], width: u32) -> Picture {
    let rows = left.chunks(width as usize).zip(right.chunks(width as usize));
    let gap = vec![[0.0; 3]; GAP as usize];
    let rgb: Vec<[f32; 3]> = rows.flat_map(|(left, right)| [left, &gap, right].concat()).collect();
    let width = 2 * width + GAP;
    Picture { width, height: rgb.len() as u32 / width, rgb, ..Picture::default() }
}
