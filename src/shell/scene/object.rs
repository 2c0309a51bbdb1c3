//! Triangles that move together, as readers find them.

use glam::{DVec3, Vec2, Vec3};
use std::path::PathBuf;

/// The second texture coordinates of a triangle that has none.
pub(super) const NO_UVS: [[f32; 2]; 3] = [[f32::NAN; 2]; 3];

/// A corner of a triangle; a zero normal means that the source has none.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Corner {
    pub position: Vec3,
    pub normal: Vec3,
    pub uv: Vec2,
}

/// Triangles that move together, in coordinates of their own.
#[derive(Clone, Debug)]
pub(super) struct Object {
    /// The file to name in warnings.
    pub source: PathBuf,
    /// Where its coordinates begin, in those of the file.
    pub home: DVec3,
    pub pieces: Vec<Piece>,
    /// Linear colours of the corners of each piece; empty if there are none.
    pub colours: Vec<[[f32; 3]; 3]>,
    /// Second texture coordinates of the corners of each piece, NaN where there are none; empty if there are none at all.
    pub second: Vec<[[f32; 2]; 3]>,
}

/// What a triangle's corners may have beside.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Extras {
    /// Linear colours.
    pub colours: Option<[[f32; 3]; 3]>,
    /// A second set of texture coordinates.
    pub second: Option<[[f32; 2]; 3]>,
}

/// A triangle of an object.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub corners: [Corner; 3],
    pub material: u32,
}
