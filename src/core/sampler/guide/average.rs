//! Joint non-local means: a pixel becomes an average of those around it whose surroundings look the same.
//!
//! The weight of pixel q for pixel p is by the larger of two squared distances. Colours: over a patch around both, of
//! ((c_p − c_q)² − s·(v_p + min(v_p, v_q))) / (ε + k²·s·(v_p + v_q)), v the variance of c, as in Rousselle, Knaus, Zwicker,
//! *Adaptive rendering with non-local means filtering*, SIGGRAPH Asia 2012, section 4. Features: of normal, albedo and
//! depth, the largest, as in Rousselle, Manzi, Zwicker, *Robust denoising using feature and color information*, Pacific
//! Graphics 2013, section 4; depth is compared with the plane through p. exp(−d) is approximated by (1 − d/8)⁸, and ends
//! at 8.

use super::among::{Among, Everyone, Island};
use super::rows::{MARGIN, Rows};
use crate::maths::eight::{read8, write8};
use core::ops::Range;
use wide::f32x8;

/// Rows of a block.
pub(super) const BLOCK_ROWS: usize = 16;
/// Columns of a block.
const BLOCK: usize = 64;
/// Largest radius of a patch.
const MAX_PATCH: usize = 5;
/// Columns of distances that a block needs.
const WIDE: usize = BLOCK + 16;

/// Planes of what is averaged and of what is known without noise.
pub(super) mod known {
    /// Light: radiance over albedo.
    pub const LIGHT: usize = 0;
    /// Variance of light, smoothed.
    pub const VARIANCE: usize = 3;
    /// The same of the pixel alone.
    pub const OWN_VARIANCE: usize = 4;
    /// Shading normal.
    pub const NORMAL: usize = 5;
    /// Albedo.
    pub const ALBEDO: usize = 8;
    /// Depth.
    pub const DEPTH: usize = 11;
    /// What depth changes by from a pixel to its right neighbour, and to its lower one.
    pub const SLOPE: usize = 12;
    /// Part of a filtered pixel's light that it may have even if its samples have seen none.
    pub const UNSEEN: usize = 14;
    /// Number of planes.
    pub const PLANES: usize = 15;
}

/// Planes of averages.
pub(super) mod averages {
    /// Light.
    pub const LIGHT: usize = 0;
    /// Its variance, smoothed.
    pub const VARIANCE: usize = 3;
    /// The variance of the pixel alone.
    pub const OWN_VARIANCE: usize = 4;
    /// Number of planes.
    pub const PLANES: usize = 5;
}

/// How pixels are compared.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rule {
    /// How far apart pixels may be that are averaged. At most [`MARGIN`] less the patch's radius.
    pub radius: usize,
    /// Radius of a patch, at most [`MAX_PATCH`].
    pub patch: usize,
    /// Factor of what variances say.
    pub scale: f32,
    /// Difference that counts, in standard deviations.
    pub strength: f32,
    /// Differences of features that count, squared: of normals, albedos, depths relative to the slope.
    pub features: [f32; 3],
}

/// Sums over the pixels that have been compared with those of a block.
struct Sums {
    light: [[[f32; BLOCK]; BLOCK_ROWS]; 3],
    weight: [[f32; BLOCK]; BLOCK_ROWS],
    variance: [[f32; BLOCK]; BLOCK_ROWS],
}

/// What a pass reads.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sources<'a> {
    /// [`known`].
    pub known: Rows<'a>,
    /// What colours are compared by: light in planes 0 to 2, its variance in plane 3.
    pub guide: Rows<'a>,
    /// Which pixels belong together, if not all do.
    pub labels: Option<Rows<'a>>,
}

/// Averages the picture's rows from `first` on, as many as `out` has room for: rows of [`averages`], without margins above.
pub(super) fn average(from: &Sources<'_>, rule: &Rule, first: usize, out: &mut [f32]) {
    let (grid, row) = (from.known.grid, averages::PLANES * from.known.grid.stride());
    let rows = out.len() / row;
    for x in (0..grid.width).step_by(BLOCK) {
        let block = Block { x: x + MARGIN, y: first + MARGIN, rows, columns: BLOCK.min(grid.width - x) };
        match from.labels {
            None => average_block(from, rule, &block, Everyone, out),
            Some(labels) => {
                let mut last = 0.0;
                while let Some((label, part)) = block.next_island(&labels, last) {
                    let out = &mut out[(part.y - block.y) * row..][..part.rows * row];
                    average_block(from, rule, &part, Island { labels, label }, out);
                    last = label;
                }
            }
        }
    }
}

/// Averages the pixels of `among` in a block, over others of the same; `out` begins with the block's first row.
fn average_block(from: &Sources<'_>, rule: &Rule, block: &Block, among: impl Among, out: &mut [f32]) {
    let sums = gather(from, rule, block, among);
    let stride = from.known.grid.stride();
    for (dy, out) in out.chunks_exact_mut(averages::PLANES * stride).enumerate() {
        for i in (0..block.columns).step_by(8) {
            let part = f32x8::ONE / read8(&sums.weight[dy][i..]);
            let mask = among.mask(block.x + i, block.y + dy);
            let mut put = |plane: usize, value: f32x8| {
                let line = &mut out[plane * stride + block.x + i..][..8.min(block.columns - i)];
                write8(line, mask.select(value, read8(line)));
            };
            for (c, light) in sums.light.iter().enumerate() {
                put(averages::LIGHT + c, read8(&light[dy][i..]) * part);
            }
            put(averages::OWN_VARIANCE, read8(&sums.variance[dy][i..]) * part * part);
        }
    }
}

/// Sums over all pixels of `among` around those of the block.
fn gather(from: &Sources<'_>, rule: &Rule, block: &Block, among: impl Among) -> Sums {
    let zero = [[0.0; BLOCK]; BLOCK_ROWS];
    let mut sums = Sums { light: [zero; 3], weight: zero, variance: zero };
    let radius = rule.radius as isize;
    for dy in -radius..=radius {
        for dx in -radius..=radius {
            if dx * dx + dy * dy <= (radius + 1) * (radius + 1) {
                compare(from, rule, block, (dx, dy), among, &mut sums);
            }
        }
    }
    sums
}

/// Pixels that are averaged together.
#[derive(Clone, Copy)]
struct Block {
    x: usize,
    y: usize,
    rows: usize,
    columns: usize,
}

impl Block {
    /// The next label after `last` that occurs in the block, and the part of it that does.
    fn next_island(&self, labels: &Rows<'_>, last: f32) -> Option<(f32, Block)> {
        let row = |y: usize| &labels.row(0, y)[self.x..self.x + self.columns];
        let rows = self.y..self.y + self.rows;
        let all = rows.clone().flat_map(row).filter(|label| **label > last);
        let label = all.copied().min_by(f32::total_cmp)?;
        let mut columns = Range { start: usize::MAX, end: 0 };
        let (mut top, mut end) = (usize::MAX, 0);
        for (y, x) in rows
            .flat_map(|y| row(y).iter().enumerate().filter(|(_, l)| **l == label).map(move |(x, _)| (y, x)))
        {
            (top, end) = (top.min(y), end.max(y + 1));
            columns = columns.start.min(x)..columns.end.max(x + 1);
        }
        let x = self.x + columns.start;
        Some((label, Block { x, y: top, rows: end - top, columns: columns.len() }))
    }
}

/// Adds the pixels of `among` that are `(dx, dy)` from those of the block.
fn compare(
    from: &Sources<'_>,
    rule: &Rule,
    block: &Block,
    step: (isize, isize),
    among: impl Among,
    sums: &mut Sums,
) {
    let patch = rule.patch;
    let mut across = [[0.0f32; BLOCK]; BLOCK_ROWS + 2 * MAX_PATCH];
    for (r, across) in across[..block.rows + 2 * patch].iter_mut().enumerate() {
        let mut line = [0.0f32; WIDE];
        let first = (block.x - patch, block.y + r - patch);
        distances(from, rule, first, step, block.columns, among, &mut line);
        for i in (0..block.columns).step_by(8) {
            let sum = (1..=2 * patch).fold(read8(&line[i..]), |sum, k| sum + read8(&line[i + k..]));
            write8(&mut across[i..], sum);
        }
    }
    let share = f32x8::splat(1.0 / ((2 * patch + 1) * (2 * patch + 1)) as f32);
    for r in 0..block.rows {
        let pixels = Pair::new(&from.known, (block.x, block.y + r), step);
        for i in (0..block.columns).step_by(8) {
            let sum =
                across[r + 1..=r + 2 * patch].iter().fold(read8(&across[r][i..]), |s, a| s + read8(&a[i..]));
            let colours = (sum * share).fast_max(f32x8::ZERO);
            if colours.simd_ge(f32x8::splat(8.0)).all() {
                continue;
            }
            let there = (block.x + i).wrapping_add_signed(step.0);
            let mask = among.mask(there, (block.y + r).wrapping_add_signed(step.1));
            let weight = mask & falloff(colours.fast_max(pixels.features(rule, i)));
            let add = |sum: &mut [f32], value| write8(sum, read8(sum) + value);
            for c in 0..3 {
                add(&mut sums.light[c][r][i..i + 8], weight * pixels.there(known::LIGHT + c, i));
            }
            let variance = pixels.there(known::OWN_VARIANCE, i);
            add(&mut sums.variance[r][i..i + 8], weight * weight * variance);
            add(&mut sums.weight[r][i..i + 8], weight);
        }
    }
}

/// Distances of colours between the pixels from `(x, y)` on and those `step` from them, enough for `columns` patches; none
/// where one of the two is not of `among`, as there would be on average if both were alike.
#[inline(always)]
fn distances(
    from: &Sources<'_>,
    rule: &Rule,
    (x, y): (usize, usize),
    step: (isize, isize),
    columns: usize,
    among: impl Among,
    line: &mut [f32; WIDE],
) {
    let guide = &from.guide;
    let (qx, qy) = (x.wrapping_add_signed(step.0), y.wrapping_add_signed(step.1));
    let (p, q) = ([0, 1, 2, 3].map(|c| guide.row(c, y)), [0, 1, 2, 3].map(|c| guide.row(c, qy)));
    let (scale, third) = (f32x8::splat(rule.scale), f32x8::splat(1.0 / 3.0));
    let strength = f32x8::splat(rule.scale * rule.strength * rule.strength);
    for i in (0..columns + 2 * rule.patch).step_by(8) {
        let square = |c: usize| {
            let d = read8(&p[c][x + i..]) - read8(&q[c][qx + i..]);
            d * d
        };
        let (v, w) = (read8(&p[3][x + i..]), read8(&q[3][qx + i..]));
        let excess = (square(0) + square(1) + square(2)) * third - scale * (v + v.fast_min(w));
        let both = among.mask(x + i, y) & among.mask(qx + i, qy);
        write8(&mut line[i..], both & (excess / (f32x8::splat(1e-8) + strength * (v + w))));
    }
}

/// What is known of some pixels of a row, and of those a step from them.
struct Pair<'a> {
    here: [&'a [f32]; known::PLANES],
    there: [&'a [f32]; known::PLANES],
    step: [f32x8; 2],
}

impl<'a> Pair<'a> {
    #[inline(always)]
    fn new(known: &Rows<'a>, (x, y): (usize, usize), step: (isize, isize)) -> Self {
        let (qx, qy) = (x.wrapping_add_signed(step.0), y.wrapping_add_signed(step.1));
        let row = |x: usize, y: usize| core::array::from_fn(|plane| &known.row(plane, y)[x..]);
        let step = [step.0, step.1].map(|v| f32x8::splat(v as f32));
        Pair { here: row(x, y), there: row(qx, qy), step }
    }

    /// Plane of the pixels a step away.
    #[inline(always)]
    fn there(&self, plane: usize, i: usize) -> f32x8 {
        read8(&self.there[plane][i..])
    }

    #[inline(always)]
    fn here(&self, plane: usize, i: usize) -> f32x8 {
        read8(&self.here[plane][i..])
    }

    /// The largest squared distance of features.
    #[inline(always)]
    fn features(&self, rule: &Rule, i: usize) -> f32x8 {
        let difference = |plane: usize| self.here(plane, i) - self.there(plane, i);
        let square = |plane: usize| {
            let d = [0, 1, 2].map(|c| difference(plane + c));
            d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
        };
        let part = rule.features.map(|v| f32x8::splat(1.0 / v));
        let right = self.here(known::SLOPE, i) * self.step[0];
        let down = self.here(known::SLOPE + 1, i) * self.step[1];
        let near = self.here(known::DEPTH, i) * f32x8::splat(0.01);
        let scale = (right.abs() + down.abs()).fast_max(near);
        let off = difference(known::DEPTH) + right + down;
        let depths = off * off / (f32x8::splat(rule.features[2]) * scale * scale + f32x8::splat(1e-12));
        (square(known::NORMAL) * part[0]).fast_max(square(known::ALBEDO) * part[1]).fast_max(depths)
    }
}

/// About exp(−d), 0 from 8 on.
#[inline(always)]
fn falloff(d: f32x8) -> f32x8 {
    let w = (f32x8::ONE - d * f32x8::splat(0.125)).fast_max(f32x8::ZERO);
    let w2 = w * w;
    (w2 * w2) * (w2 * w2)
}
