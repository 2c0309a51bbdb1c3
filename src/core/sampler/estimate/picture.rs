//! From the film to the picture.
//!
//! What the balanced estimator gives back is smooth over dozens of pixels, so it is computed on cells of 8 × 8
//! pixels: the excess of a cell's pixels is summed, smoothed over the grid of cells, and interpolated between
//! their centres. See [`estimate`](super) for the formula: F is the guide here, the mean Q or a picture that is lent.
//!
//! Sums are taken and given back in bands, rows of tiles: what a band writes does not depend on where others end.

use super::smooth::{self, LANES, Lanes, smooth};
use super::source::Source;
use crate::maths::colour::luminance8;
use crate::maths::eight::{read_rgb8, read8, write_rgb8};
use crate::sampler::film::cell::{CELL, Region};
use crate::sampler::film::island::Among;
use crate::sampler::film::{Layout, TILE};
use core::ops::Range;
use wide::f32x8;

/// What interpolation between cell centres takes from the cell before, from the one a pixel is in, and from the
/// one after, by the pixel's place in its cell.
const NEAR: [[f32; CELL]; 3] = {
    let mut near = [[0.0; CELL]; 3];
    let mut i = 0;
    while i < CELL {
        let place = (i as f32 + 0.5) / CELL as f32 - 0.5;
        near[0][i] = if place < 0.0 { -place } else { 0.0 };
        near[2][i] = if place > 0.0 { place } else { 0.0 };
        near[1][i] = 1.0 - near[0][i] - near[2][i];
        i += 1;
    }
    near
};

/// What a cell's takers must take, for its excess to be spread: the root of the least normal number, so that no light is too
/// faint, and 64 pixels of [`MAX_RADIANCE`] over it are still a number.
const LEAST_TAKEN: f32 = 1e-19;

/// Length of the scratch a picture needs.
pub(crate) fn scratch_len(width: u32, height: u32) -> usize {
    let (columns, rows) = (width.div_ceil(CELL as u32), height.div_ceil(CELL as u32));
    (columns as usize).saturating_mul(rows as usize).saturating_mul(4).div_ceil(LANES)
        + smooth::scratch_len(columns, rows)
}

/// What is known of the cells of a region while a picture is made: what their takers take, their excess, and what is left.
pub(crate) fn grids(scratch: &mut [Lanes], cells: usize) -> (&mut [f32], &mut [[f32; 3]], &mut [Lanes]) {
    let (grids, lines) = scratch.split_at_mut((4 * cells).div_ceil(LANES));
    let (taken, excess) = grids.as_flattened_mut()[..4 * cells].split_at_mut(cells);
    (taken, excess.as_chunks_mut().0, lines)
}

/// Writes three planes of the film, row by row: a band's rows of tiles into its rows of the picture.
pub(crate) fn plain(layout: &Layout, rows: Range<u32>, colours: &[&mut [f32]; 3], out: &mut [[f32; 3]]) {
    let (width, all) = (layout.width() as usize, Region::all(layout));
    let first = (TILE * rows.start) as usize * width;
    layout.for_each_cell(&all, rows, |cell| {
        for dy in 0..cell.height {
            let rgb = colours.each_ref().map(|plane| read8(&plane[cell.row(dy)]));
            let Range { start, end } = cell.raster(dy, width);
            write_rgb8(&mut out[start - first..end - first], rgb);
        }
    });
}

/// How much a pixel takes of what its neighbourhood has lost: the root of the guide's luminance.
///
/// And a little of what the guide has changed, so that somebody takes what a guide loses that is black everywhere; and what of
/// the mean is negative, so that somebody takes what is lost where a renderer's samples all are.
#[inline(always)]
fn takes(guide: [f32x8; 3], mean: [f32x8; 3]) -> f32x8 {
    let [r, g, b] = [0, 1, 2].map(|c| (guide[c] - mean[c]).abs());
    let below = luminance8(mean.map(|v| (-v).fast_max(f32x8::ZERO)));
    let seen = luminance8(guide).fast_max(f32x8::ZERO) + below;
    (seen + (r + g + b) * f32x8::splat(1e-6)).sqrt()
}

/// Sums the excess over each cell of a band of a region, and what its pixels take over all pixels that interpolate between it
/// and others, of which some are beside the band. Only pixels of `among` count.
///
/// In the order of the tiles for every cell, so that the sums have the same bits for any bands.
pub(crate) fn gather(
    layout: &Layout,
    (among, region): (impl Among, &Region),
    band: &Range<u32>,
    source: impl Source,
    taken: &mut [f32],
    excess: &mut [[f32; 3]],
) {
    taken.fill(0.0);
    let ((columns, rows), own) = (region.grid(layout), region.cell_rows(layout, band));
    let seen = band.start.saturating_sub(1).max(region.rows.start)..region.rows.end.min(band.end + 1);
    layout.for_each_cell(region, seen, |cell| {
        if cell.y + 1 < own.start || cell.y > own.end {
            return;
        }
        let mut lost = [f32x8::ZERO; 3];
        let mut takers = [f32x8::ZERO; 3];
        let is_own = own.contains(&cell.y);
        for dy in 0..cell.height {
            let guide = source.guide(&cell, dy);
            let mask = among.mask(cell.row(dy));
            let here = mask & takes(guide, source.mean(&cell, dy));
            for (sum, near) in takers.iter_mut().zip(NEAR) {
                *sum += here * f32x8::splat(near[dy]);
            }
            if is_own {
                let whole = source.whole(&cell, dy);
                (0..3).for_each(|c| lost[c] += mask & (whole[c] - guide[c]));
            }
        }
        if is_own {
            excess[(cell.y - own.start) * columns + cell.x] = lost.map(sum);
        }
        for (takers, y) in takers.iter().zip(around(cell.y, rows)) {
            if own.contains(&y) {
                for (near, x) in NEAR.iter().zip(around(cell.x, columns)) {
                    taken[(y - own.start) * columns + x] += sum(*takers * f32x8::from(*near));
                }
            }
        }
    });
}

/// Makes of the excess of all cells what a pixel is given for each part it takes, over neighbourhoods of `radii`, in cells.
pub(crate) fn share(
    size: (usize, usize),
    radii: [u32; 3],
    (taken, excess, lines): (&mut [f32], &mut [[f32; 3]], &mut [Lanes]),
) {
    smooth::<1>(taken, size, radii, lines);
    for (excess, taken) in excess.iter_mut().zip(taken) {
        // Where nobody takes anything, no sample was ever anything but black: there is nothing to spread.
        *excess = if *taken > LEAST_TAKEN { excess.map(|excess| excess / *taken) } else { [0.0; 3] };
    }
    smooth::<3>(excess.as_flattened_mut(), size, radii, lines);
}

/// Writes the guide plus what the pixel takes of `excess`, interpolated between cells: a band's pixels of `among` into its rows
/// of the picture.
pub(crate) fn spread<A: Among>(
    layout: &Layout,
    (among, region): (A, &Region),
    band: &Range<u32>,
    source: impl Source,
    excess: &[[f32; 3]],
    out: &mut [[f32; 3]],
) {
    let ((columns, rows), width) = (region.grid(layout), layout.width() as usize);
    let first = (TILE * band.start) as usize * width;
    layout.for_each_cell(region, band.clone(), |cell| {
        let x = around(cell.x, columns);
        let rows = around(cell.y, rows).map(|y| across(x.map(|x| excess[y * columns + x])));
        for dy in 0..cell.height {
            let (guide, mean) = (source.guide(&cell, dy), source.mean(&cell, dy));
            let Range { start, end } = cell.raster(dy, width);
            let rgb = row_of(guide, takes(guide, mean), &rows, dy);
            let out = &mut out[start - first..end - first];
            let kept = if A::ALL { rgb } else { read_rgb8(out) };
            let mask = among.mask(cell.row(dy));
            write_rgb8(out, [0, 1, 2].map(|c| mask.select(rgb[c], kept[c])));
        }
    });
}

/// Row `dy` of a cell; `rows` are the excesses of three rows of cells, interpolated to its columns, `part` what its
/// pixels take of them.
#[inline(always)]
fn row_of(guide: [f32x8; 3], part: f32x8, rows: &[[f32x8; 3]; 3], dy: usize) -> [f32x8; 3] {
    let other = if dy < CELL / 2 { 0 } else { 2 };
    let (near, far) = (f32x8::splat(NEAR[1][dy]), f32x8::splat(NEAR[other][dy]));
    [0, 1, 2].map(|c| guide[c] + part * (rows[1][c] * near + rows[other][c] * far))
}

/// Colours of three neighbouring cells, interpolated to the columns of the middle one.
#[inline(always)]
fn across(cells: [[f32; 3]; 3]) -> [f32x8; 3] {
    let near = NEAR.map(f32x8::from);
    [0, 1, 2].map(|c| {
        let [before, here, after] = cells.map(|cell| f32x8::splat(cell[c]));
        before * near[0] + here * near[1] + after * near[2]
    })
}

/// `i` with its neighbours among `n`; at the ends the cell is its own neighbour.
#[inline(always)]
fn around(i: usize, n: usize) -> [usize; 3] {
    [i.saturating_sub(1), i, (i + 1).min(n - 1)]
}

/// The sum of all lanes, in an order of our own.
#[inline(always)]
fn sum(lanes: f32x8) -> f32 {
    let l = lanes.to_array();
    ((l[0] + l[4]) + (l[2] + l[6])) + ((l[1] + l[5]) + (l[3] + l[7]))
}
