//! Scenes from disk: a scene file (TOML) or a bare OBJ becomes the arrays that the core borrows.
//!
//! [`load`] reads everything, reports what it had to guess in [`LoadedScene::warnings`], and refuses what it
//! cannot understand with one line that names the file and the line. Lengths are scene units, colours linear
//! Rec. 709, angles degrees.
//!
//! An OBJ is framed as a whole, seen along −z. [`load_lit`] lights one whose materials do not shine by a lamp behind
//! the camera, above and to the left; it stays there when the command line moves the camera.
//!
//! # The scene file
//!
//! ```toml
//! made_by = "make meshes"     # optional: what to run if a mesh file is missing, for the message that says so
//!
//! [film]                      # optional, as is every key in it
//! width = 512
//! height = 512
//! cd_per_unit = 100.0         # luminance in cd/m² of radiance 1
//!
//! [render]                    # optional defaults for the command line
//! spp = 64
//! max_depth = 8
//!
//! [camera]                    # optional; without it the view is framed on the scene
//! from = [278, 273, -800]
//! at = [278, 273, 0]
//! up = [0, 1, 0]              # this is the default
//! fov = 39.3                  # vertical
//!
//! [[meshes]]
//! file = "room.obj"           # relative to the scene file
//! scale = 2.0                 # or one factor an axis; applied first
//! rotate = [0, 30, 0]         # then about the fixed x, y and z axis, in this order
//! translate = [1, 0, 0]       # last
//! material = "white"          # instead of the mesh's own
//!
//! [[spheres]]
//! center = [190, 120, 170]
//! radius = 90
//! subdivisions = 6            # of an icosahedron: 20·4ⁿ triangles
//! material = "glass"
//!
//! [[lights]]                  # a rectangle that shines along edge_u × edge_v
//! center = [278, 547.8, 279.5]
//! edge_u = [65, 0, 0]         # half edges
//! edge_v = [0, 0, 52.5]
//! radiance = [18, 11, 3]
//!
//! [materials.glass]
//! kind = "glass"              # "rough" (default), "mirror" or "glass"
//! ior = 1.5
//! diffuse = [0.5, 0.5, 0.5]   # rough
//! specular = [1, 1, 1]        # rough: at normal incidence; mirror and glass: tint
//! roughness = 0.3             # rough: width of the GGX lobe
//! emission = [0, 0, 0]        # radiance, front side
//!
//! [frames]                    # an animation; needed where there are keys
//! first = 1
//! last = 100                  # included
//! fps = 25                    # for a video; 24 is the default
//! ```
//!
//! # Keys
//!
//! Camera, meshes, spheres, lights and materials take `keys`, each with the number of its `frame` and what has
//! changed by then:
//!
//! ```toml
//! [[meshes]]
//! file = "door.obj"
//! translate = [4, 0, 0]
//! interpolation = "linear"    # between keys; "smooth" is the default
//! keys = [
//!   { frame = 1, rotate = [0, 0, 0] },
//!   { frame = 30, rotate = [0, 90, 0], scale = 1.0 },
//!   { frame = 60, scale = 1.2 },
//! ]
//! ```
//!
//! A property follows the keys that name it, and no others: the door above turns from frame 1 to 30 and grows from 30
//! to 60. Before its first key it is as in the first, after its last as in the last. Where no key names it, the
//! object's own value holds. Keys come in the order of their frames, whole numbers. What can have keys:
//!
//! | table | properties |
//! | --- | --- |
//! | `camera` | `from`, `at`, `up`, `fov` |
//! | `meshes` | `translate`, `rotate`, `scale` |
//! | `spheres` | `center`, `radius` |
//! | `lights` | `center`, `edge_u`, `edge_v`, `radiance`, `power` (a factor of the radiance, 1 if nothing is said) |
//! | `materials` | `emission` |
//!
//! `smooth` runs through the keys without a corner, as a cubic whose tangents are those of parabolas through
//! neighbouring keys, at the ends as well: two keys make an even motion in a straight line, and what shall start
//! gently gets a key more. `fov`, `scale`, `radius`, `radiance`, `power` and `emission` never leave the range of the
//! two keys around them; positions may. Rotations take the short way from key to key: a turn by more than 180° wants
//! a key between.

mod animation;
mod assemble;
pub mod bvh;
mod error;
mod file;
mod keys;
mod mtl;
mod obj;
mod obj_text;
mod place;
mod pose;
mod shapes;
mod texture;
mod track;
mod value;

pub use animation::{Animation, Change, Frames};
pub use error::Error;
pub use place::{Placement, Shift};
/// The largest width or height of an image, in pixels.
pub const MAX_SIZE: u32 = 16384;

use pmcip_core::tracer::scene::{
    Leaf8, Light, LightNode8, Material, Node8, SceneData, Surface, Texture, Triangle,
};
use std::path::{Path, PathBuf};

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
}

/// Where everything stands in a frame: what is to be kept of it to know how things have moved since.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// The camera.
    pub view: View,
    /// Where each object stands.
    pub placements: Vec<Placement>,
}

/// A scene in memory, ready to be lent to the core.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// The file's name without its extension.
    pub name: String,
    /// The file it came from.
    pub path: PathBuf,
    /// Hierarchy over the triangles.
    pub nodes: Vec<Node8>,
    /// The hierarchy's leaves.
    pub leaves: Vec<Leaf8>,
    /// Triangles in leaf order.
    pub triangles: Vec<Triangle>,
    /// One a triangle.
    pub surfaces: Vec<Surface>,
    /// The object of each triangle: meshes, then spheres, then lights, in the order of the scene file.
    pub objects: Vec<u32>,
    /// Where each object stands.
    pub placements: Vec<Placement>,
    /// Materials.
    pub materials: Vec<Material>,
    /// Textures.
    pub textures: Vec<Texture>,
    /// Texels of all textures.
    pub texels: Vec<[f32; 3]>,
    /// Emitting triangles.
    pub lights: Vec<Light>,
    /// Tree over them; empty where they are few.
    pub light_nodes: Vec<LightNode8>,
    /// The camera.
    pub view: View,
    /// Image width in pixels.
    pub width: u32,
    /// Image height in pixels.
    pub height: u32,
    /// Luminance in cd/m² of radiance 1.
    pub cd_per_unit: f32,
    /// Samples a pixel that the scene asks for.
    pub spp: Option<u32>,
    /// Path depth that the scene asks for.
    pub max_depth: Option<u32>,
    /// What the loader had to guess or leave out, one line each.
    pub warnings: Vec<String>,
}

impl LoadedScene {
    /// Where everything stands, seen by `view`.
    pub fn pose(&self, view: View) -> Pose {
        Pose { view, placements: self.placements.clone() }
    }

    /// The scene as the core sees it.
    pub fn data(&self) -> SceneData<'_> {
        SceneData {
            nodes: &self.nodes,
            leaves: &self.leaves,
            triangles: &self.triangles,
            surfaces: &self.surfaces,
            materials: &self.materials,
            textures: &self.textures,
            texels: &self.texels,
            lights: &self.lights,
            light_nodes: &self.light_nodes,
        }
    }

    /// Notes what the user should know; once is enough.
    fn warn(&mut self, warning: String) {
        if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
    }

    /// Makes sure that something shines, before time is spent on a black image.
    ///
    /// # Errors
    /// If no triangle emits.
    pub fn require_light(&self) -> Result<(), Error> {
        if !self.lights.is_empty() {
            return Ok(());
        }
        let remedy = if is_obj(&self.path) {
            "give a material in the MTL file an emission (Ke)"
        } else {
            "add [[lights]] or a material with emission"
        };
        Err(Error::in_file(&self.path, format!("no light: {remedy}")))
    }
}

/// Loads a scene file, or an OBJ as a scene of its own; of an animation the first frame.
///
/// # Errors
/// If a file cannot be read or understood, or holds no triangle.
pub fn load(path: &Path) -> Result<LoadedScene, Error> {
    Animation::load(path).map(Animation::into_scene)
}

/// Loads a scene to be rendered: as [`load`], but something shines in it. An OBJ without light gets a lamp behind the
/// camera, and a warning that says so.
///
/// # Errors
/// As [`load`], and if a scene file has no light.
pub fn load_lit(path: &Path) -> Result<LoadedScene, Error> {
    Animation::load_lit(path).map(Animation::into_scene)
}

fn is_obj(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj"))
}
