//! The pinhole camera: film positions to primary rays.

use crate::maths::vec3::{self, Vec3x8};
use wide::f32x8;

/// Why a camera cannot be made.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// A coordinate is not finite.
    NotFinite,
    /// The camera stands where it looks at.
    NoDirection,
    /// `up` is zero or parallel to the viewing direction.
    NoUp,
    /// The field of view is not between 0 and 180 degrees.
    FieldOfView,
    /// The film has no pixels.
    NoPixels,
}

impl core::fmt::Display for Error {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Error::NotFinite => "a coordinate of the camera is not finite",
            Error::NoDirection => "the camera's position and target are the same point",
            Error::NoUp => "the camera's up vector is zero or parallel to the viewing direction",
            Error::FieldOfView => "the field of view must lie between 0 and 180 degrees",
            Error::NoPixels => "the film must be at least 1x1",
        })
    }
}

impl core::error::Error for Error {}

/// A pinhole camera with square pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    origin: [f32; 3],
    /// Towards the film's upper left corner, at distance one along the viewing direction.
    corner: [f32; 3],
    /// From a pixel to its right neighbour on that film.
    right: [f32; 3],
    /// From a pixel to its lower neighbour.
    down: [f32; 3],
}

impl Camera {
    /// A camera at `from` that looks towards `at`, `up` pointing to the upper edge of the picture.
    ///
    /// `vertical_fov` is the angle between the film's lower and upper edge, in degrees.
    ///
    /// # Errors
    /// When the view is not defined: see [`Error`].
    pub fn new(
        from: [f32; 3],
        at: [f32; 3],
        up: [f32; 3],
        vertical_fov: f32,
        width: u32,
        height: u32,
    ) -> Result<Self, Error> {
        if !from.iter().chain(&at).chain(&up).all(|v| v.is_finite()) {
            return Err(Error::NotFinite);
        }
        if !(vertical_fov > 0.0 && vertical_fov < 180.0) {
            return Err(Error::FieldOfView);
        }
        if width == 0 || height == 0 {
            return Err(Error::NoPixels);
        }
        let forward = vec3::normalized(vec3::sub(at, from)).ok_or(Error::NoDirection)?;
        let upward = vec3::normalized(up).ok_or(Error::NoUp)?;
        let right = vec3::cross(forward, upward);
        if vec3::dot(right, right) < 1e-10 {
            return Err(Error::NoUp);
        }
        let right = vec3::normalized(right).ok_or(Error::NoUp)?;
        let down = vec3::cross(forward, right);
        let pixel = 2.0 * libm::tanf(vertical_fov.to_radians() * 0.5) / height as f32;
        let (half_width, half_height) = (0.5 * width as f32 * pixel, 0.5 * height as f32 * pixel);
        let corner =
            vec3::sub(vec3::sub(forward, vec3::scale(right, half_width)), vec3::scale(down, half_height));
        Ok(Camera { origin: from, corner, right: vec3::scale(right, pixel), down: vec3::scale(down, pixel) })
    }

    /// Where the camera stands.
    pub fn origin(&self) -> [f32; 3] {
        self.origin
    }

    /// Unit directions of the rays through film positions `x`, `y` in pixels from the upper left corner.
    #[inline]
    pub fn directions(&self, x: f32x8, y: f32x8) -> Vec3x8 {
        let film = Vec3x8::splat(self.right) * x + Vec3x8::splat(self.down) * y;
        (Vec3x8::splat(self.corner) + film).normalized()
    }

    /// The film position, in pixels from the upper left corner, of what lies in a direction from the origin.
    ///
    /// The inverse of [`directions`](Self::directions). `direction` has any length; the position may lie outside of the
    /// film. None for what is beside or behind the camera.
    pub fn project(&self, direction: [f32; 3]) -> Option<[f32; 2]> {
        let axes = [self.right, self.down];
        // The corner, by pixels along the film's axes; what remains of it looks along the view.
        let corner = axes.map(|axis| vec3::dot(self.corner, axis) / vec3::dot(axis, axis));
        let [along_x, along_y] = [0, 1].map(|i| vec3::scale(axes[i], corner[i]));
        let forward = vec3::sub(vec3::sub(self.corner, along_x), along_y);
        let depth = vec3::dot(direction, forward);
        let film =
            |i: usize| vec3::dot(direction, axes[i]) / (vec3::dot(axes[i], axes[i]) * depth) - corner[i];
        let position = [film(0), film(1)];
        (depth > 0.0 && position.iter().all(|v| v.is_finite())).then_some(position)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn picture_axes_point_right_and_down() {
        let camera = Camera::new([0.0; 3], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0], 90.0, 4, 2).unwrap();
        let d = camera.directions(f32x8::splat(4.0), f32x8::splat(0.0));
        let d = [d.x.to_array()[0], d.y.to_array()[0], d.z.to_array()[0]];
        let expected = 1.0 / 6.0_f32.sqrt();
        assert!((d[0] - 2.0 * expected).abs() < 1e-6, "{d:?}");
        assert!((d[1] - expected).abs() < 1e-6, "{d:?}");
        assert!((d[2] + expected).abs() < 1e-6, "{d:?}");
    }

    #[test]
    fn projection_undoes_directions() {
        let camera =
            Camera::new([3.0, -2.0, 5.0], [0.5, 1.0, -1.0], [0.1, 1.0, 0.2], 50.0, 320, 200).unwrap();
        for i in 0..64 {
            let (x, y) = (5.0 * i as f32 - 3.3, 3.0 * i as f32 + 1.7);
            let d = camera.directions(f32x8::splat(x), f32x8::splat(y));
            let d = [d.x, d.y, d.z].map(|v| 7.5 * v.to_array()[0]);
            let [u, v] = camera.project(d).unwrap();
            assert!((u - x).abs() < 1e-3 && (v - y).abs() < 1e-3, "{u} {v}, not {x} {y}");
            assert_eq!(camera.project(d.map(|v| -v)), None);
        }
        assert_eq!(camera.project([0.0; 3]), None);
        assert_eq!(camera.project([f32::NAN; 3]), None);
    }

    #[test]
    fn undefined_views_are_refused() {
        let up = [0.0, 1.0, 0.0];
        let at = [0.0, 0.0, -1.0];
        assert_eq!(Camera::new(at, at, up, 40.0, 1, 1), Err(Error::NoDirection));
        assert_eq!(Camera::new([0.0; 3], up, up, 40.0, 1, 1), Err(Error::NoUp));
        assert_eq!(Camera::new([0.0; 3], at, up, 180.0, 1, 1), Err(Error::FieldOfView));
        assert_eq!(Camera::new([0.0; 3], at, up, 40.0, 0, 1), Err(Error::NoPixels));
        assert_eq!(Camera::new([f32::NAN; 3], at, up, 40.0, 1, 1), Err(Error::NotFinite));
    }
}
