//! The light of last resort: a soft sky, and a large lamp where a photographer would put it.

use super::map::SkyMap;
use crate::scene::view::View;
use glam::{Mat3, Vec3};
use pmcip_core::tracer::scene::Sun;

/// Half the angle under which the lamp is seen, in radians: 12°.
const RADIUS: f32 = 0.21;
/// Radiance that the lamp alone gives a white surface that faces it.
const KEY: f32 = 0.75;
/// Radiance of the sky below, and what it has more above.
const SKY: (f32, f32) = (0.12, 0.4);
/// Rows of its picture.
const ROWS: u32 = 32;

impl SkyMap {
    /// The light by which a photographer would show an object of which nothing is known, as seen by `view`: a soft sky and
    /// a large lamp behind the camera, above it and to its left, both infinitely far away and not seen themselves. A white
    /// surface that faces the lamp has about radiance 1.
    pub fn soft(view: &View) -> SkyMap {
        soft(view)
    }
}

fn soft(view: &View) -> SkyMap {
    let back = (Vec3::from(view.from) - Vec3::from(view.at)).normalize_or(Vec3::Z);
    let up = Vec3::from(view.up).normalize_or(Vec3::Y);
    let left = back.cross(up).normalize_or(Vec3::NEG_X);
    let direction = (back + 0.75 * up + 0.65 * left).normalize();
    // Irradiance of a disc that is faced: π sin² of its radius times its radiance. White reflects 1/π of it.
    let radiance = KEY / RADIUS.sin().powi(2);
    let sun = Sun { direction: direction.to_array(), radius: RADIUS, radiance: [radiance; 3] };
    let row =
        |y: u32| SKY.0 + SKY.1 * (0.5 + 0.5 * (std::f32::consts::PI * (y as f32 + 0.5) / ROWS as f32).cos());
    let texels = (0..ROWS).flat_map(|y| std::iter::repeat_n([row(y); 3], 2 * ROWS as usize)).collect();
    let mut sky = SkyMap::new((2 * ROWS, ROWS), texels, Some(sun), "soft sky and key light".into());
    // The picture's y axis is the camera's up.
    let across = up.any_orthonormal_vector();
    sky.axes = Mat3::from_cols(across, up, across.cross(up)).to_cols_array_2d();
    sky.visible = false;
    sky
}
