//! A tree over many lights: groups with bounded position and direction, eight to a node.
//!
//! [`build`] makes it and writes each light's path; how it is walked is the affair of [`shade`](crate::tracer::shade).

mod build;
mod node;

pub use build::{build, required};
pub(crate) use node::slot;
pub use node::{LIGHT_LEAF, LightNode8, MAX_LIGHT_DEPTH};
