//! What a renderer knows of a pixel without noise, or with little.

/// What is seen through a pixel, averaged over it, and how well that is known.
///
/// A surface seen in a mirror or through smooth glass is meant, not the glass. Where nothing is seen all is 0. Any caller
/// may fill these from what he has; numbers need not be exact, and what is not finite counts as 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Feature {
    /// Part of the light that the surface reflects, 1 where it shines itself.
    pub albedo: [f32; 3],
    /// Shading normal, of length 1 where all of the pixel has the same.
    pub normal: [f32; 3],
    /// Length of the way from the eye, in any unit.
    pub depth: f32,
    /// Variance of the albedo's mean, the largest of a colour's.
    pub albedo_variance: f32,
    /// Variance of the normal's mean, of all three coordinates together.
    pub normal_variance: f32,
    /// Variance of the depth's mean.
    pub depth_variance: f32,
}
