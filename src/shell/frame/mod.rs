//! One frame: settings in, picture out.
//!
//! * [`settings`] – all that its bits depend on besides the scene; [`schedule`] – samples of its iterations;
//! * [`render`] – the core's loop on all [threads](mod@threads), with [photon maps](photons) where they are asked for;
//! * [`guide`] – the frame filtered, with all of its energy; [`features`] – what it shows without light;
//! * [`layers`] – what its file has beside the picture; [`restore`] – the energy of a picture denoised elsewhere;
//! * [`attributes`](mod@attributes) – what its file says of how it was made;
//! * [`checkpoint`] – a frame that is not finished, on disk;
//! * [`cost`] – rays that a sample of each pixel needs;
//! * [`stop`] – when a frame is good enough; [`probe`] – whether the camera sees any light;
//! * [`version`] – the number of the pictures that this program makes.

pub mod attributes;
mod budget;
pub mod checkpoint;
pub mod cost;
pub mod features;
pub mod guide;
pub mod layers;
pub mod memory;
pub mod photons;
pub mod probe;
pub mod render;
pub mod restore;
pub mod schedule;
pub mod settings;
pub mod stop;
pub mod threads;
pub mod version;
