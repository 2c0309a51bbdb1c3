//! What is made of a pixel and those beside it.

use super::among::together;
use super::average::known;
use super::rows::{Grid, MARGIN, Rows};

/// Fills the margins, and the plane `to` with the means of plane `from` over 3 × 3 pixels.
pub(super) fn finish(
    grid: Grid,
    planes: usize,
    (from, to): (usize, usize),
    labels: Option<Rows<'_>>,
    data: &mut [f32],
) {
    grid.reflect(planes, data);
    let stride = grid.stride();
    let line = |y: usize, plane: usize| (y * planes + plane) * stride;
    for y in MARGIN..MARGIN + grid.height {
        for x in MARGIN..MARGIN + grid.width {
            let row = |y: usize| data[line(y, from) + x - 1..][..3].iter().sum::<f32>();
            data[line(y, to) + x] = match labels {
                None => (row(y - 1) + row(y) + row(y + 1)) * (1.0 / 9.0),
                _ => {
                    let near = (0..9).map(|i| (x + i % 3 - 1, y + i / 3 - 1));
                    let near = near.filter(|near| together(labels, (x, y), *near));
                    let (sum, count) =
                        near.fold((0.0, 0.0), |(s, n), (u, v)| (s + data[line(v, from) + u], n + 1.0));
                    sum / count
                }
            };
        }
    }
    grid.reflect(planes, data);
}

/// Fills the planes of depth's slopes: to each side, the smaller one, so that edges have none.
pub(super) fn slopes(grid: Grid, labels: Option<Rows<'_>>, data: &mut [f32]) {
    let stride = grid.stride();
    let line = |y: usize, plane: usize| (y * known::PLANES + plane) * stride;
    let least = |a: f32, b: f32| {
        let least = if a.abs() < b.abs() { a } else { b };
        if least.is_finite() { least } else { 0.0 }
    };
    for y in MARGIN..MARGIN + grid.height {
        for x in MARGIN..MARGIN + grid.width {
            let depth = |x: usize, y: usize| data[line(y, known::DEPTH) + x];
            let change = |u: usize, v: usize| match together(labels, (x, y), (u, v)) {
                true => depth(u, v) - depth(x, y),
                false => f32::INFINITY,
            };
            let right = least(change(x + 1, y), -change(x - 1, y));
            let down = least(change(x, y + 1), -change(x, y - 1));
            data[line(y, known::SLOPE) + x] = right;
            data[line(y, known::SLOPE + 1) + x] = down;
        }
    }
}
