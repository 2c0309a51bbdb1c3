//! The smooth window of the balanced estimator over the grid of cells: three box passes each way, in place.
//!
//! Half-sample reflection at both ends makes every pass a symmetric matrix whose rows and columns sum to one,
//! at any radius and any size. Sums run in double precision: a firefly that enters and leaves a single
//! precision sum would leave a trace along the whole line.

use crate::maths::reflect::fold;
use crate::sampler::film::cell::CELL;

/// A position of a line: pixels of neighbouring rows, or sixteen neighbouring floats of a row.
pub type Lanes = [f32; LANES];

/// Floats at a position of a line.
pub(crate) const LANES: usize = 16;
/// Lines of columns that are copied at once: longer pieces of every row, fewer waits for memory.
const STRIP: usize = 4;
/// Largest radius of a box.
pub const MAX_RADIUS: u32 = 4_096;

/// Scratch [`smooth`] needs for a picture of this size.
pub(crate) fn scratch_len(width: u32, height: u32) -> usize {
    (STRIP + 1) * width.max(height) as usize
}

/// Radii of three boxes over cells that, with what cells and interpolation blur by themselves, have a variance of
/// about `radius`·(`radius` + 1) pixels².
pub(crate) fn radii(radius: u32) -> [u32; 3] {
    const CELL_AREA: u32 = (CELL * CELL) as u32;
    // In units of a cell's area. Summing over a cell and interpolating blur by a quarter of it.
    let wanted = 3 * (radius * (radius + 1)).saturating_sub(CELL_AREA / 4) / CELL_AREA;
    let least = (0..).take_while(|r| 3 * r * (r + 1) <= wanted).last().unwrap_or(0);
    // A box one larger adds 2·(r + 1).
    let larger = (wanted - 3 * least * (least + 1) + least + 1) / (2 * (least + 1));
    [0, 1, 2].map(|i| least + u32::from(i < larger))
}

/// Smooths a picture of `CHANNELS` interleaved floats a pixel in place. `scratch` is [`scratch_len`] long.
pub(crate) fn smooth<const CHANNELS: usize>(
    picture: &mut [f32],
    (width, height): (usize, usize),
    radii: [u32; 3],
    scratch: &mut [Lanes],
) {
    let (spare, lines) = scratch.split_at_mut(width.max(height));
    let stride = CHANNELS * width;
    for rows in picture.chunks_mut(stride * (LANES / CHANNELS)) {
        smooth_rows::<CHANNELS>(rows, &mut lines[..width], &mut spare[..width], radii);
    }
    for first in (0..stride).step_by(STRIP * LANES) {
        let columns = first..(first + STRIP * LANES).min(stride);
        smooth_columns(picture, stride, columns, (lines, &mut spare[..height]), radii);
    }
}

/// Smooths some rows along themselves, as many as have room in the lanes.
fn smooth_rows<const CHANNELS: usize>(
    rows: &mut [f32],
    line: &mut [Lanes],
    spare: &mut [Lanes],
    radii: [u32; 3],
) {
    let stride = CHANNELS * line.len();
    for (r, row) in rows.chunks_exact(stride).enumerate() {
        for (lanes, pixel) in line.iter_mut().zip(row.chunks_exact(CHANNELS)) {
            lanes[CHANNELS * r..][..CHANNELS].copy_from_slice(pixel);
        }
    }
    boxes(line, spare, radii);
    for (r, row) in rows.chunks_exact_mut(stride).enumerate() {
        for (lanes, pixel) in spare.iter().zip(row.chunks_exact_mut(CHANNELS)) {
            pixel.copy_from_slice(&lanes[CHANNELS * r..][..CHANNELS]);
        }
    }
}

/// Smooths some floats of every row across the rows.
fn smooth_columns(
    picture: &mut [f32],
    stride: usize,
    columns: core::ops::Range<usize>,
    (lines, spare): (&mut [Lanes], &mut [Lanes]),
    radii: [u32; 3],
) {
    let height = spare.len();
    for (y, row) in picture.chunks_exact(stride).enumerate() {
        for (k, piece) in row[columns.clone()].chunks(LANES).enumerate() {
            let lanes = &mut lines[k * height + y];
            match piece.first_chunk() {
                Some(whole) => *lanes = *whole,
                None => lanes[..piece.len()].copy_from_slice(piece),
            }
        }
    }
    for (first, line) in columns.clone().step_by(LANES).zip(lines.chunks_exact_mut(height)) {
        boxes(line, spare, radii);
        for (lanes, row) in spare.iter().zip(picture.chunks_exact_mut(stride)) {
            let piece = &mut row[first..columns.end.min(first + LANES)];
            match piece.first_chunk_mut() {
                Some(whole) => *whole = *lanes,
                None => piece.copy_from_slice(&lanes[..piece.len()]),
            }
        }
    }
}

/// Three box passes over a line; the result is in `spare`.
fn boxes(line: &mut [Lanes], spare: &mut [Lanes], radii: [u32; 3]) {
    box_pass(line, spare, radii[0]);
    box_pass(spare, line, radii[1]);
    box_pass(line, spare, radii[2]);
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

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use crate::maths::sobol::hash;
    use std::vec;
    use std::vec::Vec;

    /// The definition, one colour: three boxes along rows, then three across, every index folded.
    fn scalar(picture: &[f64], width: usize, height: usize, radii: [u32; 3]) -> Vec<f64> {
        let pass = |from: &[f64], (dx, dy): (i64, i64), radius: u32| -> Vec<f64> {
            let at = |x: i64, y: i64| from[fold(y, height) * width + fold(x, width)];
            let mean = |x: i64, y: i64| {
                let r = i64::from(radius);
                (-r..=r).map(|i| at(x + i * dx, y + i * dy)).sum::<f64>() / (2 * r + 1) as f64
            };
            (0..width * height).map(|i| mean((i % width) as i64, (i / width) as i64)).collect()
        };
        let steps = [(1, 0), (0, 1)].into_iter().flat_map(|step| radii.map(|radius| (step, radius)));
        steps.fold(picture.to_vec(), |picture, (step, radius)| pass(&picture, step, radius))
    }

    fn picture(width: usize, height: usize) -> Vec<f32> {
        (0..3 * width * height).map(|i| (hash(i as u32) >> 20) as f32 - 2000.0).collect()
    }

    fn smoothed(mut rgb: Vec<f32>, width: usize, height: usize, radii: [u32; 3]) -> Vec<f32> {
        let mut scratch = vec![[9.0; LANES]; scratch_len(width as u32, height as u32)];
        smooth::<3>(&mut rgb, (width, height), radii, &mut scratch);
        rgb
    }

    #[test]
    fn equals_the_definition_and_keeps_the_energy() {
        for (width, height) in [(1, 1), (1, 9), (13, 1), (7, 11), (40, 23)] {
            for radii in [[0, 0, 0], [1, 1, 1], [2, 3, 3], [12, 12, 11], [50, 50, 50]] {
                let before = picture(width, height);
                let after = smoothed(before.clone(), width, height, radii);
                let mut red: Vec<f32> = before.iter().step_by(3).copied().collect();
                let mut scratch = vec![[9.0; LANES]; scratch_len(width as u32, height as u32)];
                smooth::<1>(&mut red, (width, height), radii, &mut scratch);
                assert!(red.iter().eq(after.iter().step_by(3)));
                for c in 0..3 {
                    let colour =
                        |rgb: &[f32]| -> Vec<f64> { rgb.chunks(3).map(|rgb| f64::from(rgb[c])).collect() };
                    let (before, after) = (colour(&before), colour(&after));
                    let want = scalar(&before, width, height, radii);
                    assert!(
                        want.iter().zip(&after).all(|(a, b)| (a - b).abs() < 1e-2),
                        "{width}×{height}, {radii:?}"
                    );
                    let (a, b) = (before.iter().sum::<f64>(), after.iter().sum::<f64>());
                    assert!((a - b).abs() < 1e-3 * before.len() as f64);
                }
            }
        }
    }

    #[test]
    fn a_firefly_leaves_no_trace_beyond_the_window() {
        let mut rgb = vec![0.0; 3 * 200];
        rgb[3 * 20] = 1e9;
        let after = smoothed(rgb, 200, 1, [4; 3]);
        assert!(after[3 * 20] > 5e7 && after[3 * 33..].iter().all(|v| v.abs() < 1e-6));
    }
}
