//! The wide smooth window of the balanced estimator: three box passes in each direction, in place.
//!
//! Half-sample reflection at both ends makes every pass a symmetric matrix whose rows and columns sum to one,
//! at any radius and any size. Sums run in double precision: a firefly that enters and leaves a single
//! precision sum would leave a trace along the whole line.

/// A position of a line: five pixels of neighbouring rows, or sixteen neighbouring floats of a row.
pub type Lanes = [f32; LANES];

/// Floats at a position of a line.
const LANES: usize = 16;
/// Pixels at a position of a row.
const ROWS: usize = LANES / 3;
/// Largest radius of a box.
pub const MAX_RADIUS: u32 = 4_096;

/// Scratch [`smooth`] needs for a picture of this size.
pub(crate) fn scratch_len(width: u32, height: u32) -> usize {
    2 * width.max(height) as usize
}

/// Smooths interleaved RGB in place. `scratch` is [`scratch_len`] long.
pub(crate) fn smooth(rgb: &mut [f32], width: usize, height: usize, radius: u32, scratch: &mut [Lanes]) {
    let (line, spare) = scratch.split_at_mut(width.max(height));
    for rows in rgb.chunks_mut(3 * width * ROWS) {
        smooth_rows(rows, &mut line[..width], &mut spare[..width], radius);
    }
    for first in (0..3 * width).step_by(LANES) {
        let lanes = LANES.min(3 * width - first);
        smooth_columns(
            rgb,
            3 * width,
            first..first + lanes,
            (&mut line[..height], &mut spare[..height]),
            radius,
        );
    }
}

/// Smooths up to [`ROWS`] rows along themselves.
fn smooth_rows(rows: &mut [f32], line: &mut [Lanes], spare: &mut [Lanes], radius: u32) {
    let width = line.len();
    for (r, row) in rows.chunks_exact(3 * width).enumerate() {
        for (lanes, pixel) in line.iter_mut().zip(row.chunks_exact(3)) {
            lanes[3 * r..3 * r + 3].copy_from_slice(pixel);
        }
    }
    boxes(line, spare, radius);
    for (r, row) in rows.chunks_exact_mut(3 * width).enumerate() {
        for (lanes, pixel) in line.iter().zip(row.chunks_exact_mut(3)) {
            pixel.copy_from_slice(&lanes[3 * r..3 * r + 3]);
        }
    }
}

/// Smooths some floats of every row across the rows.
fn smooth_columns(
    rgb: &mut [f32],
    stride: usize,
    columns: core::ops::Range<usize>,
    (line, spare): (&mut [Lanes], &mut [Lanes]),
    radius: u32,
) {
    for (lanes, row) in line.iter_mut().zip(rgb.chunks_exact(stride)) {
        lanes[..columns.len()].copy_from_slice(&row[columns.clone()]);
    }
    boxes(line, spare, radius);
    for (lanes, row) in line.iter().zip(rgb.chunks_exact_mut(stride)) {
        row[columns.clone()].copy_from_slice(&lanes[..columns.len()]);
    }
}

/// Three box passes over a line.
fn boxes(line: &mut [Lanes], spare: &mut [Lanes], radius: u32) {
    box_pass(line, spare, radius);
    box_pass(spare, line, radius);
    box_pass(line, spare, radius);
    line.copy_from_slice(spare);
}

/// The mean over 2·radius + 1 positions around each.
fn box_pass(from: &[Lanes], to: &mut [Lanes], radius: u32) {
    let radius = i64::from(radius);
    let scale = 1.0 / (2 * radius + 1) as f64;
    let mut sum = [0.0f64; LANES];
    for i in -radius..=radius {
        let new = &from[fold(i, from.len())];
        (0..LANES).for_each(|k| sum[k] += f64::from(new[k]));
    }
    for (i, out) in (0..).zip(to) {
        let (old, new) = (&from[fold(i - radius, from.len())], &from[fold(i + radius + 1, from.len())]);
        for k in 0..LANES {
            out[k] = (sum[k] * scale) as f32;
            sum[k] += f64::from(new[k]) - f64::from(old[k]);
        }
    }
}

/// The position that reflection puts at `i`: period 2n, ends repeated.
#[inline(always)]
fn fold(i: i64, n: usize) -> usize {
    if (0..n as i64).contains(&i) {
        return i as usize;
    }
    let j = i.rem_euclid(2 * n as i64) as usize;
    if j < n { j } else { 2 * n - 1 - j }
}
