//! Lambertian reflection plus a GGX lobe with Schlick Fresnel, and how both are sampled.
//!
//! The lobe is Walter et al. 2007 with the height-correlated Smith term (Heitz 2014); half vectors are drawn from
//! the visible normals by spherical caps (Dupuy and Benyoub 2023). Directions are in the local frame, the shading
//! normal along z, and point away from the surface.
//!
//! A narrow lobe lives in the half vector's tangential part. Between two given directions value and density are exact
//! to 2e-6 at any width: parts that nearly cancel do so without rounding. What limits the width is the rounding of the
//! directions, which moves a sampled half vector by about 3e-8 over the cosine of the view: at
//! [`MIN_ROUGHNESS`](crate::tracer::scene::MIN_ROUGHNESS) the lobe's shape is grained by some percent seen from above, by its own
//! width at grazing angles. It is the same number in value and density, so that a sampled direction carries Fresnel
//! times shadowing all the same.

use super::hit::SurfacePoints;
use crate::maths::colour::luminance8;
use crate::maths::functions;
use crate::maths::vec3::Vec3x8;
use wide::f32x8;

const FRAC_1_PI: f32 = core::f32::consts::FRAC_1_PI;

/// Eight rough surface points, seen from `outgoing`.
pub(super) struct Rough {
    diffuse: Vec3x8,
    specular: Vec3x8,
    alpha2: f32x8,
    alpha: f32x8,
    outgoing: Vec3x8,
    /// Probability of sampling the lobe.
    lobe: f32x8,
    /// Whether any lane has a lobe at all.
    has_lobe: bool,
}

impl Rough {
    #[inline]
    pub fn new(surface: &SurfacePoints, outgoing: Vec3x8) -> Self {
        let has_lobe = surface.specular.max_component().simd_gt(f32x8::ZERO).any();
        let mut lobe = f32x8::ZERO;
        if has_lobe {
            let reflected = luminance8(schlick(surface.specular, outgoing.z).into());
            let total = reflected + luminance8(surface.diffuse.into());
            let any = luminance8(surface.specular.into()).simd_gt(f32x8::ZERO);
            lobe = any.select(reflected / total, f32x8::ZERO);
        }
        let alpha = surface.roughness;
        Rough {
            diffuse: surface.diffuse,
            specular: surface.specular,
            alpha2: alpha * alpha,
            alpha,
            outgoing,
            lobe,
            has_lobe,
        }
    }

    /// One lane's point in all lanes.
    #[inline]
    pub fn lane(&self, lane: usize) -> Self {
        let splat = |v: f32x8| f32x8::splat(v.to_array()[lane & 7]);
        let specular = self.specular.lane(lane);
        Rough {
            diffuse: self.diffuse.lane(lane),
            specular,
            alpha2: splat(self.alpha2),
            alpha: splat(self.alpha),
            outgoing: self.outgoing.lane(lane),
            lobe: splat(self.lobe),
            has_lobe: self.has_lobe && specular.max_component().simd_gt(f32x8::ZERO).any(),
        }
    }

    /// The scattering function times the cosine, and the density [`sample`](Self::sample) has, for `incoming`.
    /// Both zero below the horizon.
    #[inline]
    pub fn evaluate(&self, incoming: Vec3x8) -> (Vec3x8, f32x8) {
        let above = incoming.z.simd_gt(f32x8::ZERO) & self.outgoing.z.simd_gt(f32x8::ZERO);
        let cosine = (incoming.z * f32x8::splat(FRAC_1_PI)) & above;
        let (mut value, mut density) = (self.diffuse * cosine, cosine);
        if self.has_lobe {
            // Schlick's reflectance reaches 1 even where `specular` is 0: a lane without a lobe must not get one from
            // the others of its packet.
            let above = above & self.lobe.simd_gt(f32x8::ZERO);
            let (lobe_value, lobe_density) = self.lobe(incoming);
            value = value + Vec3x8::select(above, lobe_value, Vec3x8::default());
            density = density * (f32x8::ONE - self.lobe) + ((lobe_density * self.lobe) & above);
        }
        (value, density)
    }

    /// A direction for uniform numbers `u`, `v` and, where there is a choice of parts to make, `part`.
    #[inline]
    pub fn sample(&self, u: f32x8, v: f32x8, part: impl FnOnce() -> f32x8) -> Vec3x8 {
        let diffuse = cosine_direction(u, v);
        if !self.has_lobe {
            return diffuse;
        }
        let half = self.visible_normal(u, v);
        let reflected = half * (f32x8::splat(2.0) * self.outgoing.dot(half)) - self.outgoing;
        Vec3x8::select(part().simd_lt(self.lobe), reflected, diffuse)
    }

    /// Value times cosine and density of the lobe.
    #[inline]
    fn lobe(&self, incoming: Vec3x8) -> (Vec3x8, f32x8) {
        let half = (self.outgoing + incoming).normalized();
        let (o, i) = (self.outgoing.z, incoming.z);
        // sin² + α² cos² of the half vector, without the cancellation of 1 − (1 − α²) cos².
        let base = half.x * half.x + half.y * half.y + self.alpha2 * half.z * half.z;
        let distribution = self.alpha2 * f32x8::splat(FRAC_1_PI) / (base * base);
        let (o_root, i_root) = (self.smith(o), self.smith(i));
        let fresnel = schlick(self.specular, self.outgoing.dot(half));
        let geometry = f32x8::HALF / (i * o_root + o * i_root);
        let density = distribution * f32x8::HALF / (o + o_root);
        (fresnel * (distribution * geometry * i), density)
    }

    /// √(α² + (1 − α²) cos²), the root in Smith's shadowing.
    #[inline(always)]
    fn smith(&self, cosine: f32x8) -> f32x8 {
        (self.alpha2 + (f32x8::ONE - self.alpha2) * cosine * cosine).sqrt()
    }

    #[inline]
    fn visible_normal(&self, u: f32x8, v: f32x8) -> Vec3x8 {
        let stretch = |d: Vec3x8| Vec3x8::new(d.x * self.alpha, d.y * self.alpha, d.z).normalized();
        let view = stretch(self.outgoing);
        let (sin, cos) = functions::sin_cos_turn(u);
        let z = (f32x8::ONE - v) * (f32x8::ONE + view.z) - view.z;
        let radius = (f32x8::ONE - z * z).fast_max(f32x8::ZERO).sqrt();
        stretch(Vec3x8::new(radius * cos, radius * sin, z) + view)
    }
}

/// Schlick's Fresnel reflectance.
#[inline(always)]
fn schlick(normal: Vec3x8, cosine: f32x8) -> Vec3x8 {
    let one = f32x8::ONE;
    let m = (one - cosine).fast_max(f32x8::ZERO);
    let m5 = (m * m) * (m * m) * m;
    let rest = Vec3x8::new(one - normal.x, one - normal.y, one - normal.z);
    normal + rest * m5
}

/// A direction whose density is cosine over π: a point of the unit disk (Shirley and Chiu 1997), lifted.
#[inline]
pub(super) fn cosine_direction(u: f32x8, v: f32x8) -> Vec3x8 {
    let (two, one) = (f32x8::splat(2.0), f32x8::ONE);
    let (a, b) = (u * two - one, v * two - one);
    let wide = a.abs().simd_gt(b.abs());
    let (radius, other) = (wide.select(a, b), wide.select(b, a));
    let ratio = radius.abs().simd_gt(f32x8::ZERO).select(other / radius, f32x8::ZERO);
    let (sin, cos) = functions::sin_cos_turn(ratio * f32x8::splat(0.125));
    let (x, y) = (wide.select(cos, sin) * radius, wide.select(sin, cos) * radius);
    Vec3x8::new(x, y, (one - x * x - y * y).fast_max(f32x8::ZERO).sqrt())
}

#[cfg(test)]
mod tests;
