//! The std shell around `pmcip-core`: scenes, frames, reports, command line.

pub mod error;
pub mod frame_io;
pub mod metrics;
pub mod output;
pub mod render;
pub mod scene;
pub mod settings;
