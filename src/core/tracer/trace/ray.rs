//! Packets of rays and hits.

use crate::maths::vec3::Vec3x8;
use wide::{f32x8, u32x8};

/// [`Hits8::triangle`] of a lane that hit nothing.
pub const MISS: u32 = u32::MAX;

/// Eight rays, structure of arrays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rays8 {
    /// Origins, in scene units.
    pub origin: Vec3x8,
    /// Directions, unit vectors.
    pub direction: Vec3x8,
    /// Distance at which a ray ends, in scene units; negative: the lane is idle.
    pub t_max: f32x8,
    /// When the ray is, as a part of the time in which the shutter is open, 0 to 1; of no use where nothing moves.
    pub time: f32x8,
}

impl Rays8 {
    /// The lanes that take part, as bits.
    #[inline(always)]
    pub fn active(&self) -> u32 {
        self.t_max.simd_ge(f32x8::ZERO).to_bitmask()
    }
}

/// What eight rays hit, structure of arrays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hits8 {
    /// Distance, in scene units; the ray's `t_max` where nothing was hit.
    pub t: f32x8,
    /// Barycentric weight of the triangle's second corner.
    pub u: f32x8,
    /// Barycentric weight of the triangle's third corner.
    pub v: f32x8,
    /// Index of the triangle, or [`MISS`].
    pub triangle: u32x8,
}

/// What one ray hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    pub t: f32,
    pub u: f32,
    pub v: f32,
    pub triangle: u32,
}

/// For boxes: one over the direction, with zeros replaced by something tiny, and the origin times that, by axis.
#[derive(Clone, Copy)]
pub(super) struct Slopes {
    pub inverse: [f32x8; 3],
    pub offset: [f32x8; 3],
}

/// For triangles: a frame whose third axis is the ray.
#[derive(Clone, Copy)]
pub(super) struct Frames {
    /// Rows of the rotation that maps the direction to the third axis.
    pub axes: [Vec3x8; 3],
    /// The origin in that frame.
    pub origin: [f32x8; 3],
}

/// What is computed once for a packet.
pub(super) struct Prepared {
    pub slopes: Slopes,
    pub frames: Frames,
    pub time: f32x8,
}

impl Prepared {
    #[inline(always)]
    pub fn new(rays: &Rays8) -> Self {
        let d = rays.direction;
        let inverse = [d.x, d.y, d.z].map(safe_inverse);
        let o = rays.origin;
        let (u, v) = perpendicular(d);
        Prepared {
            slopes: Slopes { inverse, offset: [o.x * inverse[0], o.y * inverse[1], o.z * inverse[2]] },
            frames: Frames { axes: [u, v, d], origin: [dot(u, o), dot(v, o), dot(d, o)] },
            time: rays.time,
        }
    }
}

/// The number of one lane, in all lanes. By reference: a copy would go through memory before one of its lanes is read.
#[inline(always)]
pub(super) fn one(v: &f32x8, lane: usize) -> f32x8 {
    f32x8::splat(v.as_array()[lane & 7])
}

impl Frames {
    /// The frame of one lane, in all lanes.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Self {
        let vector = |v: &Vec3x8| Vec3x8::new(one(&v.x, lane), one(&v.y, lane), one(&v.z, lane));
        Frames {
            axes: self.axes.each_ref().map(vector),
            origin: self.origin.each_ref().map(|v| one(v, lane)),
        }
    }
}

impl Slopes {
    /// The slopes of one lane, in all lanes.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Self {
        let each = |v: &[f32x8; 3]| v.each_ref().map(|v| one(v, lane));
        Slopes { inverse: each(&self.inverse), offset: each(&self.offset) }
    }

    /// The signs that all taking part share, by axis: `Some(true)` where every direction is negative.
    #[inline(always)]
    pub fn common_signs(&self, active: u32) -> Option<[bool; 3]> {
        let mut signs = [false; 3];
        for (sign, inverse) in signs.iter_mut().zip(&self.inverse) {
            let negative = inverse.to_bitmask() & active;
            if negative != 0 && negative != active {
                return None;
            }
            *sign = negative != 0;
        }
        Some(signs)
    }
}

/// `1/x` with |x| kept above 1e-18, so that no product with a coordinate overflows to NaN.
#[inline(always)]
fn safe_inverse(x: f32x8) -> f32x8 {
    let tiny = f32x8::splat(1e-18);
    let kept = x.abs().simd_lt(tiny).select(tiny.copysign(x), x);
    f32x8::ONE / kept
}

/// Two unit vectors that form an orthonormal basis with the unit vector `n`.
///
/// Duff et al., *Building an Orthonormal Basis, Revisited*, JCGT 6(1), 2017.
#[inline(always)]
pub(crate) fn perpendicular(n: Vec3x8) -> (Vec3x8, Vec3x8) {
    let one = f32x8::ONE;
    let sign = one.copysign(n.z);
    let a = -one / (sign + n.z);
    let b = n.x * n.y * a;
    (
        Vec3x8::new(one + sign * n.x * n.x * a, sign * b, -sign * n.x),
        Vec3x8::new(b, sign + n.y * n.y * a, -n.y),
    )
}

/// The scalar product in the order of operations that the triangle test uses for corners.
#[inline(always)]
pub(super) fn dot(a: Vec3x8, b: Vec3x8) -> f32x8 {
    a.x.mul_add(b.x, a.y.mul_add(b.y, a.z * b.z))
}
