//! From hits to radiance: materials, lights and the integrators that combine them.
//!
//! * `hit` – what the surface is like where a ray meets it; `fetch` – how its records are fetched; `texel` – textures;
//! * `bump` – normal maps;
//! * [`cutout`] – surfaces that are only partly there;
//! * `light` – picking a light and a point on it; `sky` – directions to the sky; `emitters` – both of them;
//! * `rough`, `specular` – the scattering functions;
//! * `vertex` – what happens where a path meets a surface;
//! * `queue`, `shadow` – packets of paths and of shadow rays, kept full;
//! * [`path`] – the path tracer; [`direct`] – direct lighting alone;
//! * [`irradiance`] – what surfaces receive, for lightmaps; `site` – where;
//! * [`features`] – what is seen without light;
//! * [`shoot`], [`gather`] – photons from the lights, and the integrator that looks them up; `source` – where photons start.

mod bump;
pub mod cutout;
pub mod direct;
mod emitters;
pub mod features;
mod fetch;
pub mod gather;
mod hit;
pub mod irradiance;
mod light;
pub mod path;
mod queue;
mod rough;
mod shadow;
pub mod shoot;
mod site;
mod sky;
mod source;
mod specular;
mod texel;
mod vertex;
