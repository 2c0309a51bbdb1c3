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
//! * [`sampler`] – the loop an embedder drives, and the settings; **start here**.
//! * [`batch`] – what crosses the border: eight samples in, eight radiances out.
//! * [`kernel`], [`tvi`] – where samples are needed: variance over the visible threshold.
//! * [`allocate`] – deterministic mixture sampling: exact whole counts.
//! * [`sobol`] – Owen-scrambled points, eight at a time, without state.
//! * [`film`] – running statistics, stored by tiles that threads can share out.
//! * [`estimate`] – how samples become pixels: pooled, subframe, difference, balanced.
//!
//! Frames of an animation are not independent:
//!
//! * [`features`] – points of a picture that can be found again in another one, and who is who.
//! * [`predict`] – what earlier frames tell about where the next one needs samples.
//! * [`homography`] – the plane projective mapping on which most pairs of points agree.
//!
//! A path tracer comes along. It is an [`Integrand`](batch::Integrand) like any other:
//!
//! * [`scene`] – a scene as borrowed slices, checked once; [`camera`] – primary rays.
//! * [`trace`] – packets of eight rays through an eight-wide hierarchy, without cracks.
//! * [`shade`] – materials, lights, the [path tracer](shade::path), and [photon mapping](shade::gather);
//! * [`photon`] – photons in a tree, and the light they bring.
//!
//! [`math`] is the one door for transcendental functions and [`vec3`] the vectors, eight lanes wide.
//!
//! # Rules
//!
//! * **Memory is lent.** Nothing allocates; each type says how much it needs
//!   ([`Sampler::required`](sampler::Sampler::required), [`PathTracer::required`](shade::path::PathTracer::required)).
//! * **No files, threads or clock.** Jobs of an iteration touch disjoint slices and may run anywhere; the picture
//!   has the same bits in any order. Functions, points and the sampler have the same bits for every instruction set that
//!   `wide` is compiled for, too; rays do not, since their walk ([`trace`]) fuses multiplication and addition where the
//!   processor can: a picture of the path tracer differs between builds where a hit lies between two triangles.
//! * **No panics on data, no `unsafe`.** Calls that can fail return a small error that says what to do.
//! * **SIMD is chosen at compile time** (the crate `wide`). On x86-64 build with `-C target-cpu=x86-64-v3`, or
//!   every packet takes two to four times as long.
//!
//! # The smallest embedding
//!
//! `examples/analytic.rs` samples a formula on stack memory; the [`sampler`] page shows the loop.
#![no_std]
#![forbid(unsafe_code)]

pub mod allocate;
pub mod batch;
pub mod camera;
pub mod estimate;
pub mod features;
pub mod film;
pub mod homography;
pub mod kernel;
pub mod math;
pub mod photon;
pub mod predict;
pub mod sampler;
pub mod scene;
pub mod shade;
pub mod sobol;
pub mod trace;
pub mod tvi;
pub mod vec3;

#[cfg(test)]
mod bits;
