//! Scenes from disk: a scene file (TOML), a bare OBJ or a glTF file becomes the arrays that the core borrows.
//!
//! [`load`] reads everything, reports what it had to guess in [`LoadedScene::warnings`], and refuses what it
//! cannot understand with one line that names the file and the line. Lengths are scene units, colours linear
//! Rec. 709, angles degrees.
//!
//! An OBJ is framed as a whole, seen along −z. [`load_lit`] lights one whose materials do not shine by a [soft sky and a
//! key light](SkyMap::soft) of the camera, in a room by a lamp that is inside as the eye is.
//!
//! A glTF file brings its own camera, lights and animation, if it has any; else it is as an OBJ. Radiance 1 is 1 cd/m² there:
//!
//! | glTF | here |
//! | --- | --- |
//! | base colour b, `metallicFactor` m, `roughnessFactor` r, index n | diffuse b (1 − m) (1 − F), GGX lobe F (1 − m) + b m of width r², F = ((n − 1) / (n + 1))² |
//! | their textures | diffuse part, emission, alpha; means for lobes |
//! | `normalTexture` | normals of all but glass |
//! | `alphaMode` | `MASK`: cut-out; `BLEND`: partial coverage |
//! | `KHR_materials_transmission` | with a volume or on closed meshes smooth glass tinted by b, else thin: partly there |
//! | point and spot light, I cd | sphere of a thousandth of the scene's size or less, 4 I / its area; a spot in a black shell with a hole |
//! | directional light, E lux | disc in the sky of 0.53°, E / its solid angle; the eye does not see it |
//! | animations | all at once from frame 0 on, 24 frames a second; those that move what an earlier one moves are left out |
//! | `TEXCOORD_1` | where a lightmap is baked to |
//!
//! What is far from the origin (geo-referenced models) is read in double precision and moved to its own centre:
//! everything in a [`LoadedScene`] is relative to its `origin`.
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
//! exposure = 0.0              # brightness of the PNG in stops, where the command line does not say
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
//! aperture = 0.0              # diameter of the lens in scene units; 0 is a pinhole
//! focus = 4.0                 # distance along the view at which it is sharp; that of `at` if nothing is said
//!
//! [[meshes]]
//! file = "room.obj"           # or .gltf, .glb; relative to the scene file
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
//! [sky]                       # light from outside; one of file, color and sun
//! file = "studio.hdr"         # equirectangular .exr or .hdr: +y up, +z in the middle, +x to the left of it
//! color = [1, 1, 1]           # the same radiance all around
//! sun = [1, 0.6, 0.2]         # a clear day with the sun in this direction, +y up; luminances are absolute, by cd_per_unit
//! haze = 1.0                  # with sun: 0 is clean air
//! ground = [0.2, 0.2, 0.2]    # with sun: what the ground below the horizon reflects
//! scale = 1.0                 # factor of the radiance
//! rotate = [0, 30, 0]         # as that of meshes; the sun turns as well
//! visible = true              # whether the eye sees it; mirrors and glass show it in any case
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
//! shutter = 0.5               # part of a frame in which the shutter is open, from the frame on: blurs what moves
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
//! | `camera` | `from`, `at`, `up`, `fov`, `aperture`, `focus` |
//! | `meshes` | `translate`, `rotate`, `scale` |
//! | `spheres` | `center`, `radius` |
//! | `lights` | `center`, `edge_u`, `edge_v`, `radiance`, `power` (a factor of the radiance, 1 if nothing is said) |
//! | `materials` | `emission` |
//!
//! While the shutter is open, camera and objects go straight and evenly from where they are in the frame to where they are as
//! it closes: what turns, along the chord. Emissions, `aperture` and `focus` are those of the frame.
//!
//! `smooth` runs through the keys without a corner, as a cubic whose tangents are those of parabolas through
//! neighbouring keys, at the ends as well: two keys make an even motion in a straight line, and what shall start
//! gently gets a key more. `fov`, `aperture`, `focus`, `scale`, `radius`, `radiance`, `power` and `emission` never leave the range of the
//! two keys around them; positions may. Rotations take the short way from key to key: a turn by more than 180° wants
//! a key between.

mod animation;
mod assemble;
pub mod bvh;
mod channel;
mod error;
mod facing;
mod file;
mod gltf;
mod home;
mod lamp;
mod load;
mod model;
mod notes;
mod obj;
mod object;
pub(crate) mod openexr;
mod options;
mod place;
mod pose;
mod rig;
mod room;
mod script;
mod shapes;
mod sky;
mod source;
mod texture;
mod track;
mod view;

pub use animation::{Animation, Change};
pub use error::Error;
pub use load::{load, load_lit};
pub use model::{Frames, LoadedScene, MAX_SIZE, Moved, Pose, View};
pub use options::{Eye, LightChoice, Options};
pub use place::{Placement, Shift};
pub use sky::SkyMap;
