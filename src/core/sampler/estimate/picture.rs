//! From the film to the picture.
//!
//! What the balanced estimator gives back is smooth over dozens of pixels, so it is computed on cells of 8 × 8
//! pixels: the excess of a cell's pixels is summed, smoothed over the grid of cells, and interpolated between
//! their centres. See [`estimate`](super) for the formula: F is the guide here, the mean Q or a picture that is lent.

use super::smooth::{self, LANES, Lanes, smooth};
use crate::maths::colour::luminance8;
use crate::maths::eight::{read_rgb8, read8, write_rgb8};
use crate::sampler::batch::MAX_RADIANCE;
use crate::sampler::film::cell::{CELL, Cell, Region};
use crate::sampler::film::island::{Among, Everyone, Island};
use crate::sampler::film::{Layout, Planes};
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

/// Length of the scratch [`balanced`] needs.
pub(crate) fn scratch_len(width: u32, height: u32) -> usize {
    let (columns, rows) = (width.div_ceil(CELL as u32), height.div_ceil(CELL as u32));
    (columns as usize).saturating_mul(rows as usize).saturating_mul(4).div_ceil(LANES)
        + smooth::scratch_len(columns, rows)
}

/// Writes three planes of the film, row by row.
pub(crate) fn plain(layout: &Layout, colours: &[&mut [f32]; 3], out: &mut [[f32; 3]]) {
    layout.for_each_cell(&Region::all(layout), |cell| {
        for dy in 0..cell.height {
            let rgb = colours.each_ref().map(|plane| read8(&plane[cell.row(dy)]));
            write_rgb8(&mut out[cell.raster(dy, layout.width() as usize)], rgb);
        }
    });
}

/// Whose energy a guide is given.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Energy {
    /// That of the fair samples, over neighbourhoods of this radius.
    Fair(u32),
    /// That of all samples, over neighbourhoods of a cell and its interpolation alone.
    All,
}

impl Energy {
    #[inline(always)]
    fn of(self, planes: &Planes<'_>, row: Range<usize>) -> [f32x8; 3] {
        match self {
            Energy::Fair(_) => planes.fair8(row),
            Energy::All => planes.mean8(row),
        }
    }

    fn radii(self) -> [u32; 3] {
        match self {
            Energy::Fair(radius) => radii(radius),
            Energy::All => [0; 3],
        }
    }
}

/// Where a row of a cell is read.
pub(crate) trait Row: Fn(&Cell, usize) -> [f32x8; 3] {}
impl<R: Fn(&Cell, usize) -> [f32x8; 3]> Row for R {}

/// What a picture is put together of.
struct Parts<F, D, Q> {
    /// What it shall look like.
    guide: F,
    /// Whose energy it shall have.
    whole: D,
    /// The mean of all samples.
    mean: Q,
}

/// Writes the balanced estimator, row by row; `scratch` is [`scratch_len`] long.
pub(crate) fn balanced(
    layout: &Layout,
    planes: &Planes<'_>,
    radius: u32,
    scratch: &mut [Lanes],
    out: &mut [[f32; 3]],
) {
    let mean = |cell: &Cell, dy: usize| planes.mean8(cell.row(dy));
    let whole = |cell: &Cell, dy: usize| planes.fair8(cell.row(dy));
    guided(layout, planes.label, &Parts { guide: mean, whole, mean }, radii(radius), scratch, out);
}

/// Writes `picture` (rows from the top), given `energy`; where it is not finite or beyond
/// [`MAX_RADIANCE`], the mean stands in.
pub(crate) fn lent(
    layout: &Layout,
    planes: &Planes<'_>,
    picture: &[[f32; 3]],
    energy: Energy,
    scratch: &mut [Lanes],
    out: &mut [[f32; 3]],
) {
    let mean = |cell: &Cell, dy: usize| planes.mean8(cell.row(dy));
    let whole = |cell: &Cell, dy: usize| energy.of(planes, cell.row(dy));
    let lent = rows(layout, picture);
    let guide = |cell: &Cell, dy: usize| usable(lent(cell, dy), mean(cell, dy));
    guided(layout, planes.label, &Parts { guide, whole, mean }, energy.radii(), scratch, out);
}

/// The same of pictures alone, all with rows from the top: `picture` with the energy of `fair` over neighbourhoods of
/// `radius`, where `mean` is that of all samples.
pub(crate) fn restored(
    layout: &Layout,
    [picture, fair, mean]: [&[[f32; 3]]; 3],
    radius: u32,
    scratch: &mut [Lanes],
    out: &mut [[f32; 3]],
) {
    let (lent, whole, mean) = (rows(layout, picture), rows(layout, fair), rows(layout, mean));
    let guide = |cell: &Cell, dy: usize| usable(lent(cell, dy), mean(cell, dy));
    guided(layout, &[], &Parts { guide, whole, mean: &mean }, radii(radius), scratch, out);
}

/// Rows of a picture that is stored row by row.
fn rows(layout: &Layout, picture: &[[f32; 3]]) -> impl Row {
    let width = layout.width() as usize;
    move |cell: &Cell, dy: usize| read_rgb8(&picture[cell.raster(dy, width)])
}

/// Colours of `lent`, those of `mean` where they are not finite or beyond [`MAX_RADIANCE`].
#[inline(always)]
fn usable(lent: [f32x8; 3], mean: [f32x8; 3]) -> [f32x8; 3] {
    let usable = lent.map(|v| v.abs().simd_le(f32x8::splat(MAX_RADIANCE)));
    let usable = usable[0] & usable[1] & usable[2];
    [0, 1, 2].map(|c| usable.select(lent[c], mean[c]))
}

/// Writes the guide, given the energy of the whole over neighbourhoods of these `radii`, in cells; of every island by itself,
/// if there are `labels`, and black where there is none.
fn guided(
    layout: &Layout,
    labels: &[u32],
    parts: &Parts<impl Row, impl Row, impl Row>,
    radii: [u32; 3],
    scratch: &mut [Lanes],
    out: &mut [[f32; 3]],
) {
    if labels.is_empty() {
        return guided_among(layout, (Everyone, &Region::all(layout)), parts, radii, scratch, out);
    }
    out.fill([0.0; 3]);
    for (island, region) in Island::each(layout, labels) {
        guided_among(layout, (island, &region), parts, radii, scratch, out);
    }
}

/// Writes the pixels of `among`, all of which are in `region`, as if there were no others.
fn guided_among(
    layout: &Layout,
    (among, region): (impl Among, &Region),
    parts: &Parts<impl Row, impl Row, impl Row>,
    radii: [u32; 3],
    scratch: &mut [Lanes],
    out: &mut [[f32; 3]],
) {
    let size = region.grid(layout);
    let cells = size.0 * size.1;
    let (grids, lines) = scratch.split_at_mut((4 * cells).div_ceil(LANES));
    let (taken, excess) = grids.as_flattened_mut()[..4 * cells].split_at_mut(cells);
    gather(layout, (among, region), parts, taken, excess.as_chunks_mut().0);
    smooth::<1>(taken, size, radii, lines);
    for (excess, taken) in excess.as_chunks_mut::<3>().0.iter_mut().zip(taken) {
        // Where nobody takes anything, no sample was ever anything but black: there is nothing to spread.
        *excess = if *taken > LEAST_TAKEN { excess.map(|excess| excess / *taken) } else { [0.0; 3] };
    }
    smooth::<3>(excess, size, radii, lines);
    spread(layout, (among, region), parts, excess.as_chunks().0, out);
}

/// Radii of three boxes over cells that, with what cells and interpolation blur by themselves, have a variance of
/// about `radius`·(`radius` + 1) pixels².
fn radii(radius: u32) -> [u32; 3] {
    const CELL_AREA: u32 = (CELL * CELL) as u32;
    // In units of a cell's area. Summing over a cell and interpolating blur by a quarter of it.
    let wanted = 3 * (radius * (radius + 1)).saturating_sub(CELL_AREA / 4) / CELL_AREA;
    let least = (0..).take_while(|r| 3 * r * (r + 1) <= wanted).last().unwrap_or(0);
    // A box one larger adds 2·(r + 1).
    let larger = (wanted - 3 * least * (least + 1) + least + 1) / (2 * (least + 1));
    [0, 1, 2].map(|i| least + u32::from(i < larger))
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

/// Sums the excess over each cell, and what its pixels take over all pixels that interpolate between it and others.
fn gather(
    layout: &Layout,
    (among, region): (impl Among, &Region),
    parts: &Parts<impl Row, impl Row, impl Row>,
    taken: &mut [f32],
    excess: &mut [[f32; 3]],
) {
    taken.fill(0.0);
    let (columns, rows) = region.grid(layout);
    layout.for_each_cell(region, |cell| {
        let mut lost = [f32x8::ZERO; 3];
        let mut takers = [f32x8::ZERO; 3];
        for dy in 0..cell.height {
            let (guide, whole) = ((parts.guide)(&cell, dy), (parts.whole)(&cell, dy));
            let mask = among.mask(cell.row(dy));
            let here = mask & takes(guide, (parts.mean)(&cell, dy));
            for (sum, near) in takers.iter_mut().zip(NEAR) {
                *sum += here * f32x8::splat(near[dy]);
            }
            (0..3).for_each(|c| lost[c] += mask & (whole[c] - guide[c]));
        }
        excess[cell.y * columns + cell.x] = lost.map(sum);
        for (takers, y) in takers.iter().zip(around(cell.y, rows)) {
            for (near, x) in NEAR.iter().zip(around(cell.x, columns)) {
                taken[y * columns + x] += sum(*takers * f32x8::from(*near));
            }
        }
    });
}

/// Writes the guide plus what the pixel takes of `excess`, interpolated between cells.
fn spread<A: Among>(
    layout: &Layout,
    (among, region): (A, &Region),
    parts: &Parts<impl Row, impl Row, impl Row>,
    excess: &[[f32; 3]],
    out: &mut [[f32; 3]],
) {
    let (columns, rows) = region.grid(layout);
    layout.for_each_cell(region, |cell| {
        let x = around(cell.x, columns);
        let rows = around(cell.y, rows).map(|y| across(x.map(|x| excess[y * columns + x])));
        for dy in 0..cell.height {
            let (guide, mean) = ((parts.guide)(&cell, dy), (parts.mean)(&cell, dy));
            let raster = cell.raster(dy, layout.width() as usize);
            let rgb = row_of(guide, takes(guide, mean), &rows, dy);
            let out = &mut out[raster];
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
