//! The film: running statistics of every pixel, stored tile by tile.
//!
//! Tiles of 16 × 16 pixels follow each other in raster order, and so do the pixels of a tile. Tiles at the right
//! and lower edge are smaller; nothing is padded, so a plane has exactly `width · height` entries and a run of
//! tiles is one contiguous slice. A pixel takes [`BYTES_PER_PIXEL`] bytes.
//!
//! Statistics: within an iteration a pixel's samples are summed relative to the first of them, then merged with what
//! is known of it; Chan, Golub, LeVeque, *Updating formulae and a pairwise algorithm for computing sample
//! variances*, 1979, for both.

pub(crate) mod arrivals;
pub(crate) mod cell;
pub(crate) mod island;
mod layout;
mod planes;
pub(crate) mod window;

pub use layout::{Layout, MAX_SIDE, TILE, Tile};
pub use planes::BYTES_PER_PIXEL;
pub(crate) use planes::{FLOATS, Planes, Seen, WORDS};
