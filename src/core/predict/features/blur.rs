//! Gaussian blur, eight pixels at a time.

use wide::f32x8;

/// Largest radius of a window in pixels.
const MAX_RADIUS: usize = 24;
/// Radius of a window in standard deviations.
const REACH: f32 = 3.0;

/// Length of the row [`blur`] borrows.
pub(super) const fn row_len(width: usize) -> usize {
    width + 2 * MAX_RADIUS
}

/// Eight neighbouring values.
#[inline(always)]
pub(super) fn load(values: &[f32], at: usize) -> f32x8 {
    f32x8::from(*values[at..].first_chunk::<8>().expect("eight values before the end"))
}

/// Where packets of eight start in a row; the last one overlaps the one before.
#[inline(always)]
pub(super) fn starts(width: usize) -> impl Iterator<Item = usize> {
    (0..width.div_ceil(8)).map(move |packet| (8 * packet).min(width - 8))
}

/// Blurs `source` into `target` by a Gaussian of standard deviation `sigma`, both `(width, height)`, reflected at the
/// borders. First down the columns into one `row`, then along it.
pub(super) fn blur(
    source: &[f32],
    target: &mut [f32],
    (width, height): (usize, usize),
    sigma: f32,
    row: &mut [f32],
) {
    let mut storage = [0.0; MAX_RADIUS + 1];
    let taps = taps(sigma, width.min(height), &mut storage);
    let radius = taps.len() - 1;
    for (y, target) in target.chunks_exact_mut(width).take(height).enumerate() {
        column_sums(source, (width, height), y, taps, &mut row[radius..][..width]);
        for i in 0..radius {
            row[radius - 1 - i] = row[radius + i];
            row[radius + width + i] = row[radius + width - 1 - i];
        }
        for x in starts(width) {
            let mut sum = f32x8::splat(taps[0]) * load(row, x + radius);
            for (k, tap) in taps.iter().enumerate().skip(1) {
                sum += f32x8::splat(*tap) * (load(row, x + radius - k) + load(row, x + radius + k));
            }
            target[x..x + 8].copy_from_slice(&sum.to_array());
        }
    }
}

/// Row `y` of the picture blurred down its columns.
fn column_sums(source: &[f32], (width, height): (usize, usize), y: usize, taps: &[f32], row: &mut [f32]) {
    let line = |y: usize| &source[y * width..][..width];
    let above = |k: usize| if k <= y { y - k } else { k - y - 1 };
    let below = |k: usize| if y + k < height { y + k } else { 2 * height - 1 - y - k };
    let mut lines = [(line(y), line(y)); MAX_RADIUS + 1];
    for (k, lines) in lines.iter_mut().enumerate().take(taps.len()) {
        *lines = (line(above(k)), line(below(k)));
    }
    let lines = &lines[1..taps.len()];
    for x in starts(width) {
        let mut sum = f32x8::splat(taps[0]) * load(line(y), x);
        for ((above, below), tap) in lines.iter().zip(&taps[1..]) {
            sum += f32x8::splat(*tap) * (load(above, x) + load(below, x));
        }
        row[x..x + 8].copy_from_slice(&sum.to_array());
    }
}

/// One half of the window, from its centre on; it does not reach further than the picture.
fn taps(sigma: f32, side: usize, storage: &mut [f32; MAX_RADIUS + 1]) -> &[f32] {
    let radius = (libm::ceilf(REACH * sigma) as usize).clamp(1, MAX_RADIUS.min(side - 1));
    let taps = &mut storage[..=radius];
    for (k, tap) in taps.iter_mut().enumerate() {
        *tap = libm::expf(-0.5 * (k as f32 / sigma) * (k as f32 / sigma));
    }
    let sum = 2.0 * taps.iter().sum::<f32>() - 1.0;
    taps.iter_mut().for_each(|tap| *tap /= sum);
    taps
}
