//! Lightmaps: the irradiance of a scene's surfaces, baked into a picture.
//!
//! * [`charts`] – pieces of the surfaces that can be laid flat; [`atlas`] – all of them in one square, and which point of
//!   which surface a texel shows; `raster` – texels that a triangle touches; [`second`] – texture coordinates that a scene brings for it;
//! * [`light`] – samples where noise is, island by island; [`dilate`] – texels beside islands, for filters that look there;
//! * [`mesh`] – the scene's triangles with their places in the lightmap;
//! * [`check`] – the scene lit by its lightmap, beside the path tracer.

pub mod atlas;
pub mod charts;
pub mod check;
pub mod dilate;
pub mod light;
pub mod mesh;
mod raster;
pub mod second;
