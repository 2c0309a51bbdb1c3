//! What a light tree is made of.

use bytemuck::{Pod, Zeroable};

/// Eight groups of lights: a node of the light tree.
///
/// A group is bounded by a sphere around its triangles and by a cone around their normals. Children that are there
/// come first.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LightNode8 {
    /// Centres of the spheres, by axis and child.
    pub centre: [[f32; 8]; 3],
    /// Radii of the spheres.
    pub radius: [f32; 8],
    /// Unit axes of the cones, by axis and child.
    pub axis: [[f32; 8]; 3],
    /// Cosines of the cones' half angles.
    pub cosine: [f32; 8],
    /// Shares of the power (luminance times area) of all lights, above 0. 0: the child is not there.
    pub power: [f32; 8],
    /// For a group of one light [`LIGHT_LEAF`] plus its index in [`SceneData::lights`](crate::tracer::scene::SceneData::lights); else the index of the
    /// group's node, which is above this node's own.
    pub child: [u32; 8],
}

/// What tells a single light from a group in [`LightNode8::child`].
pub const LIGHT_LEAF: u32 = 1 << 31;

/// Levels of nodes a light tree may have: [`Light::path`](crate::tracer::scene::Light::path) has room for no more.
pub const MAX_LIGHT_DEPTH: u32 = 10;

/// Which child a path takes at a level.
#[inline(always)]
pub(crate) fn slot(path: u32, level: u32) -> usize {
    (path >> (3 * level)) as usize & 7
}
