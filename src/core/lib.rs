//! Adaptive image-plane sampling for Monte Carlo rendering, on memory the caller lends.
//!
//! A renderer that spends the same number of samples on a flat wall and on a caustic wastes most of them. This
//! crate decides, iteration by iteration, how many samples each pixel gets: where the eye would see noise, more;
//! exactly as many in all as asked for; and without bias. It is an implementation of the population Monte Carlo
//! image-plane sampler of Lai, Chenney, Liu, Niu and Fan (*Animation rendering with Population Monte Carlo
//! image-plane sampler*, The Visual Computer 2010) with other weights, windows and estimators, which measured
//! better; [`Settings::paper`](sampler::Settings::paper) is the published method.
//!
//! # One frame
//!
//! ```text
//!  kernel ──► allocate ──► sobol ──► Batch8 ──► your integrand ──► Rgb8
//!    ▲        counts       points                                    │
//!    │                                                               ▼
//!    └────────────── tvi ◄── windowed variance ◄─────────────────── film ──► estimate ──► picture
//! ```
//!
//! Data flows one way and comes back along one edge, from the film to the kernel: that edge is the method.
//!
//! # Rooms
//!
//! Four, each of which knows only those after it:
//!
//! * [`tracer`] – a path tracer that comes along, an [`Integrand`](sampler::batch::Integrand) like any other: a
//!   [scene](tracer::scene) as borrowed slices, [camera](tracer::camera), [rays](tracer::trace), [light](tracer::shade),
//!   [photons](tracer::photon).
//! * [`sampler`] – the product: the loop that an embedder drives. **Who brings a renderer starts here and needs nothing
//!   else.** [What crosses the border](sampler::batch), [where samples are needed](sampler::kernel), [how many](sampler::allocate),
//!   [what was seen](sampler::film), [how that becomes a picture](sampler::estimate), and [how any picture gets its
//!   energy](sampler::guide).
//! * [`predict`] – what earlier frames of an animation tell about where the next one needs samples, with
//!   [features](predict::features) and [homographies](predict::homography) for those who have no motion vectors.
//! * [`maths`] – vectors, functions, Owen-scrambled [points](maths::sobol), the eye's [threshold](maths::tvi): eight lanes wide.
//!
//! # Rules
//!
//! * **Memory is lent.** Nothing allocates; each type says how much it needs
//!   ([`Sampler::required`](sampler::Sampler::required), [`PathTracer::required`](tracer::shade::path::PathTracer::required)).
//! * **No files, threads or clock.** Jobs of an iteration, and the parts of what comes before and after them, touch disjoint
//!   slices and may run anywhere; the picture has the same bits in any order. Functions, points and the sampler have the same
//!   bits for every instruction set that `wide` is compiled for, too; rays do not, since their walk ([`tracer::trace`]) fuses
//!   multiplication and addition where the processor can: a picture of the path tracer differs between builds where a hit
//!   lies between two triangles.
//! * **No panics on data, no `unsafe`.** Calls that can fail return a small error that says what to do.
//! * **SIMD is chosen at compile time** (the crate `wide`). On x86-64 build with `-C target-cpu=x86-64-v3`, or
//!   every packet takes two to four times as long.
//!
//! # The smallest embedding
//!
//! [`embedding`] shows how to put this under a renderer of tiles, a wavefront and a lightmapper. `examples/analytic.rs` samples a formula on stack memory; the [`sampler`] page shows the loop.
#![no_std]
#![forbid(unsafe_code)]

/// The crate whose packets cross the border: an embedder needs the same version.
pub use wide;

#[doc = include_str!("embedding.md")]
pub mod embedding {}
pub mod maths;
pub mod predict;
pub mod sampler;
pub mod tracer;

#[cfg(test)]
mod bits;
