//! Points of surfaces that are not met by rays.

use crate::maths::vec3::Vec3x8;
use wide::f32x8;

/// Eight points of surfaces, structure of arrays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sites {
    /// Positions, in scene units.
    pub position: Vec3x8,
    /// Unit shading normals: light counts by the cosine to these.
    pub normal: Vec3x8,
    /// Unit geometric normals, on the same side.
    pub facing: Vec3x8,
    /// The largest coordinate of the surface nearby, in absolute value: rays start off the surface by more than its rounding.
    pub reach: f32x8,
}
