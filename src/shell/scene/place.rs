//! Where a mesh stands: scale, then rotation, then translation.

use glam::{Mat3, Quat, Vec3};

/// An affine map of positions and normals.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    linear: Mat3,
    normals: Mat3,
    translation: Vec3,
    mirrored: bool,
}

impl Placement {
    /// Leaves everything where it is.
    pub const IDENTITY: Placement = Placement {
        linear: Mat3::IDENTITY,
        normals: Mat3::IDENTITY,
        translation: Vec3::ZERO,
        mirrored: false,
    };

    /// Scales by `scale` (no factor 0), turns about the fixed x, y and z axis in this order by `degrees`, moves.
    pub fn new(scale: Vec3, degrees: Vec3, translation: Vec3) -> Placement {
        let turn = |axis, angle: f32| Quat::from_axis_angle(axis, angle.to_radians());
        let rotation = turn(Vec3::Z, degrees.z) * turn(Vec3::Y, degrees.y) * turn(Vec3::X, degrees.x);
        let rotation = Mat3::from_quat(rotation);
        Placement {
            linear: rotation * Mat3::from_diagonal(scale),
            normals: rotation * Mat3::from_diagonal(scale.recip()),
            translation,
            mirrored: scale.x * scale.y * scale.z < 0.0,
        }
    }

    /// Whether it turns counter-clockwise corners into clockwise ones.
    pub fn is_mirrored(&self) -> bool {
        self.mirrored
    }

    /// Where a point goes.
    pub fn position(&self, p: Vec3) -> Vec3 {
        self.linear * p + self.translation
    }

    /// Where a normal points, by the inverse transpose; not of unit length.
    pub fn normal(&self, n: Vec3) -> Vec3 {
        self.normals * n
    }
}
