//! A point of a picture with its surroundings.

/// Cells of a descriptor along a side.
pub(super) const CELLS: usize = 4;
/// Numbers of a descriptor.
pub const DESCRIPTOR: usize = CELLS * CELLS * 8;
/// Norm of a descriptor.
pub const UNIT: f32 = 8_192.0;

/// A point of a picture with its surroundings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feature {
    /// Position in pixels from the left edge; the first pixel's centre is 0.5.
    pub x: f32,
    /// Position in pixels from the upper edge.
    pub y: f32,
    /// Standard deviation in pixels of the Gaussian whose size the feature has.
    pub scale: f32,
    /// Dominant gradient direction in turns, 0 to 1, from the x axis towards the y axis.
    pub turn: f32,
    /// Difference of Gaussians: positive for a dark blob, negative for a bright one.
    pub response: f32,
    /// Square roots of a histogram of gradients: 4 × 4 cells of 8 directions; its norm is [`UNIT`] but for rounding.
    pub descriptor: [i16; DESCRIPTOR],
}

impl Default for Feature {
    fn default() -> Self {
        Feature { x: 0.0, y: 0.0, scale: 0.0, turn: 0.0, response: 0.0, descriptor: [0; DESCRIPTOR] }
    }
}
