//! A scene as borrowed slices: what rays hit, what it looks like, what emits.
//!
//! The owner of a scene (the shell, an engine) keeps its arrays in whatever memory it likes and lends them as
//! [`SceneData`]. [`Scene::new`] checks every index and the depth of the tree once; after that the hot path
//! needs no error handling and a fixed stack suffices. Lengths are in scene units, colours linear Rec. 709.

use bytemuck::{Pod, Zeroable};

/// The value of [`Material::texture`] that means "none".
pub const NO_TEXTURE: u32 = u32::MAX;

/// A triangle's three corners. Its front is the side from which they run counter-clockwise.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Triangle {
    /// Corner positions.
    pub corners: [[f32; 3]; 3],
}

/// What a triangle looks like; `surfaces[i]` belongs to `triangles[i]`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Surface {
    /// Unit shading normals at the corners, on the front side. All zero: the triangle is flat.
    pub normals: [[f32; 3]; 3],
    /// Texture coordinates at the corners, `v` growing upwards as in OBJ.
    pub uv: [[f32; 2]; 3],
    /// Index into [`SceneData::materials`].
    pub material: u32,
}

/// How a material scatters light.
#[repr(u32)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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

/// A surface material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// How it scatters.
    pub scattering: Scattering,
    /// Diffuse reflectance, 0 to 1 a channel; multiplied by the texture.
    pub diffuse: [f32; 3],
    /// Index into [`SceneData::textures`] or [`NO_TEXTURE`].
    pub texture: u32,
    /// Specular reflectance at normal incidence (rough), tint (mirror, dielectric), 0 to 1 a channel.
    pub specular: [f32; 3],
    /// Width α of the GGX distribution, above 0, at most 1.
    pub roughness: f32,
    /// Index of refraction of the inside over that of the outside.
    pub ior: f32,
    /// Emitted radiance, on the front side only.
    pub emission: [f32; 3],
}

impl Default for Material {
    /// Grey diffuse.
    fn default() -> Self {
        Material {
            scattering: Scattering::Rough,
            diffuse: [0.5; 3],
            texture: NO_TEXTURE,
            specular: [0.0; 3],
            roughness: 1.0,
            ior: 1.5,
            emission: [0.0; 3],
        }
    }
}

/// A rectangle of texels in [`SceneData::texels`], row by row from the top, repeated over the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Texture {
    /// Texels in a row, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// Index of the first texel.
    pub first: u32,
}

/// An emitting triangle and its place in the table that picks one by power.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Light {
    /// Index into [`SceneData::triangles`].
    pub triangle: u32,
    /// Probability that a light before this one, or this one, is picked; 1 for the last.
    pub cumulative: f32,
}

/// Eight boxes and what is in them: a node of the bounding volume hierarchy, four cache lines.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Node8 {
    /// Lower corners of the children's boxes, by axis and child. An unused child has `+∞`.
    pub lower: [[f32; 8]; 3],
    /// Upper corners. An unused child has `−∞`.
    pub upper: [[f32; 8]; 3],
    /// For an inner child the index of its node, which is above this node's own; for a leaf its first triangle.
    pub child: [u32; 8],
    /// Number of triangles of a leaf; 0 for an inner or unused child.
    pub count: [u32; 8],
}

impl Node8 {
    /// A node without children.
    pub const EMPTY: Node8 = Node8 {
        lower: [[f32::INFINITY; 8]; 3],
        upper: [[f32::NEG_INFINITY; 8]; 3],
        child: [0; 8],
        count: [0; 8],
    };
}

/// The slices a scene is made of, unchecked.
#[derive(Clone, Copy, Debug, Default)]
pub struct SceneData<'a> {
    /// Hierarchy over `triangles`; node 0 is the root. Empty for an empty scene.
    pub nodes: &'a [Node8],
    /// Triangles, in the order of the hierarchy's leaves.
    pub triangles: &'a [Triangle],
    /// One for each triangle.
    pub surfaces: &'a [Surface],
    /// Materials.
    pub materials: &'a [Material],
    /// Textures.
    pub textures: &'a [Texture],
    /// Linear RGB texels of all textures.
    pub texels: &'a [[f32; 3]],
    /// Emitting triangles, as [`crate::shade::light::build`] makes them.
    pub lights: &'a [Light],
}
