//! The std shell around `pmcip-core`: scenes, frames, reports. The program `pmcip` puts a command line before this.
//!
//! Rooms, each of which knows only those after it:
//!
//! * [`compare`] – speed against error: methods measured against a reference, and the report;
//! * [`animation`] – frames in a row: what is kept, what a frame learns from those before it, motion, video;
//! * [`bake`] – lightmaps;
//! * [`film`] – the sampler with memory of its own, for programs that bring a renderer;
//! * [`frame`] – one frame: [`Settings`](frame::settings::Settings) in, [`Frame`](frame::render::Frame) out, on all threads;
//! * [`picture`] – EXR and PNG, errors against a reference, files that appear whole or not at all;
//! * [`scene`] – a scene on disk becomes the arrays that the core borrows.
//!
//! [`error`] is what can go wrong in all of them. The formulas of sampling and shading are in the core.

pub mod animation;
pub mod bake;
pub mod compare;
pub mod error;
pub mod film;
pub mod frame;
mod machine;
pub mod picture;
pub mod scene;

pub use film::Film;
