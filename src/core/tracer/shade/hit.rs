//! What the surface is like where eight rays meet it.

use super::bump::Bend;
use super::fetch::{self, Materials, Surfaces};
use super::site::Sites;
use super::texel::{is_some, textured};
use crate::maths::vec3::Vec3x8;
use crate::tracer::scene::{Motion, Scattering, Scene, SceneData, between};
use crate::tracer::trace::{Hits8, MISS, Rays8};
use wide::{f32x8, u32x8};

/// Eight surface points and their materials, structure of arrays. Lanes that missed hold arbitrary values.
pub(super) struct SurfacePoints {
    /// Lanes that hit something, all bits set.
    pub hit: f32x8,
    /// When they are looked at.
    pub time: f32x8,
    /// Positions, on the triangle up to rounding.
    pub position: Vec3x8,
    /// Unit geometric normals, on the side the ray came from.
    pub facing: Vec3x8,
    /// Unit shading normals, on the side the ray came from.
    pub normal: Vec3x8,
    /// Cosine between the ray and the geometric normal of the front side; negative on the back.
    pub cosine: f32x8,
    /// [`Scattering`] as a number.
    scattering: u32x8,
    /// Diffuse reflectance, texture applied.
    pub diffuse: Vec3x8,
    /// Specular reflectance or tint.
    pub specular: Vec3x8,
    /// GGX width.
    pub roughness: f32x8,
    /// Index of refraction, inside over outside.
    pub ior: f32x8,
    /// Radiance emitted on the front side.
    pub emission: Vec3x8,
    /// What lamps are chosen by: the same, but for textures.
    pub typical_emission: Vec3x8,
    /// Distance from the surface at which rays start.
    clearance: f32x8,
    /// Whether shading normals may be so far from geometric ones that light would come through the surface.
    bent: bool,
}

impl SurfacePoints {
    /// Looks up where `rays` met the scene. At least one lane must have hit.
    #[inline]
    pub fn at(scene: &Scene<'_>, rays: &Rays8, hits: &Hits8) -> Self {
        let data = scene.data();
        let (hit, triangle, weights) = (hits.lanes(), triangles(hits), weights(hits));
        let [a, b, c] = fetch::corners(data, triangle, rays.time);
        let front = (b - a).cross(c - a).normalized();
        let cosine = -rays.direction.dot(front);
        let surface = fetch::surfaces(data, triangle);
        let smooth = match &data.motion {
            None => interpolate(surface.normals, weights),
            Some(motion) => moving_normal(motion, triangle, surface.normals, weights, rays.time),
        };
        let mut normal = shading_normal(smooth, front, rays.direction);
        let material = fetch::materials(data, surface.material);
        let bent = !data.normal_maps.is_empty();
        if bent {
            let (scattering, direction) = (material.scattering, rays.direction);
            let corners = &[a, b, c];
            let bend = Bend { corners, surface: &surface, weights, scattering, front, direction };
            normal = bend.apply(data, normal);
        }
        let mut diffuse = material.diffuse;
        if is_some(material.texture).any() {
            diffuse = diffuse.scaled(textured(data, material.texture, surface.coordinates(weights)));
        }
        if !data.colours.is_empty() {
            diffuse = diffuse.scaled(interpolate(fetch::colours(data, triangle), weights));
        }
        let emission = match scene.has_textured_light() {
            true => shine(data, &surface, &material, weights),
            false => material.emission,
        };
        SurfacePoints {
            hit,
            time: rays.time,
            position: interpolate([a, b, c], weights),
            facing: Vec3x8::select(cosine.simd_lt(f32x8::ZERO), -front, front),
            normal,
            cosine,
            scattering: material.scattering,
            diffuse,
            specular: material.specular,
            roughness: material.roughness,
            ior: material.ior,
            emission,
            typical_emission: material.emission,
            clearance: largest([a, b, c]) * f32x8::splat(CLEARANCE),
            bent,
        }
    }

    /// White, diffuse points of surfaces that are looked at from the front, along their normals.
    pub fn white(sites: &Sites) -> Self {
        let (none, one) = (Vec3x8::default(), f32x8::ONE);
        SurfacePoints {
            hit: f32x8::ZERO.simd_eq(f32x8::ZERO),
            time: f32x8::ZERO,
            position: sites.position,
            facing: sites.facing,
            normal: sites.normal,
            cosine: one,
            scattering: u32x8::splat(Scattering::Rough as u32),
            diffuse: Vec3x8::splat([1.0; 3]),
            specular: none,
            roughness: one,
            ior: one,
            emission: none,
            typical_emission: none,
            clearance: sites.reach * f32x8::splat(CLEARANCE),
            bent: false,
        }
    }

    /// Lanes that hit a surface of this kind, all bits set.
    #[inline(always)]
    pub fn scatters(&self, kind: Scattering) -> f32x8 {
        let kind: f32x8 = bytemuck::cast(self.scattering.simd_eq(u32x8::splat(kind as u32)));
        kind & self.hit
    }

    /// The lanes in which light from a unit `direction` reaches the surface, or goes there: all of them where no normal is bent.
    #[inline(always)]
    pub fn faces(&self, direction: Vec3x8) -> f32x8 {
        if self.bent {
            direction.dot(self.facing).simd_gt(f32x8::ZERO)
        } else {
            f32x8::splat(f32::from_bits(!0))
        }
    }

    /// Where a ray in direction `toward` starts: off the surface by more than the rounding of both.
    #[inline(always)]
    pub fn leave(&self, toward: Vec3x8) -> Vec3x8 {
        self.position + self.facing * self.clearance.copysign(toward.dot(self.facing))
    }
}

/// Distance from the surface at which rays start, relative to the triangle's largest coordinate, on which the
/// rounding of the intersection test depends: 32 units in the last place.
pub(super) const CLEARANCE: f32 = 1.0 / (1 << 18) as f32;

#[inline(always)]
fn interpolate(corner: [Vec3x8; 3], weights: [f32x8; 3]) -> Vec3x8 {
    corner[0] * weights[0] + corner[1] * weights[1] + corner[2] * weights[2]
}

/// The largest coordinate, in absolute value.
#[inline(always)]
pub(super) fn largest(corners: [Vec3x8; 3]) -> f32x8 {
    let of = |v: Vec3x8| v.x.abs().fast_max(v.y.abs()).fast_max(v.z.abs());
    of(corners[0]).fast_max(of(corners[1])).fast_max(of(corners[2]))
}

/// The interpolated normal, not of unit length, on its way between those of two places.
#[inline(never)]
fn moving_normal(
    motion: &Motion<'_>,
    triangle: [u32; 8],
    open: [Vec3x8; 3],
    weights: [f32x8; 3],
    time: f32x8,
) -> Vec3x8 {
    let closing = fetch::closing_normals(motion, triangle);
    between(interpolate(open, weights), interpolate(closing, weights), time)
}

/// The interpolated normal on the side the ray came from; the geometric one where the triangle is flat.
#[inline(always)]
fn shading_normal(smooth: Vec3x8, front: Vec3x8, direction: Vec3x8) -> Vec3x8 {
    let square = smooth.dot(smooth);
    let is_smooth = square.simd_gt(f32x8::splat(1e-12));
    let mut normal = front;
    if is_smooth.any() {
        normal = Vec3x8::select(is_smooth, smooth * (f32x8::ONE / square.sqrt()), front);
    }
    Vec3x8::select(normal.dot(direction).simd_gt(f32x8::ZERO), -normal, normal)
}

/// Radiance emitted at points of eight triangles.
#[inline(never)]
fn shine(data: &SceneData<'_>, surface: &Surfaces, material: &Materials, weights: [f32x8; 3]) -> Vec3x8 {
    let value = textured(data, material.emission_texture, surface.coordinates(weights));
    Vec3x8::select(is_some(material.emission_texture), value, material.emission)
}

/// The part that is there of the surfaces that are hit, 0 to 1. Lanes that missed hold arbitrary values.
pub(super) fn opacity(scene: &Scene<'_>, hits: &Hits8) -> f32x8 {
    let data = scene.data();
    let surface = fetch::surfaces(data, triangles(hits));
    let material = fetch::materials(data, surface.material);
    cover(data, &surface, &material, weights(hits))
}

/// The triangles that are hit; in lanes that missed the first of the scene.
#[inline(always)]
fn triangles(hits: &Hits8) -> [u32; 8] {
    (hits.triangle & hits.triangle.simd_ne(u32x8::splat(MISS))).to_array()
}

/// Barycentric weights of the three corners.
#[inline(always)]
fn weights(hits: &Hits8) -> [f32x8; 3] {
    [f32x8::ONE - hits.u - hits.v, hits.u, hits.v]
}

/// The part that is there of the surface at points of eight triangles.
fn cover(data: &SceneData<'_>, surface: &Surfaces, material: &Materials, weights: [f32x8; 3]) -> f32x8 {
    material.opacity * textured(data, material.opacity_texture, surface.coordinates(weights)).x
}

/// Mean radiance that points of eight triangles emit: of what is there, as a part of all.
#[inline(never)]
pub(super) fn visible_emission(scene: &Scene<'_>, triangle: [u32; 8], weights: [f32x8; 3]) -> Vec3x8 {
    let data = scene.data();
    let surface = fetch::surfaces(data, triangle);
    let material = fetch::materials(data, surface.material);
    shine(data, &surface, &material, weights) * cover(data, &surface, &material, weights)
}

#[cfg(test)]
mod tests;
