//! A path tracer for triangles, driven by the sampler like any other renderer: it has no privileges.
//!
//! * [`scene`] – what is traced, as slices that the caller lends, checked once; [`camera`] – primary rays;
//! * [`trace`] – where rays meet triangles;
//! * [`shade`] – what they bring back: materials, lights, the integrators;
//! * [`photon`] – photons in a tree, and the light they bring.

pub mod camera;
pub mod photon;
pub mod scene;
pub mod shade;
pub mod trace;
