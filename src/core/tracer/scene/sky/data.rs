//! What a sky is, and what can be wrong with it.

use crate::maths::vec3;

/// What the shares of rows, and of a row's cells, add up to.
pub const STEPS: u32 = 1 << 23;

/// Longest side of a picture of the sky: every cell must get a step.
pub const MAX_SKY_SIDE: u32 = 1 << 16;

/// A disc that shines from infinitely far away with the same radiance all over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Unit vector to its middle, in the scene's axes.
    pub direction: [f32; 3],
    /// Half the angle under which it is seen, in radians, above 0 and up to ½π. The sun's is 0.00465.
    pub radius: f32,
    /// Its radiance, which is added to that of the picture behind it.
    pub radiance: [f32; 3],
}

impl Sun {
    /// The solid angle under which it is seen.
    pub fn solid_angle(&self) -> f32 {
        core::f32::consts::PI * self.chord2()
    }

    /// Squared distance of its edge from its middle on the unit sphere: 2 − 2 cos, without cancellation.
    pub(crate) fn chord2(&self) -> f32 {
        let half = libm::sinf(0.5 * self.radius);
        4.0 * half * half
    }

    fn is_valid(&self) -> bool {
        let length2 = vec3::dot(self.direction, self.direction);
        let angle = self.radius > 0.0 && self.radius <= core::f32::consts::FRAC_PI_2;
        (length2 - 1.0).abs() < 1e-4 && angle && self.radiance.iter().all(|v| v.is_finite() && *v >= 0.0)
    }
}

/// The sky, as slices that the caller lends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky<'a> {
    /// Texels in a row of the picture, 1 to [`MAX_SKY_SIDE`]. 1×1 is a sky of one colour.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Linear radiance, rows from the top.
    pub texels: &'a [[f32; 3]],
    /// Where the shares of the rows end, in [`STEPS`]; the first number is the share of the sun. As [`build`](super::build) makes it.
    pub rows: &'a [u32],
    /// Where the shares of the cells of each row end. As [`build`](super::build) makes it.
    pub cells: &'a [u32],
    /// The picture's axes x, y and z in the scene's: rows of the rotation from scene to picture.
    pub axes: [[f32; 3]; 3],
    /// The sun, if there is one.
    pub sun: Option<Sun>,
    /// Luminance integrated over all directions, as [`build`](super::build) has found it. It decides only how many of the photons
    /// come from the sky.
    pub power: f32,
    /// Whether the eye sees it directly. In mirrors and through glass it is seen in any case.
    pub visible: bool,
}

impl Sky<'_> {
    /// Whether every number is one that the hot path can rely on.
    pub(crate) fn is_valid(&self) -> bool {
        let (width, height) = (self.width as usize, self.height as usize);
        let sides = 1..=MAX_SKY_SIDE;
        let sizes = sides.contains(&self.width)
            && sides.contains(&self.height)
            && self.texels.len() == width * height
            && (self.rows.len(), self.cells.len()) == required(self.width, self.height);
        let shines = |texel: &[f32; 3]| texel.iter().all(|v| v.is_finite() && *v >= 0.0);
        sizes
            && self.texels.iter().all(shines)
            && rises(self.rows)
            && self.cells.chunks(width).all(rises)
            && self.sun.is_none_or(|sun| sun.is_valid())
            && self.power.is_finite()
            && self.axes_are_valid()
    }

    /// Whether the axes are those of a rotation, or of one and a reflection.
    fn axes_are_valid(&self) -> bool {
        let unit = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
        let off = |i: usize, j: usize| (vec3::dot(self.axes[i], self.axes[j]) - unit(i, j)).abs();
        (0..3).all(|i| (0..3).all(|j| off(i, j) < 1e-4))
    }
}

/// Whether numbers never fall and end at [`STEPS`].
fn rises(ends: &[u32]) -> bool {
    ends.is_sorted() && ends.last() == Some(&STEPS)
}

/// Lengths of [`Sky::rows`] and [`Sky::cells`] of a picture of this size.
pub const fn required(width: u32, height: u32) -> (usize, usize) {
    (height as usize + 1, width as usize * height as usize)
}
