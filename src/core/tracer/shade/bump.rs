//! Normal maps: shading normals that vary within a triangle.
//!
//! A texel is a vector in the frame of the shading normal and of the directions in which the texture's coordinates grow over
//! the triangle, made orthogonal. A surface that is seen from behind has its normals turned round. Where the bent normal would
//! look away from the eye it is raised until it just does not. What is below the surface itself is not lit from there and
//! nothing is scattered to it: that light is lost, as it is with everybody's normal maps.

use super::fetch::Surfaces;
use super::texel::{is_some, textured};
use crate::maths::vec3::Vec3x8;
use crate::tracer::scene::{Scattering, SceneData};
use wide::{f32x8, u32x8};

/// Least cosine between the eye and a normal that was bent.
const LEAST_COSINE: f32 = 0.01;

/// Eight triangles where rays meet them.
pub(super) struct Bend<'a> {
    pub corners: &'a [Vec3x8; 3],
    pub surface: &'a Surfaces,
    pub weights: [f32x8; 3],
    /// Kinds of scattering, as numbers.
    pub scattering: u32x8,
    /// Unit geometric normals of the front.
    pub front: Vec3x8,
    /// Directions of the rays.
    pub direction: Vec3x8,
}

impl Bend<'_> {
    /// Unit shading `normal`s on the side the ray came from, bent by the materials' maps. Kept out of the loops that call it.
    #[inline(never)]
    pub fn apply(&self, data: &SceneData<'_>, normal: Vec3x8) -> Vec3x8 {
        let map = u32x8::from(self.surface.material.map(|material| data.normal_maps[material as usize]));
        let rough: f32x8 = bytemuck::cast(self.scattering.simd_eq(u32x8::splat(Scattering::Rough as u32)));
        let bent = is_some(map) & rough;
        if !bent.any() {
            return normal;
        }
        let texel = textured(data, map, self.surface.coordinates(self.weights));
        let behind = normal.dot(self.front).simd_lt(f32x8::ZERO);
        let upright = Vec3x8::select(behind, -normal, normal);
        let (tangent, bitangent) = self.tangents(data, map, upright);
        let sum = tangent * texel.x + bitangent * texel.y + upright * texel.z;
        let value = raised(Vec3x8::select(behind, -sum, sum), -self.direction);
        // Coordinates that do not span the triangle, and texels without a direction.
        let sound = bent & value.dot(value).simd_gt(f32x8::HALF);
        Vec3x8::select(sound, value, normal)
    }

    /// Unit vectors orthogonal to `upright` and to each other along which the texture's u and v grow.
    fn tangents(&self, data: &SceneData<'_>, map: u32x8, upright: Vec3x8) -> (Vec3x8, Vec3x8) {
        let [a, b, c] = *self.corners;
        let [at, of_b, of_c] = self.surface.uv;
        let (du, dv) = ((of_b.0 - at.0, of_c.0 - at.0), (of_b.1 - at.1, of_c.1 - at.1));
        // The way of u, but for the length, which does not count, and for the sign, which does.
        let turns = du.0 * dv.1 - du.1 * dv.0;
        let along = ((b - a) * dv.1 - (c - a) * dv.0) * f32x8::ONE.copysign(turns);
        let tangent = (along - upright * upright.dot(along)).normalized();
        let bitangent = upright.cross(tangent) * f32x8::ONE.copysign(turns);
        // A texture that lies mirrored.
        let sign = |axis: usize| {
            let of =
                |map: u32| data.textures.get(map as usize).map_or(1.0, |t| 1.0f32.copysign(t.scale[axis]));
            f32x8::from(map.to_array().map(of))
        };
        (tangent * sign(0), bitangent * sign(1))
    }
}

/// The unit vector of `v`, or the nearest one that `eye`, a unit vector, sees.
#[inline(always)]
fn raised(v: Vec3x8, eye: Vec3x8) -> Vec3x8 {
    let unit = v.normalized();
    let least = f32x8::splat(LEAST_COSINE);
    let cosine = unit.dot(eye);
    let across = (unit - eye * cosine).normalized();
    let high = across * f32x8::splat(libm::sqrtf(1.0 - LEAST_COSINE * LEAST_COSINE)) + eye * least;
    Vec3x8::select(cosine.simd_lt(least), high, unit)
}

#[cfg(test)]
mod tests;
