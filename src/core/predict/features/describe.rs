//! Direction and descriptor of a feature, from 16 × 16 gradients around it.
//!
//! Histograms have directions at equal angles, eight to a vector. A gradient g between two neighbouring directions is
//! written as a sum of these two; its parts are what it adds. As a function of g's angle a direction's part is a hat,
//! zero from the next direction on, and it is min(g·p, g·q) where that is positive, with p and q perpendicular to the
//! next directions on either side: no angle is computed, and all directions are done at once.

use super::extrema::Extremum;
use super::feature::{CELLS, DESCRIPTOR, Feature, UNIT};
use super::octave::{Octave, level_blur};
use super::strongest::Strongest;
use crate::maths::functions::sin_cos_turn;
use wide::{f32x8, i32x8};

/// Gradients along a side of the grid.
const SIDE: usize = 16;
/// Vectors of eight directions for the dominant one.
const FINE: usize = 4;
/// Directions for the dominant one.
const TURNS: usize = 8 * FINE;
/// Distance of gradients for the direction, in scales: the grid reaches 4.5 scales from the feature.
const DIRECTION_STEP: f32 = 9.0 / SIDE as f32;
/// The same for the descriptor: a cell has four scales, one more than Lowe's.
const DESCRIPTOR_STEP: f32 = 4.0 * CELLS as f32 / SIDE as f32;
/// Part of the highest peak from which on another one is a direction as well.
const PEAK: f32 = 0.8;
/// Largest part of one direction of one cell in a descriptor's norm, so that a glint does not decide alone.
const CLIP: f32 = 0.2;

/// Eight neighbouring directions of a histogram.
#[derive(Clone, Copy)]
struct Hats {
    p: [f32x8; 2],
    q: [f32x8; 2],
}

impl Hats {
    /// Directions `first` … `first + 7` of `count` around the circle.
    fn new(first: usize, count: usize) -> Self {
        let lane = f32x8::from([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]) + f32x8::splat(first as f32);
        let count = f32x8::splat(count as f32);
        let direction =
            |number: f32x8| sin_cos_turn((number + count) / count - ((number + count) / count).floor());
        let gap = sin_cos_turn(f32x8::ONE / count).0;
        let ((sin_a, cos_a), (sin_b, cos_b)) = (direction(lane - f32x8::ONE), direction(lane + f32x8::ONE));
        Hats { p: [-sin_a / gap, cos_a / gap], q: [sin_b / gap, -cos_b / gap] }
    }

    /// What a gradient adds to each direction.
    #[inline(always)]
    fn parts(&self, x: f32, y: f32) -> f32x8 {
        let (x, y) = (f32x8::splat(x), f32x8::splat(y));
        let (a, b) = (x * self.p[0] + y * self.p[1], x * self.q[0] + y * self.q[1]);
        a.fast_min(b).fast_max(f32x8::ZERO)
    }
}

/// A grid of gradients: where it lies, how it is turned.
struct Grid<'a> {
    plane: &'a [f32],
    size: (usize, usize),
    centre: (f32, f32),
    /// Step from a gradient to its right neighbour.
    step: (f32, f32),
}

impl Grid<'_> {
    /// Gradients of a row of the grid, in coordinates of the picture; beyond its border those at the border.
    #[inline(always)]
    fn row(&self, row: usize) -> [(f32, f32); SIDE] {
        let middle = 0.5 * (SIDE - 1) as f32;
        let down = f32x8::splat(row as f32 - middle);
        let lane = f32x8::from([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let (dx, dy) = (f32x8::splat(self.step.0), f32x8::splat(self.step.1));
        let (width, height) = self.size;
        let inside = |place: f32x8, side: usize| -> [i32; 8] {
            let place = place.fast_max(f32x8::ONE).fast_min(f32x8::splat((side - 2) as f32));
            let place: i32x8 = place.round_ties_even().fast_trunc_int();
            place.to_array()
        };
        let mut gradients = [(0.0, 0.0); SIDE];
        for (half, gradients) in gradients.chunks_exact_mut(8).enumerate() {
            let right = lane + f32x8::splat((8 * half) as f32 - middle);
            let x = inside(f32x8::splat(self.centre.0) + right * dx - down * dy, width);
            let y = inside(f32x8::splat(self.centre.1) + right * dy + down * dx, height);
            for (lane, gradient) in gradients.iter_mut().enumerate() {
                let at = y[lane] as usize * width + x[lane] as usize;
                let p = &self.plane[at - width..=at + width];
                *gradient = (p[width + 1] - p[width - 1], p[2 * width] - p[0]);
            }
        }
        gradients
    }
}

/// Tables that are the same for all features.
pub(super) struct Describer {
    fine: [Hats; FINE],
    coarse: Hats,
    /// Gaussian windows over the grid.
    direction_window: [f32; SIDE],
    descriptor_window: [f32; SIDE],
}

/// A Gaussian around the grid's middle, `sigma` in steps.
fn window(sigma: f32) -> [f32; SIDE] {
    core::array::from_fn(|i| {
        let distance = (i as f32 - 0.5 * (SIDE - 1) as f32) / sigma;
        libm::expf(-0.5 * distance * distance)
    })
}

impl Describer {
    pub fn new() -> Self {
        Describer {
            fine: core::array::from_fn(|i| Hats::new(8 * i, TURNS)),
            coarse: Hats::new(0, 8),
            direction_window: window(1.5 / DIRECTION_STEP),
            descriptor_window: window(0.5 * SIDE as f32),
        }
    }

    /// Adds an extremum's features; `pixel` is the side of the octave's pixels in those of the picture.
    pub fn describe(
        &self,
        octave: &Octave<'_>,
        point: &Extremum,
        blur: f32,
        pixel: f32,
        found: &mut Strongest<'_>,
    ) {
        if !found.wants(point.response) {
            return;
        }
        let scale = level_blur(blur, point.level);
        let grid = |step: f32, (sin, cos): (f32, f32)| Grid {
            plane: octave.level(libm::roundf(point.level) as usize),
            size: (octave.width, octave.height),
            centre: (point.x, point.y),
            step: (step * scale * cos, step * scale * sin),
        };
        let histogram = self.directions(&grid(DIRECTION_STEP, (0.0, 1.0)));
        let highest = histogram.iter().copied().fold(0.0, f32::max);
        for turn in peaks(&histogram, PEAK * highest) {
            let (sin, cos) = sin_cos_turn(f32x8::splat(turn));
            let (sin, cos) = (sin.to_array()[0], cos.to_array()[0]);
            found.push(Feature {
                x: point.x * pixel + 0.5,
                y: point.y * pixel + 0.5,
                scale: scale * pixel,
                turn,
                response: point.response,
                descriptor: self.descriptor(&grid(DESCRIPTOR_STEP, (sin, cos)), (sin, cos)),
            });
        }
    }

    /// Histogram of gradient directions around a feature, smoothed.
    fn directions(&self, grid: &Grid<'_>) -> [f32; TURNS] {
        let mut sums = [f32x8::ZERO; FINE];
        for (row, down) in self.direction_window.iter().enumerate() {
            for ((x, y), across) in grid.row(row).into_iter().zip(self.direction_window) {
                let weight = down * across;
                for (sum, hats) in sums.iter_mut().zip(&self.fine) {
                    *sum += hats.parts(x * weight, y * weight);
                }
            }
        }
        let raw: [f32; TURNS] = bytemuck::cast(sums.map(f32x8::to_array));
        let at = |i: usize| raw[i % TURNS];
        core::array::from_fn(|i| {
            let i = i + TURNS;
            6.0 * at(i) + 4.0 * (at(i - 1) + at(i + 1)) + at(i - 2) + at(i + 2)
        })
    }

    /// Histograms over the cells, normalised.
    fn descriptor(&self, grid: &Grid<'_>, (sin, cos): (f32, f32)) -> [i16; DESCRIPTOR] {
        // One cell more at each end takes what falls outside.
        let mut cells = [[f32x8::ZERO; CELLS + 2]; CELLS + 2];
        for (row, down) in self.descriptor_window.iter().enumerate() {
            let (cell_y, part_y) = cell(row);
            for (column, (x, y)) in grid.row(row).into_iter().enumerate() {
                let (cell_x, part_x) = cell(column);
                let weight = down * self.descriptor_window[column];
                let parts = self.coarse.parts((x * cos + y * sin) * weight, (y * cos - x * sin) * weight);
                let (lower, upper) = (parts * f32x8::splat(1.0 - part_y), parts * f32x8::splat(part_y));
                let (left, right) = (f32x8::splat(1.0 - part_x), f32x8::splat(part_x));
                cells[cell_y][cell_x] += lower * left;
                cells[cell_y][cell_x + 1] += lower * right;
                cells[cell_y + 1][cell_x] += upper * left;
                cells[cell_y + 1][cell_x + 1] += upper * right;
            }
        }
        let mut histogram = [0.0; DESCRIPTOR];
        for (i, out) in histogram.chunks_exact_mut(8).enumerate() {
            out.copy_from_slice(&cells[1 + i / CELLS][1 + i % CELLS].to_array());
        }
        normalized(histogram)
    }
}

/// The lower of the two cells a row or column of the grid falls into, and its part in the upper one.
#[inline(always)]
fn cell(i: usize) -> (usize, f32) {
    ((i + 2) / CELLS, ((i + 2) % CELLS) as f32 / CELLS as f32 + 0.125)
}

/// Positions in turns of the peaks of at least `least`, between directions by a parabola.
fn peaks(histogram: &[f32; TURNS], least: f32) -> impl Iterator<Item = f32> {
    let at = |i: usize| histogram[i % TURNS];
    (0..TURNS).filter_map(move |i| {
        let (before, here, after) = (at(i + TURNS - 1), at(i), at(i + 1));
        let peak = here > before && here >= after && here >= least;
        let turn = (i as f32 + 0.5 * (before - after) / (before - 2.0 * here + after)) / TURNS as f32;
        peak.then(|| turn - libm::floorf(turn))
    })
}

/// Square roots of the parts in the sum, after no number exceeds [`CLIP`] of the norm.
fn normalized(mut histogram: [f32; DESCRIPTOR]) -> [i16; DESCRIPTOR] {
    let norm = libm::sqrtf(histogram.iter().map(|h| h * h).sum());
    histogram.iter_mut().for_each(|h| *h = h.min(CLIP * norm));
    let sum = histogram.iter().sum::<f32>().max(f32::MIN_POSITIVE);
    histogram.map(|h| (UNIT * libm::sqrtf(h / sum) + 0.5) as i16)
}
