//! Planes of a picture with a margin, stored row by row: all planes of a row, then those of the next.
//!
//! So some rows of all planes are one contiguous slice, which a thread can be given.

use crate::maths::reflect::fold;

/// Pixels beyond the picture's border on each side: as far as a pixel is compared with others, and a bit.
pub(super) const MARGIN: usize = 16;

/// Where pixels are in planes with a margin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    pub width: usize,
    pub height: usize,
}

impl Grid {
    /// Floats from the beginning of a plane's row to its end: with margins, and room to read eight beyond.
    pub fn stride(self) -> usize {
        self.width + 2 * MARGIN + 8
    }

    /// Rows with margins.
    pub fn rows(self) -> usize {
        self.height + 2 * MARGIN
    }

    /// Floats of `planes` planes.
    pub fn floats(self, planes: usize) -> usize {
        planes.saturating_mul(self.stride()).saturating_mul(self.rows())
    }

    /// Fills the margins of `planes` planes by reflection of what is in the picture: half-sample, ends repeated.
    pub fn reflect(self, planes: usize, data: &mut [f32]) {
        let stride = self.stride();
        let row = planes * stride;
        for line in data.chunks_exact_mut(stride).take(row / stride * self.rows()) {
            for i in (0..MARGIN).rev() {
                line[i] = line[MARGIN + fold(i as i64 - MARGIN as i64, self.width)];
            }
            for i in MARGIN + self.width..stride {
                line[i] = line[MARGIN + fold(i as i64 - MARGIN as i64, self.width)];
            }
        }
        for y in (0..MARGIN).chain(MARGIN + self.height..self.rows()) {
            let from = MARGIN + fold(y as i64 - MARGIN as i64, self.height);
            data.copy_within(from * row..(from + 1) * row, y * row);
        }
    }
}

/// Planes to read from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rows<'a> {
    pub data: &'a [f32],
    pub planes: usize,
    pub grid: Grid,
}

impl<'a> Rows<'a> {
    /// Row `y` of a plane, margins included in the numbers of row and columns.
    #[inline(always)]
    pub fn row(&self, plane: usize, y: usize) -> &'a [f32] {
        let stride = self.grid.stride();
        &self.data[(y * self.planes + plane) * stride..][..stride]
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use std::vec;

    #[test]
    fn margins_repeat_the_picture_mirrored() {
        for (width, height) in [(1, 1), (3, 40), (40, 2)] {
            let grid = Grid { width, height };
            let mut data = vec![f32::NAN; grid.floats(2)];
            let stride = grid.stride();
            for (y, x, plane) in
                (0..height).flat_map(|y| (0..width).flat_map(move |x| [0, 1].map(|p| (y, x, p))))
            {
                data[((y + MARGIN) * 2 + plane) * stride + MARGIN + x] = (100 * y + 2 * x + plane) as f32;
            }
            grid.reflect(2, &mut data);
            let rows = Rows { data: &data, planes: 2, grid };
            for (y, x, plane) in
                (0..grid.rows()).flat_map(|y| (0..stride).flat_map(move |x| [0, 1].map(|p| (y, x, p))))
            {
                let of = |i: usize, n| fold(i as i64 - MARGIN as i64, n);
                let want = (100 * of(y, height) + 2 * of(x, width) + plane) as f32;
                assert_eq!(rows.row(plane, y)[x], want);
            }
        }
    }
}
