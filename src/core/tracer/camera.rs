//! The camera: film positions to primary rays, through a pinhole or a thin lens, while it stands or moves.
//!
//! The lens is that of Cook, Porter and Carpenter, *Distributed Ray Tracing*, SIGGRAPH 1984: all rays through a film position
//! meet in the plane of focus. A camera that moves while its shutter is open is somewhere on the straight way between two
//! places for each sample, its film likewise.

use crate::maths::functions::sin_cos_turn;
use crate::maths::sobol;
use crate::maths::vec3::{self, Vec3x8};
use crate::sampler::batch::Batch8;
use wide::{f32x8, u32x8};

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
    /// The lens is not finite or has a negative diameter, or the plane of focus is not before the camera.
    Lens,
}

impl core::fmt::Display for Error {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Error::NotFinite => "a coordinate of the camera is not finite",
            Error::NoDirection => "the camera's position and target are the same point",
            Error::NoUp => "the camera's up vector is zero or parallel to the viewing direction",
            Error::FieldOfView => "the field of view must lie between 0 and 180 degrees",
            Error::Lens => "the aperture must be 0 or more and the distance in focus above 0",
            Error::NoPixels => "the film must be at least 1x1",
        })
    }
}

impl core::error::Error for Error {}

/// Set of the points on the lens, and of the times: beyond those that paths use.
const LENS_SET: u32 = u32::MAX;
const TIME_SET: u32 = u32::MAX - 1;

/// When eight samples are, as parts of the time in which the shutter is open.
#[inline(never)]
pub(super) fn time(index: u32x8, key: u32x8) -> f32x8 {
    sobol::point(index, key, TIME_SET).0
}

/// A camera with square pixels: a pinhole, unless it is [given a lens](Self::with_lens).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    film: Film,
    /// Where it is when the shutter closes, if it moves.
    end: Option<Film>,
    /// Radius of the lens, 0 for a pinhole, and the distance in focus along the view.
    lens: f32,
    focus: f32,
}

/// Where a camera is.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Film {
    origin: [f32; 3],
    /// Towards the film's upper left corner, at distance one along the viewing direction.
    corner: [f32; 3],
    /// From a pixel to its right neighbour on that film.
    right: [f32; 3],
    /// From a pixel to its lower neighbour.
    down: [f32; 3],
}

/// The same of eight samples.
struct Films {
    origin: Vec3x8,
    corner: Vec3x8,
    right: Vec3x8,
    down: Vec3x8,
}

/// Primary rays.
#[derive(Clone, Copy, Debug)]
pub struct Primary {
    /// Where they start.
    pub origin: Vec3x8,
    /// Unit directions.
    pub direction: Vec3x8,
}

impl Film {
    fn splat(&self) -> Films {
        let [origin, corner, right, down] =
            [self.origin, self.corner, self.right, self.down].map(Vec3x8::splat);
        Films { origin, corner, right, down }
    }
}

impl Films {
    fn towards(self, end: Films, part: f32x8) -> Films {
        let mix = |a: Vec3x8, b: Vec3x8| a + (b - a) * part;
        Films {
            origin: mix(self.origin, end.origin),
            corner: mix(self.corner, end.corner),
            right: mix(self.right, end.right),
            down: mix(self.down, end.down),
        }
    }
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
        let film =
            Film { origin: from, corner, right: vec3::scale(right, pixel), down: vec3::scale(down, pixel) };
        Ok(Camera { film, end: None, lens: 0.0, focus: 1.0 })
    }

    /// The camera with a lens whose opening has the diameter `aperture` in scene units, 0 for a pinhole, and in whose
    /// picture is sharp what lies in the plane at distance `focus` along the viewing direction.
    ///
    /// # Errors
    /// [`Error::Lens`].
    pub fn with_lens(self, aperture: f32, focus: f32) -> Result<Self, Error> {
        let sound = aperture >= 0.0 && aperture.is_finite() && focus > 0.0 && focus.is_finite();
        if sound { Ok(Camera { lens: 0.5 * aperture, focus, ..self }) } else { Err(Error::Lens) }
    }

    /// The camera on its way from where it is to where `end` is while the shutter is open, evenly in time.
    pub fn moving_to(self, end: &Camera) -> Self {
        Camera { end: (end.film != self.film).then_some(end.film), ..self }
    }

    /// The primary rays of eight samples: from their points on the lens, at their times.
    #[inline(always)]
    pub fn rays(&self, samples: &Batch8) -> Primary {
        let (x, y) = (samples.x, samples.y);
        if self.end.is_none() && self.lens == 0.0 {
            return Primary { origin: Vec3x8::splat(self.film.origin), direction: self.directions(x, y) };
        }
        self.distributed(samples)
    }

    /// [`rays`](Self::rays) of a camera with a lens, or one that moves.
    #[inline(never)]
    fn distributed(&self, samples: &Batch8) -> Primary {
        let mut film = self.film.splat();
        if let Some(end) = self.end {
            film = film.towards(end.splat(), time(samples.index, samples.key));
        }
        let (u, v) = samples.point(LENS_SET);
        let (sin, cos) = sin_cos_turn(v);
        let radius = u.sqrt() * f32x8::splat(self.lens);
        let (right, down) = (film.right.normalized(), film.down.normalized());
        let lens = right * (radius * cos) + down * (radius * sin);
        let sharp = (film.corner + film.right * samples.x + film.down * samples.y) * f32x8::splat(self.focus);
        Primary { origin: film.origin + lens, direction: (sharp - lens).normalized() }
    }

    /// Where the camera stands, when the shutter opens.
    pub fn origin(&self) -> [f32; 3] {
        self.film.origin
    }

    /// Unit directions of the rays from [`origin`](Self::origin) through film positions `x`, `y` in pixels from the upper left
    /// corner.
    #[inline]
    pub fn directions(&self, x: f32x8, y: f32x8) -> Vec3x8 {
        let film = Vec3x8::splat(self.film.right) * x + Vec3x8::splat(self.film.down) * y;
        (Vec3x8::splat(self.film.corner) + film).normalized()
    }

    /// The film position, in pixels from the upper left corner, of what lies in a direction from the origin.
    ///
    /// The inverse of [`directions`](Self::directions). `direction` has any length; the position may lie outside of the
    /// film. None for what is beside or behind the camera.
    pub fn project(&self, direction: [f32; 3]) -> Option<[f32; 2]> {
        let Film { corner: towards_corner, right, down, .. } = self.film;
        let axes = [right, down];
        // The corner, by pixels along the film's axes; what remains of it looks along the view.
        let corner = axes.map(|axis| vec3::dot(towards_corner, axis) / vec3::dot(axis, axis));
        let [along_x, along_y] = [0, 1].map(|i| vec3::scale(axes[i], corner[i]));
        let forward = vec3::sub(vec3::sub(towards_corner, along_x), along_y);
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

    fn samples(x: f32, y: f32) -> Batch8 {
        let index = wide::u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]);
        Batch8 { lanes: 8, x: f32x8::splat(x), y: f32x8::splat(y), index, ..Batch8::default() }
    }

    /// Rays through one film position meet where the ray of a pinhole meets the plane of focus, and come from a disc.
    #[test]
    fn a_lens_is_sharp_at_its_focus() {
        let pinhole = Camera::new([1.0, 2.0, 3.0], [1.0, 2.0, -1.0], [0.0, 1.0, 0.0], 50.0, 8, 6).unwrap();
        let camera = pinhole.with_lens(0.5, 2.5).unwrap();
        let (samples, origin) = (samples(1.5, 4.0), Vec3x8::splat(pinhole.origin()));
        let meeting = |p: Primary| {
            let t = (f32x8::splat(0.5) - p.origin.z) / p.direction.z;
            p.origin + p.direction * t
        };
        let (sharp, lens) = (meeting(pinhole.rays(&samples)), camera.rays(&samples));
        let off = (meeting(lens) - sharp).length().to_array();
        assert!(off.iter().all(|off| *off < 1e-5), "{off:?}");
        let away = (lens.origin - origin).length().to_array();
        assert!(away.iter().all(|away| *away <= 0.25) && away.iter().any(|away| *away > 0.15), "{away:?}");
        assert_eq!(pinhole.with_lens(-1.0, 1.0), Err(Error::Lens));
        assert_eq!(pinhole.with_lens(1.0, 0.0), Err(Error::Lens));
    }

    /// Eight times are one in each eighth of the way.
    #[test]
    fn a_camera_moves_evenly_while_the_shutter_is_open() {
        let at = |x: f32| Camera::new([x, 0.0, 0.0], [x, 0.0, -1.0], [0.0, 1.0, 0.0], 50.0, 8, 6).unwrap();
        let moving = at(0.0).moving_to(&at(8.0));
        let mut eighths = moving.rays(&samples(4.0, 3.0)).origin.x.to_array().map(|x| x as u32);
        eighths.sort_unstable();
        assert_eq!(eighths, [0, 1, 2, 3, 4, 5, 6, 7]);
        assert_eq!(at(1.0).moving_to(&at(1.0)), at(1.0));
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
