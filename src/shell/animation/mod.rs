//! Frames in a row.
//!
//! * [`sequence`] – which frames, and which of them are on disk already: what `--frames` resumes from;
//! * [`startup`] – what a frame learns from those before it, by [`motion`] or from the pictures alone;
//! * [`history`] – filtered frames blended with those before them;
//! * [`video`] – the frames as a film.

pub mod history;
pub mod motion;
pub mod sequence;
pub mod startup;
pub mod video;
