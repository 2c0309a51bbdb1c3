//! Coloured pixels.

/// Coloured pixels, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Raster {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// sRGB.
    pub pixels: Vec<[u8; 3]>,
}

impl Raster {
    /// The part of the picture in a block.
    pub fn crop(&self, block: &Block) -> Raster {
        let rows = self.pixels.chunks_exact(self.width).skip(block.y).take(block.side);
        let pixels = rows.flat_map(|row| row[block.x..][..block.side].iter().copied()).collect();
        Raster { width: block.side, height: block.side, pixels }
    }
}

/// A square of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    /// Columns to the left of it.
    pub x: usize,
    /// Rows above it.
    pub y: usize,
    /// Pixels in a row.
    pub side: usize,
}
