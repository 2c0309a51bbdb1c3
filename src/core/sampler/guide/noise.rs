//! How noisy pixels are, as far as the film can tell.
//!
//! The variance of samples, divided by their number, is that of a mean of independent samples. Stratified ones do better: on
//! smooth pixels many times. The film knows, since it has two means of every pixel: that of the fair samples, the first n,
//! and that of all N. With independent samples the square of their difference has the expectation v·(N − n)/n, v the variance
//! of the mean of all; what it is in truth over that is averaged over 17 × 17 pixels, as one pixel's is hardly a measurement.
//!
//! That is how stratified the first n samples are, about. The error of stratified samples falls faster than 1/N, so more of
//! them are better still: a factor f is applied as f^1.5 (measured on carved stone, with a quarter of the samples fair).

use super::rows::{Grid, MARGIN, Rows};
use crate::maths::colour::luminance;
use crate::maths::eight::{read8, write8};
use wide::f32x8;

/// How far around a pixel is looked, in pixels.
const RADIUS: usize = 8;
/// What one pixel can say at most: of one squared normal number in twenty is more left out.
const MOST: f32 = 4.0;
/// What is left of the mean of the square of a normal number if it is cut there.
const LEFT: f32 = 0.9205;
/// Least factor of a variance.
const LEAST: f32 = 0.01;

/// Planes of scratch.
mod plane {
    /// Squared differences over what independent samples would make them, times their weights.
    pub const RATIO: usize = 0;
    /// Weights.
    pub const WEIGHT: usize = 1;
    /// Sums of the two along a row.
    pub const SUMS: usize = 2;
}

/// What a pixel says, and with what weight: `mean` is that of all `count` samples, `fair` that of the first `n`, `variance`
/// that of the mean if samples were independent.
pub(super) fn ratio(mean: [f32; 3], fair: [f32; 3], variance: f32, n: u32, count: u32) -> [f32; 2] {
    if count <= n || variance <= 0.0 {
        return [0.0; 2];
    }
    let gap = luminance([0, 1, 2].map(|c| mean[c] - fair[c]));
    let more = (count - n) as f32;
    let weight = more / count as f32;
    let ratio = gap * gap * n as f32 / (more * variance);
    if ratio.is_finite() { [ratio.min(MOST) * weight, LEFT * weight] } else { [0.0; 2] }
}

/// Sums the ratios and weights, in the first two of `planes` planes, along rows.
pub(super) fn gather(grid: Grid, planes: usize, scratch: &mut [f32]) {
    grid.reflect(planes, scratch);
    let stride = grid.stride();
    for row in scratch.chunks_exact_mut(planes * stride) {
        let (from, to) = row.split_at_mut(plane::SUMS * stride);
        for (from, to) in from.chunks_exact(stride).zip(to.chunks_exact_mut(stride)) {
            for x in (MARGIN..MARGIN + grid.width).step_by(8) {
                let around = &from[x - RADIUS..];
                let sum = (0..=2 * RADIUS).fold(f32x8::ZERO, |sum, k| sum + read8(&around[k..]));
                write8(&mut to[x..], sum);
            }
        }
    }
}

/// Factors of the variances of eight pixels from (`x`, `y`) on, margins counted; `gathered` are planes after [`gather`].
pub(super) fn factors(gathered: &Rows<'_>, labels: Option<Rows<'_>>, x: usize, y: usize) -> f32x8 {
    let around = y - RADIUS..=y + RADIUS;
    let sum =
        |plane: usize| around.clone().fold(f32x8::ZERO, |sum, y| sum + read8(&gathered.row(plane, y)[x..]));
    let [ratio, weight] = match labels {
        None => [sum(plane::SUMS + plane::RATIO), sum(plane::SUMS + plane::WEIGHT)],
        Some(labels) => sums_among(gathered, &labels, x, y),
    };
    let factor = (ratio / weight.fast_max(f32x8::splat(f32::MIN_POSITIVE))).fast_min(f32x8::ONE);
    let factor = (factor * factor.sqrt()).fast_max(f32x8::splat(LEAST));
    weight.simd_gt(f32x8::ZERO).select(factor, f32x8::ONE)
}

/// Sums of ratios and weights over the pixels of the same label.
fn sums_among(gathered: &Rows<'_>, labels: &Rows<'_>, x: usize, y: usize) -> [f32x8; 2] {
    let label = read8(&labels.row(0, y)[x..]);
    let mut sums = [f32x8::ZERO; 2];
    for y in y - RADIUS..=y + RADIUS {
        for x in x - RADIUS..=x + RADIUS {
            let same = read8(&labels.row(0, y)[x..]).simd_eq(label);
            for (sum, plane) in sums.iter_mut().zip([plane::RATIO, plane::WEIGHT]) {
                *sum += same & read8(&gathered.row(plane, y)[x..]);
            }
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use crate::maths::sobol::hash;
    use std::vec;

    const GRID: Grid = Grid { width: 21, height: 19 };

    fn factor(of: impl Fn(usize) -> [f32; 2]) -> f32 {
        let (planes, stride) = (5, GRID.stride());
        let mut data = vec![0.0; GRID.floats(planes)];
        for (i, (y, x)) in (0..GRID.height).flat_map(|y| (0..GRID.width).map(move |x| (y, x))).enumerate() {
            for (plane, value) in of(i).into_iter().enumerate() {
                data[((y + MARGIN) * planes + plane) * stride + MARGIN + x] = value;
            }
        }
        gather(GRID, planes, &mut data);
        factors(&Rows { data: &data, planes, grid: GRID }, None, MARGIN + 4, MARGIN + 9).to_array()[0]
    }

    /// Independent samples, 16 of which 4 are fair, each ±1 by a hash: the mean of 289 ratios is 1 ± 0.07, less four such
    /// errors 0.72. Where the fair samples say exactly what all say, the least factor.
    #[test]
    fn independent_samples_are_as_noisy_as_they_say_and_stratified_ones_less() {
        let sign = |i: usize, k: usize| if hash((64 * i + k) as u32) & 1 == 0 { 1.0 } else { -1.0 };
        let mean = |i: usize, n: usize| (0..n).map(|k| sign(i, k)).sum::<f32>() / n as f32;
        let independent = factor(|i| ratio([mean(i, 16); 3], [mean(i, 4); 3], 1.0 / 16.0, 4, 16));
        let (least, most) = (0.72f32.powf(1.5), 1.0);
        assert!((least..=most).contains(&independent), "{independent}");
        let stratified = factor(|_| ratio([0.0; 3], [0.0; 3], 1.0 / 16.0, 4, 16));
        assert_eq!(stratified, LEAST);
    }

    #[test]
    fn who_has_only_fair_samples_says_nothing() {
        assert_eq!(factor(|_| ratio([1.0; 3], [2.0; 3], 0.1, 4, 4)), 1.0);
        assert_eq!(factor(|_| ratio([1.0; 3], [1.0; 3], 0.0, 4, 16)), 1.0);
        assert_eq!(ratio([f32::MAX; 3], [-f32::MAX; 3], 1.0, 4, 16), [0.0; 2]);
    }
}
