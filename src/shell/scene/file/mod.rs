//! The scene file: what TOML may say, and what it means.

mod keys;
mod sky;
mod tables;
mod tracks;
mod value;

use crate::scene::animation::Animation;
use crate::scene::assemble::{Assembly, Shot, lamp};
use crate::scene::error::{Error, read};
use crate::scene::model::Frames;
use crate::scene::object::Corner;
use crate::scene::options::Options;
use crate::scene::room::{Kind as Taker, Room};
use crate::scene::script::{CameraPath, Script};
use crate::scene::shapes;
use crate::scene::source::looks_like_obj;
use glam::DVec3;
use keys::{Fault, Keys};
use pmcip_core::tracer::scene::{Material, Scattering};
use std::collections::BTreeMap;
use std::path::Path;
use tables::{FramesTable, Kind, LightTable, MaterialTable, SceneFile, SphereTable};
use toml::Spanned;

/// Adds the triangles of a mesh file, all of one material if it is given.
pub(super) type AddMesh = fn(&mut Assembly, &Path, Option<u32>) -> Result<(), Error>;

/// A scene file's text, and where it stands.
struct Source<'a> {
    path: &'a Path,
    text: &'a str,
}

impl Source<'_> {
    fn error(&self, offset: usize, message: impl Into<String>) -> Error {
        let line =
            1 + self.text.as_bytes()[..offset.min(self.text.len())].iter().filter(|b| **b == b'\n').count();
        Error::at(self.path, line, message)
    }

    /// One line from what toml says in several.
    fn toml_error(&self, mut error: toml::de::Error) -> Error {
        let span = error.span();
        // Without the text, the message names the key instead of drawing an excerpt.
        error.set_input(None);
        let message = error.to_string().trim().replace('\n', " ");
        match span {
            Some(span) => self.error(span.start, message),
            None => Error::in_file(self.path, message),
        }
    }
}

/// Loads a scene file and all that it names.
pub(super) fn load_scene(path: &Path, add_mesh: AddMesh, options: &Options) -> Result<Animation, Error> {
    let text = read(path)?;
    let source = Source { path, text: &text };
    if looks_like_obj(&text) {
        return Err(Error::in_file(path, "it seems to be an OBJ: its name should end in .obj"));
    }
    let scene: SceneFile = toml::from_str(&text).map_err(|e| source.toml_error(e))?;
    let blame = |(offset, message): Fault| source.error(offset, message);
    scene.check_keys().map_err(blame)?;
    let frames = scene.frames().map_err(blame)?;
    let mut script = Script { frames, shutter: scene.shutter(), moving: scene.moves(), ..Script::default() };
    let mut assembly = Assembly::new(options);
    scene.ask_for_spheres(&assembly.room).map_err(blame)?;
    let mut names = BTreeMap::new();
    for (name, table) in &scene.materials {
        let index = assembly.add_named(table.material(), name);
        names.insert(name.as_str(), index);
        if !table.keys.is_empty() {
            script.glows.push(table.glow(index));
        }
    }
    let find = |name: &Spanned<String>| {
        let unknown = || format!("material \"{}\" is not among [materials]", name.get_ref());
        names.get(name.get_ref().as_str()).copied().ok_or_else(|| source.error(name.span().start, unknown()))
    };
    for mesh in &scene.meshes {
        let material = mesh.material.as_ref().map(find).transpose()?;
        script.paths.push(mesh.track().map_err(blame)?);
        let file = path.with_file_name(&mesh.file);
        if let (Some(command), false) = (&scene.made_by, file.exists()) {
            return Err(Error::in_file(&file, format!("not there: run `{command}` first")));
        }
        add_mesh(&mut assembly, &file, material)?;
        if let Some((from, to)) = mesh.long_turn() {
            let what = "angles differ by more than 180°: the mesh turns the short way";
            assembly.warn(format!("{}: from frame {from} to {to} {what}", mesh.file));
        }
    }
    for sphere in &scene.spheres {
        script.paths.push(sphere.track());
        add(&mut assembly, path, sphere.triangles(), find(&sphere.material)?);
    }
    for (number, light) in scene.lights.iter().enumerate() {
        let table = light.get_ref();
        table.placement(script.first_frame()).map_err(|m| source.error(light.span().start, m))?;
        script.paths.push(table.track());
        let material = assembly.add_named(table.material(), &format!("[[lights]] number {}", number + 1));
        add(&mut assembly, path, shapes::square(), material);
        script.glows.push(table.glow(material));
    }
    let camera = scene.camera.as_ref();
    let track = camera.map(|camera| {
        let track = camera.get_ref().track();
        let view = track.at(f64::from(script.first_frame()), DVec3::ZERO);
        view.map(|_| track).map_err(|m| source.error(camera.span().start, m))
    });
    script.camera = track.transpose()?.map(CameraPath::Keys);
    let mut shot = scene.shot();
    if let Some(table) = &scene.sky {
        let file = path.with_file_name(table.get_ref().file.as_deref().unwrap_or_default());
        let order = table.get_ref().order(&file, shot.cd_per_unit, table.span().start).map_err(blame)?;
        let (sky, warnings) = order.sky()?;
        warnings.into_iter().for_each(|warning| assembly.warn(warning));
        shot.sky = Some(sky);
    }
    assembly.finish(path, shot, options, script)
}

/// Adds triangles as an object.
fn add(
    assembly: &mut Assembly,
    path: &Path,
    triangles: impl IntoIterator<Item = [Corner; 3]>,
    material: u32,
) {
    assembly.begin(path, DVec3::ZERO);
    triangles.into_iter().for_each(|triangle| assembly.add(triangle, material));
}

impl SceneFile {
    fn shot(&self) -> Shot {
        let default = Shot::default();
        Shot {
            sky: None,
            width: self.film.width.map_or(default.width, |v| v.0),
            height: self.film.height.map_or(default.height, |v| v.0),
            cd_per_unit: self.film.cd_per_unit.map_or(default.cd_per_unit, |v| v.0),
            exposure: self.film.exposure.map_or(default.exposure, |v| v.0),
            spp: self.render.spp.map(Into::into),
            max_depth: self.render.max_depth.map(Into::into),
        }
    }

    /// Asks for room for all spheres, before any is made.
    fn ask_for_spheres(&self, room: &Room) -> Result<(), Fault> {
        self.spheres.iter().try_for_each(|sphere| {
            let (offset, count) = (sphere.subdivisions_at(), shapes::sphere_len(sphere.splits()));
            let room = room.take(count, Taker::Triangles);
            room.map_err(|message| (offset, format!("subdivisions: {message}")))
        })
    }

    /// Checks the order of all keys.
    fn check_keys(&self) -> Result<(), Fault> {
        self.camera.iter().try_for_each(|camera| keys::check(&camera.get_ref().keys))?;
        self.meshes.iter().try_for_each(|mesh| keys::check(&mesh.keys))?;
        self.spheres.iter().try_for_each(|sphere| keys::check(&sphere.keys))?;
        self.lights.iter().try_for_each(|light| keys::check(&light.get_ref().keys))?;
        self.materials.values().try_for_each(|material| keys::check(&material.keys))
    }

    /// The frames, which keys need.
    fn frames(&self) -> Result<Option<Frames>, Fault> {
        const DEFAULT_FPS: f32 = 24.0;
        let Some(table) = &self.frames else {
            return match self.first_key() {
                Some(offset) => Err((offset, "keys need a table [frames] with first and last".into())),
                None => Ok(None),
            };
        };
        let FramesTable { first, last, fps, shutter: _ } = table.get_ref();
        if first > last {
            return Err((
                table.span().start,
                format!("frames: the first, {first}, is after the last, {last}"),
            ));
        }
        Ok(Some(Frames { first: *first, last: *last, fps: fps.map_or(DEFAULT_FPS, |fps| fps.0) }))
    }

    /// Part of a frame's time in which the shutter is open.
    fn shutter(&self) -> f32 {
        self.frames.as_ref().and_then(|table| table.get_ref().shutter).map_or(0.0, |v| v.0)
    }

    /// Where the first key of any table stands.
    fn first_key(&self) -> Option<usize> {
        fn start<K>(keys: &Keys<K>) -> Option<usize> {
            keys.first().map(|key| key.span().start)
        }
        let camera = self.camera.iter().filter_map(|camera| start(&camera.get_ref().keys));
        let materials = self.materials.values().filter_map(|material| start(&material.keys));
        let lights = self.lights.iter().filter_map(|light| start(&light.get_ref().keys));
        let spheres = self.spheres.iter().filter_map(|sphere| start(&sphere.keys));
        let meshes = self.meshes.iter().filter_map(|mesh| start(&mesh.keys));
        camera.chain(materials).chain(lights).chain(spheres).chain(meshes).min()
    }

    /// Whether an object can move.
    fn moves(&self) -> bool {
        let lights = self.lights.iter().any(|light| !light.get_ref().keys.is_empty());
        lights
            || self.meshes.iter().any(|m| !m.keys.is_empty())
            || self.spheres.iter().any(|s| !s.keys.is_empty())
    }
}

impl SphereTable {
    fn splits(&self) -> u32 {
        const DEFAULT_SUBDIVISIONS: u32 = 6;
        self.subdivisions.as_ref().map_or(DEFAULT_SUBDIVISIONS, |s| s.get_ref().0)
    }

    /// Where the number of subdivisions stands, or else the sphere.
    fn subdivisions_at(&self) -> usize {
        self.subdivisions.as_ref().map_or(self.material.span().start, |s| s.span().start)
    }

    fn triangles(&self) -> Vec<[Corner; 3]> {
        shapes::sphere(self.splits())
    }
}

impl LightTable {
    /// Black where it does not shine.
    fn material(&self) -> Material {
        lamp(self.radiance.0)
    }
}

impl MaterialTable {
    fn material(&self) -> Material {
        let default = Material::default();
        let (scattering, specular) = match self.kind {
            Kind::Rough => (Scattering::Rough, default.specular),
            Kind::Mirror => (Scattering::Mirror, [1.0; 3]),
            Kind::Glass => (Scattering::Dielectric, [1.0; 3]),
        };
        Material {
            scattering,
            diffuse: self.diffuse.map_or(default.diffuse, |v| v.0),
            specular: self.specular.map_or(specular, |v| v.0),
            roughness: self.roughness.map_or(default.roughness, |v| v.0),
            ior: self.ior.map_or(default.ior, |v| v.0),
            emission: self.emission.map_or(default.emission, |v| v.0),
            ..default
        }
    }
}
