//! Everything that a frame's bits depend on, besides the scene's file.
//!
//! ```no_run
//! use pmcip::frame::{render, settings::{Method, Settings}};
//! use pmcip::scene;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let scene = scene::load("scenes/caustic.toml".as_ref())?;
//! let mut settings = Settings::new(&scene, Method::Pmc, Some(16), Some((320, 240)));
//! settings.sampler.seed = 7;
//! let frame = render::render(&scene, &settings, None, &|_| ())?;
//! println!("{} samples in {} s", frame.tally.samples, frame.seconds);
//! # Ok(())
//! # }
//! ```

mod all;
mod choices;
mod layers;
mod list;

pub use all::{
    DEFAULT_DEPTH, DEFAULT_LIGHT_SAMPLES, DEFAULT_PHOTONS, DEFAULT_SPP, MAX_DEPTH, MAX_LIGHT_SAMPLES,
    MAX_PHOTONS, Settings,
};
pub use choices::{Estimate, Integrator, Method, Startup};
pub use layers::{Layer, Layers};
pub use list::word;
