//! A scene as borrowed slices: what rays hit, what it looks like, what emits.
//!
//! The owner of a scene (the shell, an engine) keeps its arrays in whatever memory it likes and lends them as
//! [`SceneData`]. [`Scene::new`] checks every index and the depth of the tree once; after that the hot path
//! needs no error handling and a fixed stack suffices. Lengths are in scene units, colours linear Rec. 709.

pub(crate) mod check;
mod data;
mod hierarchy;
pub mod light;
pub mod light_tree;
mod motion;
pub mod sky;
mod surface;

pub use data::{Error, SceneData};
pub(crate) use hierarchy::{LEAF, STACK};
pub use hierarchy::{MAX_DEPTH, Node8, fill_leaves, leaves_len};
pub use light::{Lamp, Light};
pub use light_tree::{LIGHT_LEAF, LightNode8, MAX_LIGHT_DEPTH};
pub use motion::Motion;
pub(crate) use motion::between;
pub use sky::{Sky, Sun};
pub use surface::{MIN_ROUGHNESS, Material, NO_TEXTURE, Scattering, Surface, Texture, Triangle};

use super::camera;
use wide::{f32x8, u32x8};

/// A scene that has been checked: every index leads somewhere, the tree is a tree of bounded depth.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    data: SceneData<'a>,
    inverse_power: f32,
    cut_out: bool,
    textured_light: bool,
    lamp_share: f32,
}

impl<'a> Scene<'a> {
    /// Checks `data` and borrows it.
    ///
    /// # Errors
    /// The first thing found wrong: see [`Error`].
    pub fn new(data: SceneData<'a>) -> Result<Self, Error> {
        check::check(&data)?;
        let power = total_power(&data);
        Ok(Scene {
            data,
            inverse_power: if power > 0.0 { (1.0 / power) as f32 } else { 0.0 },
            cut_out: data.materials.iter().any(Material::is_cut_out),
            textured_light: data.materials.iter().any(|m| m.emission_texture != NO_TEXTURE),
            lamp_share: match (&data.sky, data.lights) {
                (None, _) => 1.0,
                (Some(_), []) => 0.0,
                (Some(_), _) => 0.5,
            },
        })
    }

    /// The slices behind the scene.
    #[inline(always)]
    pub fn data(&self) -> &SceneData<'a> {
        &self.data
    }

    /// Whether light can pass through a surface without being scattered. Scenes where it cannot pay nothing for it.
    #[inline(always)]
    pub(crate) fn is_cut_out(&self) -> bool {
        self.cut_out
    }

    /// Whether what a lamp emits differs from point to point.
    #[inline(always)]
    pub(crate) fn has_textured_light(&self) -> bool {
        self.textured_light
    }

    /// The scene as it is when the shutter opens, and stays.
    pub(crate) fn still(self) -> Self {
        Scene { data: SceneData { motion: None, ..self.data }, ..self }
    }

    /// When eight samples look at the scene, as parts of the time in which the shutter is open; 0 where nothing moves.
    #[inline(always)]
    pub(crate) fn time(&self, index: u32x8, key: u32x8) -> f32x8 {
        if self.data.motion.is_some() { camera::time(index, key) } else { f32x8::ZERO }
    }

    /// Whether anything shines: a triangle or the sky.
    #[inline(always)]
    pub(crate) fn is_lit(&self) -> bool {
        !self.data.lights.is_empty() || self.data.sky.is_some()
    }

    /// Probability that light is looked for at triangles, not at the sky: evenly divided where there are both, which is
    /// at most twice the variance of the best division, whatever the scene.
    #[inline(always)]
    pub(crate) fn lamp_share(&self) -> f32 {
        self.lamp_share
    }

    /// One over the lights' total power (luminance times area, up to π).
    #[inline(always)]
    pub(crate) fn inverse_power(&self) -> f32 {
        self.inverse_power
    }
}

/// Luminance times area, summed over the lights.
fn total_power(data: &SceneData<'_>) -> f64 {
    let of = |light: &Light| {
        let i = light.triangle as usize;
        light::power(&data.triangles[i], &data.materials[data.surfaces[i].material as usize])
    };
    data.lights.iter().map(of).sum()
}
