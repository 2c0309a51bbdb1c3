//! What rays hit and what it looks like.

use bytemuck::{NoUninit, Pod, Zeroable};

/// The value of [`Material::texture`] and its other maps that means "none".
pub const NO_TEXTURE: u32 = u32::MAX;

/// A triangle's three corners. Its front is the side from which they run counter-clockwise.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Triangle {
    /// Corner positions.
    pub corners: [[f32; 3]; 3],
}

/// What a triangle looks like; `surfaces[i]` belongs to `triangles[i]`.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Surface {
    /// Unit shading normals at the corners, on the front side. All zero: the triangle is flat.
    pub normals: [[f32; 3]; 3],
    /// Texture coordinates at the corners, `v` growing upwards as in OBJ.
    pub uv: [[f32; 2]; 3],
    /// Index into [`SceneData::materials`](crate::tracer::scene::SceneData::materials).
    pub material: u32,
}

/// How a material scatters light.
#[repr(u32)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, NoUninit)]
pub enum Scattering {
    /// Lambertian `diffuse` plus, where `specular` is not black, a GGX lobe of width `roughness` with Schlick
    /// Fresnel. Both sides of the surface.
    #[default]
    Rough,
    /// Perfect mirror tinted by `specular`. Both sides.
    Mirror,
    /// Smooth dielectric: the front faces air, the back a medium of index `ior`.
    Dielectric,
}

/// The narrowest GGX lobe: single precision cannot tell half vectors apart that are much closer to the normal. What is
/// meant to be smoother is a [`Mirror`](Scattering::Mirror).
pub const MIN_ROUGHNESS: f32 = 1e-6;

/// A surface material.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, NoUninit)]
pub struct Material {
    /// Diffuse reflectance, 0 to 1 a channel; multiplied by the texture.
    pub diffuse: [f32; 3],
    /// How it scatters.
    pub scattering: Scattering,
    /// Index into [`SceneData::textures`](crate::tracer::scene::SceneData::textures) or [`NO_TEXTURE`].
    pub texture: u32,
    /// Specular reflectance at normal incidence (rough), tint (mirror, dielectric), 0 to 1 a channel.
    pub specular: [f32; 3],
    /// Width α of the GGX distribution, [`MIN_ROUGHNESS`] to 1.
    pub roughness: f32,
    /// Index of refraction of the inside over that of the outside.
    pub ior: f32,
    /// Emitted radiance, on the front side only. Where there is an `emission_texture` the texture's value is emitted instead,
    /// and lamps are chosen by this: it should be near the mean over each triangle, and must not be 0 where the texture
    /// is not.
    pub emission: [f32; 3],
    /// Part of the surface that is there, 0 to 1: the rest lets light and sight straight through.
    pub opacity: f32,
    /// Index of the texture whose red multiplies `opacity`, or [`NO_TEXTURE`].
    pub opacity_texture: u32,
    /// Index of the texture of emitted radiance, or [`NO_TEXTURE`].
    pub emission_texture: u32,
}

impl Default for Material {
    /// Grey diffuse.
    fn default() -> Self {
        Material {
            diffuse: [0.5; 3],
            scattering: Scattering::Rough,
            texture: NO_TEXTURE,
            specular: [0.0; 3],
            roughness: 1.0,
            ior: 1.5,
            emission: [0.0; 3],
            opacity: 1.0,
            opacity_texture: NO_TEXTURE,
            emission_texture: NO_TEXTURE,
        }
    }
}

/// A rectangle of texels in [`SceneData::texels`](crate::tracer::scene::SceneData::texels), row by row from the top, repeated over the plane.
///
/// It is looked up at coordinates times `scale` plus `offset`. Several textures may share texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texture {
    /// Texels in a row, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// Index of the first texel.
    pub first: u32,
    /// Factors of the coordinates.
    pub scale: [f32; 2],
    /// Added to the scaled coordinates.
    pub offset: [f32; 2],
    /// Whether coordinates outside of 0 to 1 get the texels of the edge, instead of the repeated texture.
    pub clamp: bool,
}

impl Texture {
    /// No texels, coordinates as they are.
    pub const EMPTY: Texture =
        Texture { width: 0, height: 0, first: 0, scale: [1.0; 2], offset: [0.0; 2], clamp: false };
}

impl Material {
    /// Whether light can pass through it without being scattered.
    pub(super) fn is_cut_out(&self) -> bool {
        self.opacity < 1.0 || self.opacity_texture != NO_TEXTURE
    }

    /// Whether its numbers are in range and its textures are among `textures`.
    pub(super) fn is_valid(&self, textures: usize) -> bool {
        let unit = |c: &[f32; 3]| c.iter().all(|v| (0.0..=1.0).contains(v));
        let emits = self.emission.iter().all(|v| v.is_finite() && *v >= 0.0);
        let known = |texture: u32| texture == NO_TEXTURE || (texture as usize) < textures;
        let maps = [self.texture, self.opacity_texture, self.emission_texture].into_iter().all(known);
        let opacity = (0.0..=1.0).contains(&self.opacity);
        let rough = (MIN_ROUGHNESS..=1.0).contains(&self.roughness);
        let ior = self.ior.is_finite() && self.ior > 0.0;
        unit(&self.diffuse) && unit(&self.specular) && emits && maps && opacity && rough && ior
    }
}

impl Texture {
    /// Whether it has texels, all of them among `texels`.
    pub(super) fn is_valid(&self, texels: usize) -> bool {
        let size = (self.width as usize).checked_mul(self.height as usize);
        let end = size.and_then(|n| n.checked_add(self.first as usize));
        self.width > 0 && self.height > 0 && end.is_some_and(|end| end <= texels)
    }
}
