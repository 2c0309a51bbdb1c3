//! Pictures on disk, and how far one is from another.
//!
//! * [`frame_io`] – EXR and PNG; [`mod@output`] – files that appear whole or not at all;
//! * [`metrics`] – errors against a reference.

pub mod frame_io;
pub mod metrics;
pub mod output;
