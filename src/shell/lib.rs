//! The std shell around `pmcip-core`: scenes, frames, reports, command line.

pub mod frame_io;
pub mod metrics;
pub mod render;
pub mod scene;
