//! Where an object stands: scale, then rotation, then translation.

use glam::{DAffine3, DMat3, DVec3, Mat3, Quat, Vec3};

/// An affine map of an object's own positions and normals into the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    linear: Mat3,
    normals: Mat3,
    translation: DVec3,
    mirrored: bool,
}

impl Placement {
    /// Leaves everything where it is.
    pub const IDENTITY: Placement = Placement {
        linear: Mat3::IDENTITY,
        normals: Mat3::IDENTITY,
        translation: DVec3::ZERO,
        mirrored: false,
    };

    /// Scales by `scale` (no factor 0), turns, moves.
    pub(super) fn new(scale: Vec3, rotation: Quat, translation: DVec3) -> Placement {
        let rotation = Mat3::from_quat(rotation);
        Placement {
            linear: rotation * Mat3::from_diagonal(scale),
            normals: rotation * Mat3::from_diagonal(scale.recip()),
            translation,
            mirrored: scale.x * scale.y * scale.z < 0.0,
        }
    }

    /// The affine map itself, which may flatten.
    pub(super) fn affine(map: DAffine3) -> Placement {
        let linear = map.matrix3.as_mat3();
        let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
        // Cofactors are the inverse transpose times the determinant, and there are some where that is 0.
        let cofactors = Mat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
        let mirrored = x.dot(y.cross(z)) < 0.0;
        let normals = if mirrored { -cofactors } else { cofactors };
        Placement { linear, normals, translation: map.translation, mirrored }
    }

    /// Makes the unit sphere one of this centre and radius.
    pub(super) fn sphere(center: DVec3, radius: f32) -> Placement {
        Placement { linear: Mat3::from_diagonal(Vec3::splat(radius)), translation: center, ..Self::IDENTITY }
    }

    /// Makes the square of corners (±1, ±1, 0) the rectangle of half edges `u` and `v`, which must not be parallel.
    pub(super) fn rectangle(center: DVec3, u: Vec3, v: Vec3) -> Placement {
        let normal = u.cross(v).normalize();
        let linear = Mat3::from_cols(u, v, normal);
        Placement { linear, normals: linear.inverse().transpose(), translation: center, mirrored: false }
    }

    /// The same for an object whose coordinates begin at `home`, into a scene whose coordinates begin at `origin`.
    pub(super) fn seated(&self, home: DVec3, origin: DVec3) -> Placement {
        let linear = DMat3::from_cols_array(&self.linear.to_cols_array().map(f64::from));
        Placement { translation: linear * home + self.translation - origin, ..*self }
    }

    /// Where a point goes, in double precision.
    pub(super) fn exact(&self, p: Vec3) -> DVec3 {
        (self.linear * p).as_dvec3() + self.translation
    }

    /// Whether it turns counter-clockwise corners into clockwise ones.
    pub(super) fn is_mirrored(&self) -> bool {
        self.mirrored
    }

    /// Where a point goes.
    pub fn position(&self, p: Vec3) -> Vec3 {
        self.linear * p + self.translation.as_vec3()
    }

    /// Where a normal points, by the inverse transpose; not of unit length.
    pub(super) fn normal(&self, n: Vec3) -> Vec3 {
        self.normals * n
    }

    /// The affine map from where this puts an object to where `other` puts it.
    pub fn towards(&self, other: &Placement) -> Shift {
        if self == other {
            return Shift { linear: Mat3::IDENTITY, from: Vec3::ZERO, to: Vec3::ZERO };
        }
        Shift {
            linear: other.linear * self.linear.inverse(),
            from: self.translation.as_vec3(),
            to: other.translation.as_vec3(),
        }
    }
}

/// How far an object's points move from one placement to another; exactly nowhere between equal ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shift {
    linear: Mat3,
    from: Vec3,
    to: Vec3,
}

impl Shift {
    /// Where a point of the scene goes.
    pub fn position(&self, p: Vec3) -> Vec3 {
        self.linear * (p - self.from) + self.to
    }
}
