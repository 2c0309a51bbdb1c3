//! Adaptive image-plane sampling for Monte Carlo rendering, on memory the caller lends.
#![no_std]
#![forbid(unsafe_code)]

pub mod allocate;
pub mod batch;
pub mod camera;
pub mod estimate;
pub mod film;
pub mod kernel;
pub mod math;
pub mod sampler;
pub mod scene;
pub mod shade;
pub mod sobol;
pub mod trace;
pub mod tvi;
pub mod vec3;
