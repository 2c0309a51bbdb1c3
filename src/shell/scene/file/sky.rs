//! The sky that a scene file asks for.

use super::keys::Fault;
use super::tables::SkyTable;
use super::tracks::rotation;
use crate::scene::sky::{Daylight, Kind, Order};
use glam::{Mat3, Vec3};
use std::path::Path;

impl SkyTable {
    /// The sky asked for by the scene file `scene`, in which radiance 1 is `cd_per_unit`; `offset` is where the table stands.
    ///
    /// # Errors
    /// Unless just one of `file`, `color` and `sun` is there, with keys that belong to it.
    pub fn order<'a>(&self, file: &'a Path, cd_per_unit: f32, offset: usize) -> Result<Order<'a>, Fault> {
        let fault = |message: &str| Err((offset, message.to_owned()));
        let kind = match (&self.file, self.color, self.sun) {
            (Some(_), None, None) => Kind::File(file),
            (None, Some(color), None) => Kind::Color(color.0),
            (None, None, Some(sun)) => match sun.vec3().try_normalize() {
                Some(sun) => Kind::Daylight(self.daylight(sun), cd_per_unit),
                None => return fault("sky: sun has no direction"),
            },
            _ => return fault("sky: expected one of file, color and sun"),
        };
        if self.sun.is_none() && (self.haze.is_some() || self.ground.is_some()) {
            return fault("sky: haze and ground need sun");
        }
        let rotation = self.rotate.map_or(Mat3::IDENTITY, |degrees| Mat3::from_quat(rotation(degrees)));
        Ok(Order { kind, scale: self.scale.map_or(1.0, |v| v.0), rotation, visible: self.visible })
    }

    fn daylight(&self, sun: Vec3) -> Daylight {
        const GROUND: f32 = 0.2;
        let ground = self.ground.map_or([GROUND; 3], |v| v.0);
        Daylight { sun, haze: self.haze.map_or(1.0, |v| v.0), ground }
    }
}
