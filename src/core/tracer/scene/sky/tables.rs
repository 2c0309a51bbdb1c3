//! The tables by which directions to the sky are drawn.

use super::data::{STEPS, Sun, required};
use crate::maths::colour::luminance;
use core::f32::consts::PI;

/// Fills the tables of a picture of `width`×`height` texels and a sun; returns the luminance integrated over all
/// directions.
///
/// A picture without any light is sampled as if it were white. Where the slices are not as long as
/// [`required`] says, or `texels` are not as many, nothing is written and the result is 0.
pub fn build(
    (width, height): (u32, u32),
    texels: &[[f32; 3]],
    sun: Option<&Sun>,
    rows: &mut [u32],
    cells: &mut [u32],
) -> f32 {
    let sizes = (rows.len(), cells.len()) == required(width, height) && texels.len() == cells.len();
    if !sizes || cells.is_empty() {
        return 0.0;
    }
    let (columns, picture) = (width as usize, Picture { width, height, texels });
    for (y, row) in cells.chunks_mut(columns).enumerate() {
        let (y, angle) = (y as u32, solid_angle(width, height, y as u32));
        (0..).zip(row.iter_mut()).for_each(|(x, cell)| *cell = (picture.mean(x, y) * angle).to_bits());
    }
    let light = |cells: &[u32]| cells.iter().map(|bits| f64::from(f32::from_bits(*bits))).sum::<f64>();
    let of_picture = light(cells);
    if of_picture == 0.0 {
        for (y, row) in cells.chunks_mut(columns).enumerate() {
            row.fill(solid_angle(width, height, y as u32).to_bits());
        }
    }
    for (row, cells) in rows[1..].iter_mut().zip(cells.chunks_mut(columns)) {
        *row = (light(cells) as f32).to_bits();
        accumulate(cells, 0);
    }
    let of_sun = sun.map_or(0.0, |sun| f64::from(luminance(sun.radiance) * sun.solid_angle()));
    let first = share_of_sun(of_sun, of_picture);
    rows[0] = first;
    accumulate(&mut rows[1..], first);
    (of_picture + of_sun) as f32
}

/// Steps of the sun beside the picture: by their light, but neither less than an eighth.
fn share_of_sun(sun: f64, picture: f64) -> u32 {
    if sun == 0.0 {
        return 0;
    }
    ((sun / (sun + picture)).clamp(0.125, 0.875) * f64::from(STEPS)) as u32
}

/// Solid angle of each cell of row `y`: 2π/w times cos − cos of the row's edges, without cancellation.
pub(crate) fn solid_angle(width: u32, height: u32, y: u32) -> f32 {
    let half = 0.5 * PI / height as f32;
    4.0 * PI / width as f32 * libm::sinf(half * (2 * y + 1) as f32) * libm::sinf(half)
}

/// A picture of the sky.
struct Picture<'a> {
    width: u32,
    height: u32,
    texels: &'a [[f32; 3]],
}

impl Picture<'_> {
    fn luminance(&self, x: u32, y: u32) -> f32 {
        luminance(self.texels[y as usize * self.width as usize + x as usize])
    }

    /// Mean luminance of the interpolated picture over the cell of a texel: six eighths of its own and one eighth of
    /// either neighbour, along both axes.
    fn mean(&self, x: u32, y: u32) -> f32 {
        let (west, east) = ((x + self.width - 1) % self.width, (x + 1) % self.width);
        let along = |y: u32| {
            0.75 * self.luminance(x, y) + 0.125 * (self.luminance(west, y) + self.luminance(east, y))
        };
        let (north, south) = (y.saturating_sub(1), (y + 1).min(self.height - 1));
        0.75 * along(y) + 0.125 * (along(north) + along(south))
    }
}

/// Turns shares, as bits of floats, into where they end, from `first` to [`STEPS`]. Shares above 0 get a step at least;
/// if there are none, all get the same.
fn accumulate(shares: &mut [u32], first: u32) {
    let value = |bits: u32| f64::from(f32::from_bits(bits));
    let total: f64 = shares.iter().map(|bits| value(*bits)).sum();
    if total == 0.0 {
        shares.fill(1.0f32.to_bits());
        return accumulate(shares, first);
    }
    let used = shares.iter().filter(|bits| value(**bits) > 0.0).count() as u32;
    let scale = f64::from(STEPS - first - used) / total;
    let (mut sum, mut steps) = (0.0, first);
    for share in shares.iter_mut() {
        let own = value(*share);
        sum += own;
        steps += u32::from(own > 0.0);
        *share = steps + (sum * scale) as u32;
    }
    // Behind the last share above 0 there is nothing, whatever rounding has made of the sum.
    let end = shares.last().copied().unwrap_or(STEPS);
    shares.iter_mut().rev().take_while(|share| **share == end).for_each(|share| *share = STEPS);
}
