//! Light from infinitely far away: a picture of the whole sphere, and a sun.
//!
//! The picture is equirectangular, as OpenEXR's *latitude-longitude map* is laid out: rows from the top, +y up, +z in the
//! middle and +x in the middle of the left half. Its texels lie at the centres of equal steps in both angles, and
//! radiance is interpolated between them (around the seam, not over the poles).
//!
//! To be sampled by what it shines with, it is divided into *cells*, one around each texel. A direction is drawn by
//! inversion (Pharr, Jakob and Humphreys, *Physically Based Rendering*, 4th ed., section 12.5), which keeps well-spread
//! numbers well spread: a row by the light of its cells, a cell of it likewise, and a direction evenly in the cell's
//! solid angle. The light of a cell is the mean luminance of the interpolated picture over it times that angle, so that
//! no direction that shines has density zero. Shares are whole numbers of [`STEPS`], as many as random numbers can hit:
//! the density with which a direction is drawn is known exactly.

mod data;
mod tables;

pub use data::{MAX_SKY_SIDE, STEPS, Sky, Sun, required};
pub use tables::build;

#[cfg(test)]
mod tests;
