//! Collects triangles, materials and textures from all sources: a scene in the making.

use super::animation::Animation;
use super::error::Error;
use super::model::{Kind, LoadedScene, View};
use super::object::{Corner, Extras, NO_UVS, Object, Piece};
use super::options::{LightChoice, Options};
use super::place::Placement;
use super::pose::{self, Geometry};
use super::room::{Kind as Taker, Room};
use super::script::{ObjectTrack, Script};
use super::sky::SkyMap;
use super::texture::TextureCache;
use super::{facing, home, lamp, shapes};
use glam::{DVec3, Vec3};
use pmcip_core::tracer::scene::{Material, NO_TEXTURE, light};
use std::collections::{HashMap, HashSet};
use std::path::Path;

/// The vertical field of view of the automatic camera: that of the Cornell box.
pub(super) const DEFAULT_FOV: f32 = 39.3;

/// What the scene file or the lack of one says about the image.
#[derive(Clone, Debug)]
pub(super) struct Shot {
    pub sky: Option<SkyMap>,
    pub width: u32,
    pub height: u32,
    pub cd_per_unit: f32,
    pub exposure: f32,
    pub spp: Option<u32>,
    pub max_depth: Option<u32>,
}

impl Default for Shot {
    fn default() -> Self {
        Shot {
            sky: None,
            width: 512,
            height: 512,
            cd_per_unit: 100.0,
            exposure: 0.0,
            spp: None,
            max_depth: None,
        }
    }
}

/// A scene in the making.
#[derive(Debug)]
pub(super) struct Assembly {
    /// Whether a line that means nothing is an error.
    pub strict: bool,
    objects: Vec<Object>,
    materials: Vec<Material>,
    /// What materials are called, where they are.
    names: HashMap<u32, String>,
    /// Normal maps of materials that have one.
    normal_maps: HashMap<u32, u32>,
    /// Materials of single triangles by that of their object and the bits of their mean radiance.
    glows: HashMap<(u32, [u32; 3]), u32>,
    pub textures: TextureCache,
    /// Room for all of it.
    pub room: Room,
    /// Materials that there is room for.
    housed: usize,
    warnings: Vec<String>,
    warned: HashSet<String>,
}

impl Assembly {
    /// Nothing yet.
    pub fn new(options: &Options) -> Assembly {
        let room = Room::new(options.memory);
        Assembly {
            strict: options.strict,
            objects: Vec::new(),
            materials: Vec::new(),
            names: HashMap::new(),
            normal_maps: HashMap::new(),
            glows: HashMap::new(),
            textures: TextureCache::new(room.clone()),
            room,
            housed: 0,
            warnings: Vec::new(),
            warned: HashSet::new(),
        }
    }

    /// Asks for room for so many triangles, before they are made, and for the materials that there are by now.
    ///
    /// # Errors
    /// If there is not enough, or was not for a picture.
    pub fn ask_for(&mut self, triangles: usize) -> Result<(), String> {
        self.textures.check()?;
        self.room.take(self.materials.len() - self.housed, Taker::Materials)?;
        self.housed = self.materials.len();
        self.room.take(triangles, Taker::Triangles)
    }

    /// Adds a material and returns its index.
    pub fn add_material(&mut self, material: Material) -> u32 {
        self.materials.push(material);
        (self.materials.len() - 1) as u32
    }

    /// Adds a material that has a name, and returns its index.
    pub fn add_named(&mut self, material: Material, name: &str) -> u32 {
        let index = self.add_material(material);
        self.names.insert(index, name.to_owned());
        index
    }

    /// Gives a material a normal map.
    pub fn bend(&mut self, material: u32, map: u32) {
        self.normal_maps.insert(material, map);
    }

    /// A material that was added.
    pub fn material(&self, index: u32) -> &Material {
        &self.materials[index as usize]
    }

    /// Notes what the user should know; once is enough.
    pub fn warn(&mut self, warning: String) {
        if self.warned.insert(warning.clone()) {
            self.warnings.push(warning);
        }
    }

    /// Begins an object that stands in the file `source` and whose coordinates begin at `home`: all triangles up to the
    /// next one move together.
    pub fn begin(&mut self, source: &Path, home: DVec3) {
        self.objects.push(Object {
            source: source.to_owned(),
            home,
            pieces: Vec::new(),
            colours: Vec::new(),
            second: Vec::new(),
        });
    }

    /// Adds a triangle to the object begun last.
    pub fn add(&mut self, corners: [Corner; 3], material: u32) {
        self.add_coloured(corners, material, None);
    }

    /// Adds a triangle whose corners may have linear colours.
    pub fn add_coloured(&mut self, corners: [Corner; 3], material: u32, colours: Option<[[f32; 3]; 3]>) {
        self.add_with(corners, material, Extras { colours, ..Extras::default() });
    }

    /// Adds a triangle whose corners may have more than a position, a normal and texture coordinates.
    pub fn add_with(&mut self, corners: [Corner; 3], material: u32, extras: Extras) {
        let material = self.glowing(material, &corners);
        let Some(object) = self.objects.last_mut() else { return };
        if let Some(colours) = extras.colours {
            object.colours.resize(object.pieces.len(), [[1.0; 3]; 3]);
            object.colours.push(colours);
        }
        if let Some(second) = extras.second {
            object.second.resize(object.pieces.len(), NO_UVS);
            object.second.push(second);
        }
        object.pieces.push(Piece { corners, material });
    }

    /// How large all objects are together where these placements put them, and how far each point is from the nearest
    /// triangle; infinitely where there is none.
    pub fn clearances(&self, placements: &[Placement], points: &[DVec3]) -> (f64, Vec<f64>) {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut nearest = vec![f64::INFINITY; points.len()];
        for (object, placement) in self.objects.iter().zip(placements) {
            let placement = placement.seated(object.home, DVec3::ZERO);
            for piece in &object.pieces {
                let corners = piece.corners.map(|corner| placement.exact(corner.position));
                corners.into_iter().for_each(|corner| (low, high) = (low.min(corner), high.max(corner)));
                for (nearest, point) in nearest.iter_mut().zip(points) {
                    *nearest = nearest.min(shapes::distance(*point, corners));
                }
            }
        }
        ((high - low).max_element().max(0.0), nearest)
    }

    /// The material itself, or if a texture shines in it, one that knows how much of that is on this triangle.
    fn glowing(&mut self, index: u32, corners: &[Corner; 3]) -> u32 {
        let material = self.materials[index as usize];
        if material.emission_texture == NO_TEXTURE {
            return index;
        }
        let emission = self.textures.mean(material.emission_texture, corners.map(|c| c.uv.to_array()));
        let is_dark = emission == [0.0; 3];
        let emission_texture = if is_dark { NO_TEXTURE } else { material.emission_texture };
        let (materials, maps) = (&mut self.materials, &mut self.normal_maps);
        *self.glows.entry((index, emission.map(f32::to_bits))).or_insert_with(|| {
            materials.push(Material { emission, emission_texture, ..material });
            let new = (materials.len() - 1) as u32;
            if let Some(map) = maps.get(&index).copied() {
                maps.insert(new, map);
            }
            new
        })
    }

    /// Poses all objects for the first frame of `script`, frames the view if it has no camera, and adds the light of last
    /// resort that `options` ask for.
    pub fn finish(
        mut self,
        path: &Path,
        shot: Shot,
        options: &Options,
        mut script: Script,
    ) -> Result<Animation, Error> {
        self.ask_for(0).map_err(|message| Error::in_file(path, message))?;
        let blame = |message| Error::in_file(path, message);
        let frame = script.first_frame();
        let placements = script.placements(frame).map_err(blame)?;
        let origin = self.origin(&placements);
        let mut placements = self.seated(&placements, origin);
        let mut closing = self.seated(&script.placements(script.closes(frame)).map_err(blame)?, origin);
        let mut geometry = pose::place(&self.objects, &placements, &closing).map_err(blame)?;
        let view = match &script.camera {
            Some(camera) => camera.at(f64::from(frame), origin).map_err(blame)?,
            None => frame_view(geometry.bounds, shot.width, shot.height),
        };
        self.name_backward_lamps(path, &geometry);
        let mut sky = shot.sky;
        let is_dark = sky.is_none() && light::count(&geometry.surfaces, &self.materials) == 0;
        let has_lamp = options.light == LightChoice::Sky || options.light == LightChoice::Auto && is_dark;
        if has_lamp {
            let eye = options.eye.applied(&view, origin.to_array());
            let indoors = sky.is_some() || lamp::is_indoors(&eye, &geometry);
            if is_dark {
                let light = if indoors { "a lamp by the camera" } else { "a soft sky and a key light" };
                let why = match Kind::of(path) {
                    Kind::Gltf => "no light: it has none, and no material an emission",
                    _ => "no light: no material has an emission (Ke)",
                };
                self.warn(format!("{}: {why}; {light} instead (--light own: without)", path.display()));
            }
            if indoors {
                self.add_lamp(path, &eye, &geometry, origin);
                script.paths.push(ObjectTrack::Still);
                placements.push(Placement::IDENTITY);
                closing.push(Placement::IDENTITY);
                geometry = pose::place(&self.objects, &placements, &closing).map_err(blame)?;
            } else {
                sky = Some(SkyMap::soft(&eye));
            }
        }
        geometry.sort();
        let (textures, texels) = self.textures.into_parts();
        let mut normal_maps = Vec::new();
        if !self.normal_maps.is_empty() {
            normal_maps = vec![NO_TEXTURE; self.materials.len()];
            self.normal_maps.iter().for_each(|(material, map)| normal_maps[*material as usize] = *map);
        }
        let mut scene = LoadedScene {
            name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            path: path.to_owned(),
            has_lamp,
            origin: origin.to_array(),
            nodes: geometry.nodes,
            leaves: geometry.leaves,
            triangles: geometry.triangles,
            surfaces: geometry.surfaces,
            colours: geometry.colours,
            second_uvs: geometry.second,
            objects: geometry.objects,
            placements,
            moved: geometry.moved,
            materials: self.materials,
            normal_maps,
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
        Animation::new(scene, self.objects, script, frame, closing)
    }

    /// Names lamps that shine away from everything.
    fn name_backward_lamps(&mut self, path: &Path, geometry: &Geometry) {
        for material in facing::backwards(geometry, &self.materials) {
            let Some(name) = self.names.get(&material) else { continue };
            let why = "shines away from everything: a lamp's front is the side from which its corners run counter-clockwise";
            self.warn(format!("{}: the lamp \"{name}\" {why}", path.display()));
        }
    }

    /// Where the scene's coordinates begin: see [`home`].
    fn origin(&self, placements: &[Placement]) -> DVec3 {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for (object, placement) in self.objects.iter().zip(placements) {
            let placement = placement.seated(object.home, DVec3::ZERO);
            for point in
                object.pieces.iter().flat_map(|piece| piece.corners).map(|c| placement.exact(c.position))
            {
                (low, high) = (low.min(point), high.max(point));
            }
        }
        home::home(low, high)
    }

    fn seated(&self, placements: &[Placement], origin: DVec3) -> Vec<Placement> {
        let objects = placements.iter().zip(&self.objects);
        objects.map(|(placement, object)| placement.seated(object.home, origin)).collect()
    }

    /// Lights a room from the camera.
    fn add_lamp(&mut self, path: &Path, view: &View, geometry: &Geometry, origin: DVec3) {
        let (place, radiance) = lamp::key_light(view, geometry);
        let material = self.add_material(lamp([radiance; 3]));
        self.begin(path, origin);
        for triangle in shapes::square() {
            self.add(triangle.map(|c| Corner { position: place.position(c.position), ..c }), material);
        }
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
