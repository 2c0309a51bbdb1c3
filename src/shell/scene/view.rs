//! From where a scene is seen.

use pmcip_core::tracer::camera::{Camera, Error};

/// From where a scene is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The eye.
    pub from: [f32; 3],
    /// A point in the middle of the image.
    pub at: [f32; 3],
    /// A direction that points up in the image.
    pub up: [f32; 3],
    /// Vertical field of view in degrees.
    pub fov: f32,
    /// Diameter of the lens in scene units; 0 is a pinhole, by which everything is sharp.
    pub aperture: f32,
    /// Distance along the view at which the picture is sharp, in scene units; none is that of `at`.
    pub focus: Option<f32>,
}

impl View {
    /// A camera for a film of `width` by `height` pixels.
    ///
    /// # Errors
    /// If the view is not defined.
    pub fn camera(&self, width: u32, height: u32) -> Result<Camera, Error> {
        let away = glam::Vec3::from(self.at).distance(glam::Vec3::from(self.from));
        let camera = Camera::new(self.from, self.at, self.up, self.fov, width, height)?;
        camera.with_lens(self.aperture, self.focus.unwrap_or(away))
    }
}
