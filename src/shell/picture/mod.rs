//! Pictures on disk, and how far one is from another.
//!
//! * [`frame_io`] – EXR and PNG; [`mod@output`] – files that appear whole or not at all;
//! * [`live`] – a picture on its way in a viewer;
//! * [`metrics`] – errors against a reference.

pub mod frame_io;
pub mod live;
pub mod metrics;
pub mod output;
