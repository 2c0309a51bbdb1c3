//! Collects triangles, materials and textures from all sources: a scene in the making.

use super::animation::Animation;
use super::error::Error;
use super::model::{LoadedScene, View};
use super::object::{Corner, Object, Piece};
use super::pose;
use super::script::Script;
use super::sky::SkyMap;
use super::texture::TextureCache;
use glam::Vec3;
use pmcip_core::tracer::scene::Material;
use pmcip_core::tracer::scene::light;
use std::path::Path;

/// The vertical field of view of the automatic camera: that of the Cornell box.
pub(super) const DEFAULT_FOV: f32 = 39.3;

/// What the scene file or the lack of one says about the image.
#[derive(Clone, Debug)]
pub(super) struct Shot {
    pub view: Option<View>,
    pub sky: Option<SkyMap>,
    pub width: u32,
    pub height: u32,
    pub cd_per_unit: f32,
    pub exposure: f32,
    pub spp: Option<u32>,
    pub max_depth: Option<u32>,
    /// Whether a scene without light gets one.
    pub soft_light: bool,
}

impl Default for Shot {
    fn default() -> Self {
        Shot {
            view: None,
            sky: None,
            width: 512,
            height: 512,
            cd_per_unit: 100.0,
            exposure: 0.0,
            spp: None,
            max_depth: None,
            soft_light: false,
        }
    }
}

/// A scene in the making.
#[derive(Debug, Default)]
pub(super) struct Assembly {
    objects: Vec<Object>,
    materials: Vec<Material>,
    pub textures: TextureCache,
    warnings: Vec<String>,
}

impl Assembly {
    /// Adds a material and returns its index.
    pub fn add_material(&mut self, material: Material) -> u32 {
        self.materials.push(material);
        (self.materials.len() - 1) as u32
    }

    /// Notes what the user should know; once is enough.
    pub fn warn(&mut self, warning: String) {
        if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
    }

    /// Begins an object that stands in the file `source`: all triangles up to the next one move together.
    pub fn begin(&mut self, source: &Path) {
        self.objects.push(Object { source: source.to_owned(), pieces: Vec::new() });
    }

    /// Adds a triangle to the object begun last.
    pub fn add(&mut self, corners: [Corner; 3], material: u32) {
        if let Some(object) = self.objects.last_mut() {
            object.pieces.push(Piece { corners, material });
        }
    }

    /// Poses all objects for the first frame of `script`, and frames the view if there is none.
    pub fn finish(mut self, path: &Path, shot: Shot, script: Script) -> Result<Animation, Error> {
        let blame = |message| Error::in_file(path, message);
        let frame = script.first_frame();
        let placements = script.placements(frame).map_err(blame)?;
        let mut geometry = pose::place(&self.objects, &placements).map_err(blame)?;
        let view = shot.view.unwrap_or_else(|| frame_view(geometry.bounds, shot.width, shot.height));
        let mut sky = shot.sky;
        if shot.soft_light && sky.is_none() && light::count(&geometry.surfaces, &self.materials) == 0 {
            let why = "no light: no material has an emission (Ke); a soft sky and a key light instead";
            self.warn(format!("{}: {why}", path.display()));
            sky = Some(SkyMap::soft(&view));
        }
        geometry.sort();
        let (textures, texels) = self.textures.into_parts();
        let mut scene = LoadedScene {
            name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            path: path.to_owned(),
            nodes: geometry.nodes,
            leaves: geometry.leaves,
            triangles: geometry.triangles,
            surfaces: geometry.surfaces,
            objects: geometry.objects,
            placements,
            materials: self.materials,
            textures,
            texels,
            lights: Vec::new(),
            light_nodes: Vec::new(),
            sky,
            view,
            closing_view: None,
            width: shot.width,
            height: shot.height,
            cd_per_unit: shot.cd_per_unit,
            exposure: shot.exposure,
            spp: shot.spp,
            max_depth: shot.max_depth,
            warnings: self.warnings,
        };
        geometry.warnings.into_iter().for_each(|warning| scene.warn(warning));
        Animation::new(scene, self.objects, script, frame)
    }
}

/// The material of a lamp: black where it does not shine.
pub(super) fn lamp(radiance: [f32; 3]) -> Material {
    Material { diffuse: [0.0; 3], emission: radiance, ..Material::default() }
}

/// A view along −z that holds the whole box.
fn frame_view((low, high): (Vec3, Vec3), width: u32, height: u32) -> View {
    const MARGIN: f32 = 1.05;
    let centre = 0.5 * (low + high);
    let half = 0.5 * (high - low);
    let aspect = width as f32 / height as f32;
    let extent = half.y.max(half.x / aspect) * MARGIN;
    let distance = half.z + extent / (0.5 * DEFAULT_FOV).to_radians().tan();
    // A flat box seen edge-on has no extent: step back all the same.
    let distance = distance.max(half.z * (1.0 + MARGIN));
    View {
        from: (centre + Vec3::Z * distance).to_array(),
        at: centre.to_array(),
        up: Vec3::Y.to_array(),
        fov: DEFAULT_FOV,
        aperture: 0.0,
        focus: None,
    }
}
