//! Where pictures come from, by rows of cells: what they shall look like, and whose energy they shall have.

use super::smooth::radii;
use crate::maths::eight::read_rgb8;
use crate::sampler::batch::MAX_RADIANCE;
use crate::sampler::film::Planes;
use crate::sampler::film::cell::Cell;
use wide::f32x8;

/// What a picture is put together of.
pub(crate) trait Source: Copy {
    /// What it shall look like.
    fn guide(&self, cell: &Cell, dy: usize) -> [f32x8; 3];
    /// Whose energy it shall have.
    fn whole(&self, cell: &Cell, dy: usize) -> [f32x8; 3];
    /// The mean of all samples.
    fn mean(&self, cell: &Cell, dy: usize) -> [f32x8; 3];
}

/// The mean of a film's samples, given the energy of the fair ones.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Own<'r> {
    pub planes: &'r Planes<'r>,
}

impl Source for Own<'_> {
    #[inline(always)]
    fn guide(&self, cell: &Cell, dy: usize) -> [f32x8; 3] {
        self.mean(cell, dy)
    }

    #[inline(always)]
    fn whole(&self, cell: &Cell, dy: usize) -> [f32x8; 3] {
        self.planes.fair8(cell.row(dy))
    }

    #[inline(always)]
    fn mean(&self, cell: &Cell, dy: usize) -> [f32x8; 3] {
        self.planes.mean8(cell.row(dy))
    }
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
    /// Radii of three boxes over cells.
    pub fn radii(self) -> [u32; 3] {
        match self {
            Energy::Fair(radius) => radii(radius),
            Energy::All => [0; 3],
        }
    }
}

/// A picture (rows from the top), given the energy of a film; where it is not finite or beyond [`MAX_RADIANCE`], the mean
/// stands in.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lent<'r> {
    pub planes: &'r Planes<'r>,
    pub picture: &'r [[f32; 3]],
    pub width: usize,
    pub energy: Energy,
}

impl Source for Lent<'_> {
    #[inline(always)]
    fn guide(&self, cell: &Cell, dy: usize) -> [f32x8; 3] {
        usable(read_rgb8(&self.picture[cell.raster(dy, self.width)]), self.mean(cell, dy))
    }

    #[inline(always)]
    fn whole(&self, cell: &Cell, dy: usize) -> [f32x8; 3] {
        match self.energy {
            Energy::Fair(_) => self.planes.fair8(cell.row(dy)),
            Energy::All => self.mean(cell, dy),
        }
    }

    #[inline(always)]
    fn mean(&self, cell: &Cell, dy: usize) -> [f32x8; 3] {
        self.planes.mean8(cell.row(dy))
    }
}

/// The same of pictures alone, all with rows from the top: a guide, the mean of fair samples, and that of all.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Apart<'r> {
    pub pictures: [&'r [[f32; 3]]; 3],
    pub width: usize,
}

impl Apart<'_> {
    #[inline(always)]
    fn row(&self, picture: usize, cell: &Cell, dy: usize) -> [f32x8; 3] {
        read_rgb8(&self.pictures[picture][cell.raster(dy, self.width)])
    }
}

impl Source for Apart<'_> {
    #[inline(always)]
    fn guide(&self, cell: &Cell, dy: usize) -> [f32x8; 3] {
        usable(self.row(0, cell, dy), self.mean(cell, dy))
    }

    #[inline(always)]
    fn whole(&self, cell: &Cell, dy: usize) -> [f32x8; 3] {
        self.row(1, cell, dy)
    }

    #[inline(always)]
    fn mean(&self, cell: &Cell, dy: usize) -> [f32x8; 3] {
        self.row(2, cell, dy)
    }
}

/// Colours of `lent`, those of `mean` where they are not finite or beyond [`MAX_RADIANCE`].
#[inline(always)]
fn usable(lent: [f32x8; 3], mean: [f32x8; 3]) -> [f32x8; 3] {
    let usable = lent.map(|v| v.abs().simd_le(f32x8::splat(MAX_RADIANCE)));
    let usable = usable[0] & usable[1] & usable[2];
    [0, 1, 2].map(|c| usable.select(lent[c], mean[c]))
}
