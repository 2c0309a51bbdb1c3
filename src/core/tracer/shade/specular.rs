//! Perfect mirrors and smooth dielectrics.

use super::hit::SurfacePoints;
use crate::maths::vec3::Vec3x8;
use wide::f32x8;

/// A direction, what it carries, and how radiance was squeezed by passing into the denser medium.
pub(super) struct Scattered {
    /// Unit direction away from the surface.
    pub direction: Vec3x8,
    /// Throughput of the choice.
    pub weight: Vec3x8,
    /// Factor of the squared index ratio that `weight` has picked up; 1 for a reflection.
    pub compression: f32x8,
}

/// Reflects `direction` (towards the surface) at `normal`.
#[inline(always)]
pub(super) fn reflect(direction: Vec3x8, normal: Vec3x8) -> Vec3x8 {
    direction - normal * (f32x8::splat(2.0) * direction.dot(normal))
}

/// A smooth dielectric: reflects where `choice`, uniform in `[0, 1)`, is below the Fresnel reflectance, refracts
/// elsewhere. Radiance scales with the squared ratio of indices (Veach 1997, section 5.2).
#[inline]
pub(super) fn dielectric(surface: &SurfacePoints, direction: Vec3x8, choice: f32x8) -> Scattered {
    let one = f32x8::ONE;
    let entering = surface.cosine.simd_gt(f32x8::ZERO);
    // Index on the side of the ray over index on the far side.
    let eta = entering.select(one / surface.ior, surface.ior);
    let normal = surface.normal;
    let cos_in = (-direction.dot(normal)).fast_min(one).fast_max(f32x8::ZERO);
    let cos2_out = one - eta * eta * (one - cos_in * cos_in);
    let cos_out = cos2_out.fast_max(f32x8::ZERO).sqrt();
    let reflectance = cos2_out.simd_gt(f32x8::ZERO).select(fresnel(cos_in, cos_out, eta), one);
    let reflects = choice.simd_lt(reflectance);
    let refracted = (direction * eta + normal * (eta * cos_in - cos_out)).normalized();
    let compression = reflects.select(one, eta * eta);
    Scattered {
        direction: Vec3x8::select(reflects, reflect(direction, normal), refracted),
        weight: surface.specular * compression,
        compression,
    }
}

/// Unpolarised Fresnel reflectance of a dielectric, `eta` = index in over index out.
#[inline(always)]
fn fresnel(cos_in: f32x8, cos_out: f32x8, eta: f32x8) -> f32x8 {
    let parallel = (cos_in - eta * cos_out) / (cos_in + eta * cos_out);
    let perpendicular = (eta * cos_in - cos_out) / (eta * cos_in + cos_out);
    f32x8::HALF * (parallel * parallel + perpendicular * perpendicular)
}

#[cfg(test)]
mod tests;
