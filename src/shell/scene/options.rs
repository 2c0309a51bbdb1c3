//! How a scene is loaded.

use super::model::View;
use glam::DVec3;

/// What lights a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum LightChoice {
    /// Its own; an OBJ or glTF file that has none, or that it leaves in the dark, gets a soft sky and a key light, in a room a lamp
    #[default]
    Auto,
    /// Its own alone
    Own,
    /// A soft sky and a key light beside its own, in a room or under a sky of its own a lamp by the camera
    Sky,
}

/// What a user says of the camera, in the file's coordinates; the rest is the scene's own.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Eye {
    /// The eye.
    pub from: Option<[f64; 3]>,
    /// A point in the middle of the image.
    pub at: Option<[f64; 3]>,
    /// A direction that points up in the image.
    pub up: Option<[f32; 3]>,
    /// Vertical field of view in degrees.
    pub fov: Option<f32>,
    /// Diameter of the lens in scene units.
    pub aperture: Option<f32>,
    /// Distance along the view at which the picture is sharp.
    pub focus: Option<f32>,
}

/// How a scene is loaded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// Whether a line of a mesh or material file that means nothing is an error, instead of left out with a warning.
    pub strict: bool,
    /// What lights it.
    pub light: LightChoice,
    /// From where the lamp by the camera shines.
    pub eye: Eye,
    /// Bytes of memory that it may take while it is loaded; none: as many as are free. Triangles, texels and whatever a short
    /// file can make many of are counted before they are made, and a scene that needs more is an error.
    pub memory: Option<u64>,
}

impl Eye {
    /// The view that results from that of the scene, whose coordinates begin at `origin`.
    pub fn applied(&self, view: &View, origin: [f64; 3]) -> View {
        let local =
            |point: [f64; 3]| (DVec3::from_array(point) - DVec3::from_array(origin)).as_vec3().to_array();
        View {
            from: self.from.map_or(view.from, local),
            at: self.at.map_or(view.at, local),
            up: self.up.unwrap_or(view.up),
            fov: self.fov.unwrap_or(view.fov),
            aperture: self.aperture.unwrap_or(view.aperture),
            focus: self.focus.or(view.focus),
        }
    }
}
