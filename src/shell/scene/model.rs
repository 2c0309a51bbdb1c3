//! What a scene is, in memory.

use super::error::Error;
use super::place::Placement;
use super::sky::SkyMap;
pub use super::view::View;
use pmcip_core::tracer::scene::{
    Light, LightNode8, Material, Motion, Node8, SceneData, Surface, Texture, Triangle,
};
use std::path::{Path, PathBuf};

/// The largest width or height of an image, in pixels.
pub const MAX_SIZE: u32 = pmcip_core::sampler::film::MAX_SIDE;

/// Where everything stands in a frame: what is to be kept of it to know how things have moved since.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// The camera.
    pub view: View,
    /// Where each object stands.
    pub placements: Vec<Placement>,
}

/// Triangles as the shutter closes; nothing where they stand still.
#[derive(Clone, Debug, Default)]
pub struct Moved {
    /// One for each triangle.
    pub triangles: Vec<Triangle>,
    /// The triangles' coordinates leaf by leaf.
    pub leaves: Vec<f32>,
    /// Shading normals at the corners of each triangle; zero where it is flat.
    pub normals: Vec<[[f32; 3]; 3]>,
}

impl Moved {
    /// As the core sees it.
    fn lent(&self) -> Option<Motion<'_>> {
        let Moved { triangles, leaves, normals } = self;
        (!triangles.is_empty()).then_some(Motion { triangles, leaves, normals })
    }
}

/// A scene in memory, ready to be lent to the core.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// The file's name without its extension.
    pub name: String,
    /// The file it came from.
    pub path: PathBuf,
    /// Whether it got a lamp by the camera.
    pub has_lamp: bool,
    /// Where all coordinates begin, in those of the file: zero unless the scene is far from there.
    pub origin: [f64; 3],
    /// Hierarchy over the triangles.
    pub nodes: Vec<Node8>,
    /// The triangles' coordinates leaf by leaf.
    pub leaves: Vec<f32>,
    /// Triangles in leaf order.
    pub triangles: Vec<Triangle>,
    /// One a triangle.
    pub surfaces: Vec<Surface>,
    /// Linear colours of the corners of each triangle; empty if there are none.
    pub colours: Vec<[[f32; 3]; 3]>,
    /// Second texture coordinates of the corners of each triangle, `v` upwards, NaN where there are none; empty if no
    /// triangle has any.
    pub second_uvs: Vec<[[f32; 2]; 3]>,
    /// The object of each triangle: meshes, then spheres, then lights, in the order of the scene file.
    pub objects: Vec<u32>,
    /// Where each object stands; where the shutter is open for a time, as it opens.
    pub placements: Vec<Placement>,
    /// The triangles as the shutter closes, if any moves until then.
    pub moved: Moved,
    /// Materials.
    pub materials: Vec<Material>,
    /// The normal map of each material; empty if none has any.
    pub normal_maps: Vec<u32>,
    /// Textures.
    pub textures: Vec<Texture>,
    /// Texels of all textures.
    pub texels: Vec<[f32; 3]>,
    /// Emitting triangles.
    pub lights: Vec<Light>,
    /// Tree over them; empty where they are few.
    pub light_nodes: Vec<LightNode8>,
    /// Light from outside, if there is any.
    pub sky: Option<SkyMap>,
    /// The camera; where the shutter is open for a time, as it opens.
    pub view: View,
    /// The camera as the shutter closes, if it moves until then.
    pub closing_view: Option<View>,
    /// Image width in pixels.
    pub width: u32,
    /// Image height in pixels.
    pub height: u32,
    /// Luminance in cd/m² of radiance 1.
    pub cd_per_unit: f32,
    /// Brightness of its pictures for the eye in stops: each doubles it.
    pub exposure: f32,
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
            colours: &self.colours,
            materials: &self.materials,
            normal_maps: &self.normal_maps,
            textures: &self.textures,
            texels: &self.texels,
            lights: &self.lights,
            light_nodes: &self.light_nodes,
            sky: self.sky.as_ref().map(SkyMap::lent),
            motion: self.moved.lent(),
        }
    }

    /// Notes what the user should know; once is enough.
    pub(super) fn warn(&mut self, warning: String) {
        if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
    }

    /// Whether it is an OBJ or a glTF file as a scene of its own.
    pub fn is_bare(&self) -> bool {
        Kind::of(&self.path) != Kind::Other
    }

    /// Makes sure that something shines, before time is spent on a black image.
    ///
    /// # Errors
    /// If no triangle emits and there is no sky.
    pub fn require_light(&self) -> Result<(), Error> {
        if !self.lights.is_empty() || self.sky.is_some() {
            return Ok(());
        }
        let remedy = match Kind::of(&self.path) {
            Kind::Obj => "give a material in the MTL file an emission (Ke)",
            Kind::Gltf => "give a material an emissiveFactor, or a node a light (KHR_lights_punctual)",
            Kind::Other => "add [[lights]], a [sky] or a material with emission",
        };
        Err(Error::in_file(&self.path, format!("no light: {remedy}")))
    }
}

/// The frames of an animation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frames {
    /// Number of the first frame.
    pub first: u32,
    /// Number of the last frame.
    pub last: u32,
    /// Frames a second.
    pub fps: f32,
}

/// What a file is, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// An OBJ.
    Obj,
    /// glTF, as text or binary.
    Gltf,
    /// Something else: a scene file.
    Other,
}

impl Kind {
    /// The kind of the file of this name.
    pub fn of(path: &Path) -> Kind {
        let ends = |with: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(with));
        match () {
            _ if ends("obj") => Kind::Obj,
            _ if ends("gltf") || ends("glb") => Kind::Gltf,
            _ => Kind::Other,
        }
    }
}
