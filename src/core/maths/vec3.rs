//! Three-dimensional vectors, eight at a time.

use core::ops::{Add, Mul, Neg, Sub};
use wide::{f32x8, u32x8};

/// Eight three-dimensional vectors, structure of arrays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vec3x8 {
    /// First components.
    pub x: f32x8,
    /// Second components.
    pub y: f32x8,
    /// Third components.
    pub z: f32x8,
}

impl From<Vec3x8> for [f32x8; 3] {
    #[inline(always)]
    fn from(v: Vec3x8) -> Self {
        [v.x, v.y, v.z]
    }
}

impl Vec3x8 {
    /// From components.
    #[inline(always)]
    pub const fn new(x: f32x8, y: f32x8, z: f32x8) -> Self {
        Vec3x8 { x, y, z }
    }

    /// The same vector in every lane.
    #[inline(always)]
    pub fn splat(v: [f32; 3]) -> Self {
        Vec3x8::new(f32x8::splat(v[0]), f32x8::splat(v[1]), f32x8::splat(v[2]))
    }

    /// The vector of one lane, 0 to 7, in every lane.
    #[inline(always)]
    pub fn lane(self, lane: usize) -> Self {
        Vec3x8::splat([self.x, self.y, self.z].map(|v| v.to_array()[lane & 7]))
    }

    /// Scalar product.
    #[inline(always)]
    pub fn dot(self, o: Self) -> f32x8 {
        self.x * o.x + self.y * o.y + self.z * o.z
    }

    /// Vector product.
    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        Vec3x8::new(self.y * o.z - self.z * o.y, self.z * o.x - self.x * o.z, self.x * o.y - self.y * o.x)
    }

    /// Length.
    #[inline(always)]
    pub fn length(self) -> f32x8 {
        self.dot(self).sqrt()
    }

    /// The vector divided by its length. Not finite where the length is 0.
    #[inline(always)]
    pub fn normalized(self) -> Self {
        self * (f32x8::ONE / self.length())
    }

    /// `a` where the mask's bits are set, `b` elsewhere.
    #[inline(always)]
    pub fn select(mask: f32x8, a: Self, b: Self) -> Self {
        Vec3x8::new(mask.bitselect(a.x, b.x), mask.bitselect(a.y, b.y), mask.bitselect(a.z, b.z))
    }

    /// Componentwise product.
    #[inline(always)]
    pub fn scaled(self, o: Self) -> Self {
        Vec3x8::new(self.x * o.x, self.y * o.y, self.z * o.z)
    }

    /// Largest component.
    #[inline(always)]
    pub fn max_component(self) -> f32x8 {
        self.x.fast_max(self.y).fast_max(self.z)
    }
}

impl Add for Vec3x8 {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Vec3x8::new(self.x + o.x, self.y + o.y, self.z + o.z)
    }
}

impl Sub for Vec3x8 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Vec3x8::new(self.x - o.x, self.y - o.y, self.z - o.z)
    }
}

impl Mul<f32x8> for Vec3x8 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: f32x8) -> Self {
        Vec3x8::new(self.x * s, self.y * s, self.z * s)
    }
}

impl Neg for Vec3x8 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Vec3x8::new(-self.x, -self.y, -self.z)
    }
}

/// Largest value of a coordinate of [`pack_unit`].
const PACKED_MAX: f32 = 65_534.0;

/// Unit vectors in 32 bits each, off by less than 1e-4: the octahedron around them, unfolded to a square (Cigolle et
/// al., *Survey of Efficient Representations for Independent Unit Vectors*, JCGT 3(2), 2014).
#[inline(always)]
pub(crate) fn pack_unit(v: Vec3x8) -> u32x8 {
    let one = f32x8::ONE;
    let scale = one / (v.x.abs() + v.y.abs() + v.z.abs());
    let (x, y) = (v.x * scale, v.y * scale);
    let below = v.z.simd_lt(f32x8::ZERO);
    let folded = below.select((one - y.abs()).copysign(x), x);
    let other = below.select((one - x.abs()).copysign(y), y);
    let whole = |c: f32x8| {
        let level = (c + one) * f32x8::splat(0.5 * PACKED_MAX) + f32x8::HALF;
        bytemuck::cast::<_, u32x8>(level.fast_trunc_int())
    };
    whole(folded) | whole(other) << 16
}

/// Inverse of [`pack_unit`].
#[inline(always)]
pub(crate) fn unpack_unit(bits: u32x8) -> Vec3x8 {
    let one = f32x8::ONE;
    let level = |bits: u32x8| f32x8::from_i32x8(bytemuck::cast(bits)) * f32x8::splat(2.0 / PACKED_MAX) - one;
    let (x, y) = (level(bits & u32x8::splat(0xffff)), level(bits >> 16));
    let z = one - x.abs() - y.abs();
    let fold = (-z).fast_max(f32x8::ZERO);
    Vec3x8::new(x - fold.copysign(x), y - fold.copysign(y), z).normalized()
}

/// `a − b`.
pub(crate) fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a · s`.
pub(crate) fn scale(a: [f32; 3], s: f32) -> [f32; 3] {
    a.map(|v| v * s)
}

/// Scalar product.
pub(crate) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Vector product.
pub(crate) fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The unit vector along `a`; none where `a` is zero.
pub(crate) fn normalized(a: [f32; 3]) -> Option<[f32; 3]> {
    let length = libm::sqrtf(dot(a, a));
    (length > 0.0 && length.is_finite()).then(|| scale(a, 1.0 / length))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_unit_vectors_point_where_they_did() {
        let mut worst = 0.0f32;
        for i in 0..2000 {
            // A spiral over the sphere.
            let z = 1.0 - (i as f32 + 0.5) / 1000.0;
            let (r, turn) = (libm::sqrtf(1.0 - z * z), 2.4 * i as f32);
            let v = Vec3x8::splat([r * libm::cosf(turn), r * libm::sinf(turn), z]);
            worst = worst.max((unpack_unit(pack_unit(v)) - v).length().to_array()[3]);
        }
        assert!(worst < 1e-4, "{worst}");
        for axis in [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]] {
            assert!(
                (unpack_unit(pack_unit(Vec3x8::splat(axis))) - Vec3x8::splat(axis)).length().to_array()[0]
                    < 1e-4
            );
        }
    }
}
