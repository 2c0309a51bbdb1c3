//! Three-dimensional vectors, eight at a time.

use core::ops::{Add, Mul, Neg, Sub};
use wide::f32x8;

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
