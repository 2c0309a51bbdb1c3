//! Points on lights, and how dense they are.
//!
//! Few lights are picked with probability proportional to area times luminance of the radiance. The density of a point
//! per area is then luminance over total power, the same formula for every light, so that a path that hits an
//! emitter by chance knows it without looking the light up. Many lights are picked by the
//! [light tree](tree), if the scene has one. A point on a light is picked uniformly.

mod tree;

pub(super) use tree::Receiver;

use super::{fetch, hit};
use crate::maths::colour::luminance8;
use crate::maths::vec3::Vec3x8;
use crate::tracer::scene::light::area;
use crate::tracer::scene::{Light, Scene, SceneData};
use tree::{Picked, Root};
use wide::{f32x8, u32x8};

/// Eight points on emitters.
pub(super) struct LightPoints {
    /// Positions.
    pub position: Vec3x8,
    /// Unit normals on the emitting side.
    pub normal: Vec3x8,
    /// Emitted radiance.
    pub radiance: Vec3x8,
    /// Density per unit area; where lights are picked by power, what it would be if the table were not rounded.
    pub density: f32x8,
    /// Density per unit area, exactly that with which lights are picked.
    pub exact_density: f32x8,
    /// Distance from the light at which rays that leave it start.
    pub clearance: f32x8,
}

/// The lights as they are picked for eight receivers.
pub(super) struct Lights<'a> {
    scene: &'a Scene<'a>,
    tree: Option<Root<'a>>,
    /// When they are looked at.
    time: f32x8,
}

impl<'a> Lights<'a> {
    /// Weighs the lights, of which the scene must have one.
    #[inline(always)]
    pub fn new(scene: &'a Scene<'_>, time: f32x8, receiver: impl FnOnce() -> Receiver) -> Self {
        let data = scene.data();
        let tree = (!data.light_nodes.is_empty()).then(|| Root::new(data.light_nodes, receiver()));
        Lights { scene, tree, time }
    }

    /// The lights by power alone, without a receiver. The scene must have one.
    pub fn by_power(scene: &'a Scene<'_>, time: f32x8) -> Self {
        Lights { scene, tree: None, time }
    }

    /// Picks points on the lights from uniform numbers `u`, `v` in `[0, 1)`.
    #[inline(always)]
    pub fn sample(&self, u: f32x8, v: f32x8) -> LightPoints {
        let data = self.scene.data();
        let picked = self.tree.as_ref().map_or_else(|| by_power(data, u), |tree| tree.pick(u));
        let lamp = fetch::lamps(data, picked.light, self.time);
        let root = picked.again.sqrt();
        let weights = [f32x8::ONE - root, root * (f32x8::ONE - v), root * v];
        let position = lamp.corner + lamp.edges[0] * weights[1] + lamp.edges[1] * weights[2];
        let mut radiance = lamp.emission;
        if self.scene.has_textured_light() || self.scene.is_cut_out() {
            let triangle = picked.light.map(|i| data.lights[i as usize].triangle);
            radiance = hit::visible_emission(self.scene, triangle, weights);
        }
        let exact_density = picked.probability * lamp.inverse_area;
        let density = match self.tree {
            Some(_) => exact_density,
            None => luminance8(lamp.emission.into()) * f32x8::splat(self.scene.inverse_power()),
        };
        let clearance = hit::largest(lamp.corners()) * f32x8::splat(hit::CLEARANCE);
        LightPoints { position, normal: lamp.normal, radiance, density, exact_density, clearance }
    }
}

/// Eight triangles that emit.
pub(super) struct Emitting {
    /// Their indices.
    pub triangle: u32x8,
    /// When they are looked at.
    pub time: f32x8,
    /// Their typical radiances.
    pub radiance: Vec3x8,
}

/// The density per unit area that [`Lights::sample`] has for `receiver` on triangles that emit, in the lanes whose bit is set
/// in `lanes`.
#[inline(always)]
pub(super) fn density(
    scene: &Scene<'_>,
    receiver: impl FnOnce() -> Receiver,
    emitting: &Emitting,
    lanes: u32,
) -> f32x8 {
    match scene.data().light_nodes {
        [] => luminance8(emitting.radiance.into()) * f32x8::splat(scene.inverse_power()),
        _ => tree_density(scene.data(), &receiver(), emitting, lanes),
    }
}

fn tree_density(data: &SceneData<'_>, receiver: &Receiver, emitting: &Emitting, lanes: u32) -> f32x8 {
    let (triangle, time) = (emitting.triangle.to_array(), emitting.time.to_array());
    let mut density = [0.0; 8];
    for lane in (0..8).filter(|lane| lanes >> lane & 1 == 1) {
        if let Ok(found) = data.lights.binary_search_by_key(&triangle[lane], |light| light.triangle) {
            let light = &data.lights[found];
            let probability = tree::probability(data.light_nodes, light.path, receiver, lane);
            density[lane] = probability / area(&data.triangle_at(triangle[lane], time[lane]));
        }
    }
    density.into()
}

/// Picks lights by the table.
#[inline(always)]
fn by_power(data: &SceneData<'_>, u: f32x8) -> Picked {
    let Share { light, below, above } =
        if data.lights.len() <= SHORT { share_of_few(data.lights, u) } else { share_of_many(data.lights, u) };
    // The number that picked the triangle is stretched over its share and serves again.
    let again = ((u - below) / (above - below)).fast_max(f32x8::ZERO).fast_min(f32x8::ONE);
    // Random numbers go by steps: what counts is how many of them fall on the share.
    let steps = (above * f32x8::splat(STEPS)).ceil() - (below * f32x8::splat(STEPS)).ceil();
    Picked { light, probability: steps * f32x8::splat(1.0 / STEPS), again }
}

/// How many values a coordinate of [`sobol`](crate::maths::sobol) has.
const STEPS: f32 = (1 << 24) as f32;

/// Whether to look for the lights that a ray meets one by one, before what may be in between.
#[inline(always)]
pub(super) fn are_few(scene: &Scene<'_>) -> bool {
    // Through a cut-out lamp another one may be seen.
    let data = scene.data();
    data.lights.len() <= SHORT && !scene.is_cut_out() && data.sky.is_none()
}

/// Tables up to this length are searched from the front.
const SHORT: usize = 8;

/// Lights, and where their shares of the table begin and end.
struct Share {
    light: [u32; 8],
    below: f32x8,
    above: f32x8,
}

/// The lights whose shares `u` falls on, by a look at each entry of the table.
#[inline(always)]
fn share_of_few(lights: &[Light], u: f32x8) -> Share {
    let (mut light, mut below) = (u32x8::ZERO, f32x8::ZERO);
    let mut above = f32x8::splat(lights[0].cumulative);
    for (next, pair) in (1..).zip(lights.windows(2)) {
        let [end, next_end] = [pair[0].cumulative, pair[1].cumulative].map(f32x8::splat);
        let beyond = u.simd_ge(end);
        light = bytemuck::cast::<_, u32x8>(beyond).select(u32x8::splat(next), light);
        below = beyond.select(end, below);
        above = beyond.select(next_end, above);
    }
    Share { light: light.to_array(), below, above }
}

/// The same by bisection.
fn share_of_many(lights: &[Light], u: f32x8) -> Share {
    let last = lights.len() - 1;
    let picked = u.to_array().map(|u| lights.partition_point(|l| l.cumulative <= u).min(last));
    Share {
        light: picked.map(|i| i as u32),
        below: f32x8::from(picked.map(|i| if i == 0 { 0.0 } else { lights[i - 1].cumulative })),
        above: f32x8::from(picked.map(|i| lights[i].cumulative)),
    }
}
