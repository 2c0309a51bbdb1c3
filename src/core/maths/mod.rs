//! What everything stands on, eight lanes wide: vectors, functions whose bits are ours, points, the eye's threshold.

pub mod colour;
pub(crate) mod eight;
pub mod functions;
pub(crate) mod matrix;
pub(crate) mod reflect;
pub mod sobol;
pub mod tvi;
pub mod vec3;
