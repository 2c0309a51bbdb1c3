//! The sky that a scene file asks for.

use super::daylight::Daylight;
use super::file;
use super::map::SkyMap;
use crate::scene::error::Error;
use glam::Mat3;
use std::path::Path;

/// What a scene file says of its sky.
#[derive(Clone, Copy, Debug)]
pub struct Order<'a> {
    pub kind: Kind<'a>,
    /// Factor of the radiance.
    pub scale: f32,
    /// From the sky's axes to the scene's.
    pub rotation: Mat3,
    pub visible: bool,
}

/// What a sky is made of.
#[derive(Clone, Copy, Debug)]
pub enum Kind<'a> {
    File(&'a Path),
    Color([f32; 3]),
    /// Luminance in cd/m² of radiance 1 comes second.
    Daylight(Daylight, f32),
}

impl Order<'_> {
    /// The sky asked for, and what was odd about it.
    ///
    /// # Errors
    /// If its file cannot be read or is too large.
    pub fn sky(&self) -> Result<(SkyMap, Vec<String>), Error> {
        let (mut sky, warnings) = match self.kind {
            Kind::File(path) => file::load(path, self.scale)?,
            Kind::Color(radiance) => (SkyMap::even(radiance.map(|v| v * self.scale)), Vec::new()),
            Kind::Daylight(daylight, cd_per_unit) => (daylight.sky(self.scale / cd_per_unit), Vec::new()),
        };
        sky.visible = self.visible;
        Ok((sky.turned(self.rotation), warnings))
    }
}
