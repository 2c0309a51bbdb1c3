//! Photons in a k-d tree, and what is asked of them: the nearest, the k nearest, the light they bring.
//!
//! The tree is a perfect binary one in implicit (heap) order whose leaves hold up to eight records as a packet, so
//! that a query tests eight at once. [`build`] orders the records in place and writes splits and leaves into lent
//! memory; [`Tree::new`] checks the three slices once and borrows them. Queries use a fixed stack.
//!
//! A record counts for a query only if its surface faces much the same way, and distances along the query's normal
//! count threefold (a flattened ball, as Jensen, *Realistic Image Synthesis Using Photon Mapping*, 2001, section
//! 7.2.2): light on one wall of a corner says nothing about the other.
//!
//! Light is estimated with Silverman's kernel 2(1 − d²/r²)/(πr²) over the k nearest photons, r the distance of the
//! k-th (Silverman, *Density Estimation*, 1986). The k-th itself gets no weight, which makes the estimate
//! unbiased where photons are even. Where light ends (at an edge, at a shadow) it is smeared over r.

mod build;
mod estimate;
mod neighbours;
mod record;
mod tree;

pub use build::build;
pub use estimate::{STRIDE, estimate};
pub use neighbours::Neighbours;
pub use record::{Error, Irradiance, Leaf, Photon, Site, Split, leaves};
pub use tree::{Query, Tree};

#[cfg(test)]
mod tests;
