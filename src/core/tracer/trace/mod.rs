//! Rays against triangles, eight rays at a time.
//!
//! A [`Tracer`] walks the eight-wide hierarchy of a checked [`Scene`](crate::tracer::scene::Scene) with a packet of rays in
//! structure-of-arrays form. A lane takes part while its `t_max` is not negative, so a packet needs no mask beside
//! it. The same packet always gets the same answer, and of two triangles at exactly the same distance the one of
//! lower index is reported. Which of two triangles is nearer by less than rounding can depend on the packet.
//!
//! * `ray` – packets of rays and hits, and what is precomputed for a packet;
//! * `triangle` – the watertight triangle test;
//! * `traverse` – the packet's walk; `single` – the walk of a ray that has parted from its packet.

mod ray;
mod single;
mod traverse;
mod triangle;

pub(crate) use ray::perpendicular;
pub use ray::{Hits8, MISS, Rays8};
pub use traverse::Tracer;
