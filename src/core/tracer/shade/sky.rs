//! Directions to the sky: what shines from there, how dense they are drawn, and drawing them.

use crate::maths::functions::{sin_cos_turn, turn};
use crate::maths::vec3::Vec3x8;
use crate::tracer::scene::sky::STEPS;
use crate::tracer::scene::{Sky, Sun};
use crate::tracer::trace::perpendicular;
use core::f32::consts::PI;
use wide::f32x8;

/// Directions drawn to the sky.
pub(super) struct SkyPoints {
    /// Unit vectors, away from the scene.
    pub direction: Vec3x8,
    /// Radiance that comes from there.
    pub radiance: Vec3x8,
    /// Density per solid angle with which they were drawn.
    pub density: f32x8,
}

/// Eight cells of the picture.
struct Cells {
    row: [u32; 8],
    column: [u32; 8],
}

/// Where a random number falls in a table.
#[derive(Clone, Copy, Default)]
struct Place {
    index: u32,
    /// Steps of the share it falls on.
    steps: u32,
    /// How far it is through the share, 0 to 1.
    within: f32,
}

/// Draws directions by uniform numbers in `[0, 1)`.
pub(super) fn sample(sky: &Sky<'_>, u: f32x8, v: f32x8) -> SkyPoints {
    let (u, v) = (u.to_array(), v.to_array());
    let mut rows = u.map(|u| find(sky.rows, u));
    let in_sun = f32x8::from(rows.map(|row| if row.index == 0 && sky.sun.is_some() { 1.0 } else { 0.0 }));
    let in_sun = in_sun.simd_gt(f32x8::ZERO);
    // The first entry is the sun's.
    rows.iter_mut().for_each(|row| row.index = row.index.saturating_sub(1));
    let columns: [Place; 8] = core::array::from_fn(|lane| find(cells_of(sky, rows[lane].index), v[lane]));
    let cells = Cells { row: rows.map(|p| p.index), column: columns.map(|p| p.index) };
    let within = |places: [Place; 8]| f32x8::from(places.map(|place| place.within));
    let shares = f32x8::from(core::array::from_fn(|lane| share(rows[lane].steps, columns[lane].steps)));
    let to_sky = cells.direction(sky, within(columns), within(rows));
    let (direction, density) = match &sky.sun {
        None => (to_sky, shares / cells.solid_angle(sky)),
        Some(sun) => {
            let to_sun = towards(sun, within(rows), f32x8::from(v));
            let direction = Vec3x8::select(in_sun, to_sun, to_sky);
            let behind = || density_of_picture(sky, direction);
            let of_cell = shares / cells.solid_angle(sky);
            let of_picture = if in_sun.any() { in_sun.select(behind(), of_cell) } else { of_cell };
            (direction, of_picture + density_of_sun(sky, sun, in_sun | is_in(sun, direction)))
        }
    };
    SkyPoints { direction, radiance: radiance(sky, direction), density }
}

/// Radiance that comes from `direction`.
pub(super) fn radiance(sky: &Sky<'_>, direction: Vec3x8) -> Vec3x8 {
    let (x, y) = position(sky, direction);
    let (x, y) = ((x - f32x8::HALF).to_array(), (y - f32x8::HALF).to_array());
    let mut rows = [[0.0; 8]; 3];
    for lane in 0..8 {
        let texel = interpolated(sky, x[lane], y[lane]);
        rows.iter_mut().zip(texel).for_each(|(row, value)| row[lane] = value);
    }
    let picture = Vec3x8::new(rows[0].into(), rows[1].into(), rows[2].into());
    match &sky.sun {
        None => picture,
        Some(sun) => {
            let shine = Vec3x8::splat(sun.radiance);
            picture + Vec3x8::select(is_in(sun, direction), shine, Vec3x8::default())
        }
    }
}

/// Density per solid angle with which [`sample`] draws `direction`.
pub(super) fn density(sky: &Sky<'_>, direction: Vec3x8) -> f32x8 {
    let picture = density_of_picture(sky, direction);
    match &sky.sun {
        None => picture,
        Some(sun) => picture + density_of_sun(sky, sun, is_in(sun, direction)),
    }
}

fn density_of_picture(sky: &Sky<'_>, direction: Vec3x8) -> f32x8 {
    let (x, y) = position(sky, direction);
    // A coordinate that rounding has made as large as the picture belongs to the last cell.
    let cell = |v: f32x8, size: u32| v.to_array().map(|v| (v as u32).min(size - 1));
    let cells = Cells { row: cell(y, sky.height), column: cell(x, sky.width) };
    let share = core::array::from_fn(|lane| {
        let (row, column) = (cells.row[lane] as usize, cells.column[lane] as usize);
        let columns = cells_of(sky, row as u32);
        share(sky.rows[row + 1] - sky.rows[row], columns[column] - start(columns, column))
    });
    f32x8::from(share) / cells.solid_angle(sky)
}

/// Of the lanes in `inside`; 0 in others.
fn density_of_sun(sky: &Sky<'_>, sun: &Sun, inside: f32x8) -> f32x8 {
    f32x8::splat(share(sky.rows[0], STEPS) / sun.solid_angle()) & inside
}

/// The lanes whose direction leads into the sun.
fn is_in(sun: &Sun, direction: Vec3x8) -> f32x8 {
    let away = direction - Vec3x8::splat(sun.direction);
    away.dot(away).simd_le(f32x8::splat(sun.chord2()))
}

/// Directions evenly distributed over the sun.
fn towards(sun: &Sun, u: f32x8, v: f32x8) -> Vec3x8 {
    // 1 − cos, evenly distributed: half the squared chord.
    let height = u * f32x8::splat(0.5 * sun.chord2());
    let sine = (height * (f32x8::splat(2.0) - height)).sqrt();
    let (sin, cos) = sin_cos_turn(v);
    let middle = Vec3x8::splat(sun.direction);
    let (a, b) = perpendicular(middle);
    (middle * (f32x8::ONE - height) + a * (sine * cos) + b * (sine * sin)).normalized()
}

/// Probability of a row's and a cell's shares.
fn share(row: u32, cell: u32) -> f32 {
    const STEP: f32 = 1.0 / STEPS as f32;
    (row as f32 * STEP) * (cell as f32 * STEP)
}

/// The cells of a row.
fn cells_of<'a>(sky: &Sky<'a>, row: u32) -> &'a [u32] {
    let width = sky.width as usize;
    &sky.cells[row as usize * width..][..width]
}

/// Where the share of an entry starts.
fn start(ends: &[u32], index: usize) -> u32 {
    if index == 0 { 0 } else { ends[index - 1] }
}

/// The share that `u` falls on.
fn find(ends: &[u32], u: f32) -> Place {
    let target = u * STEPS as f32;
    let index = ends.partition_point(|end| *end <= target as u32).min(ends.len() - 1);
    let (from, to) = (start(ends, index), ends[index]);
    // Numbers go by steps: in the middle of theirs they are even on average.
    let within = ((target - from as f32 + 0.5) / (to - from).max(1) as f32).min(1.0);
    Place { index: index as u32, steps: to - from, within }
}

impl Cells {
    /// The directions so far through the cells, eastwards and downwards, evenly by solid angle.
    fn direction(&self, sky: &Sky<'_>, right: f32x8, down: f32x8) -> Vec3x8 {
        let number = |values: [u32; 8]| f32x8::from(values.map(|value| value as f32));
        let half_turn = f32x8::splat(0.5 / sky.height as f32);
        let top = number(self.row) * half_turn;
        let ((_, above), (_, below)) = (sin_cos_turn(top), sin_cos_turn(top + half_turn));
        let y = above + (below - above) * down;
        let sine = ((f32x8::ONE - y) * (f32x8::ONE + y)).fast_max(f32x8::ZERO).sqrt();
        // The left edge is at −z, a quarter of the way at +x.
        let (sin, cos) = sin_cos_turn((number(self.column) + right) / f32x8::splat(sky.width as f32));
        let [x, z] = [sine * sin, -(sine * cos)];
        let [a, b, c] = sky.axes.map(Vec3x8::splat);
        a * x + b * y + c * z
    }

    fn solid_angle(&self, sky: &Sky<'_>) -> f32x8 {
        let middle = f32x8::from(self.row.map(|row| (2 * row + 1) as f32));
        let (sine, _) = sin_cos_turn(middle * f32x8::splat(0.25 / sky.height as f32));
        let (half, _) = sin_cos_turn(f32x8::splat(0.25 / sky.height as f32));
        sine * half * f32x8::splat(4.0 * PI / sky.width as f32)
    }
}

/// Where `direction` is in the picture, in texels from the upper left corner.
fn position(sky: &Sky<'_>, direction: Vec3x8) -> (f32x8, f32x8) {
    let [x, y, z] = sky.axes.map(|axis| direction.dot(Vec3x8::splat(axis)));
    let around = turn(-z, x);
    let around = around.simd_lt(f32x8::ZERO).select(around + f32x8::ONE, around);
    let below = turn(y, (x * x + z * z).sqrt());
    (around * f32x8::splat(sky.width as f32), below * f32x8::splat(2.0 * sky.height as f32))
}

/// The picture between its texels' centres, `x` and `y` texels from the first.
fn interpolated(sky: &Sky<'_>, x: f32, y: f32) -> [f32; 3] {
    let (left, top) = (libm::floorf(x), libm::floorf(y));
    let column = |x: f32| (x as i32).rem_euclid(sky.width as i32) as usize;
    let row = |y: f32| (y as i32).clamp(0, sky.height as i32 - 1) as usize * sky.width as usize;
    let texel = |x: f32, y: f32| sky.texels[row(y) + column(x)];
    let mix = |a: [f32; 3], b: [f32; 3], f: f32| [0, 1, 2].map(|c| a[c] + (b[c] - a[c]) * f);
    let across = |y: f32| mix(texel(left, y), texel(left + 1.0, y), x - left);
    mix(across(top), across(top + 1.0), y - top)
}

#[cfg(test)]
mod tests;
