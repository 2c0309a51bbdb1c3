//! The scene file: what TOML may say, and what it means.

use super::assemble::{Assembly, Corner, Oddities, Shot};
use super::error::read;
use super::place::Placement;
use super::value::{FieldOfView, Point, Positive, Radiance, Reflectance, Scale, Size, Subdivisions, Unit};
use super::{Error, LoadedScene, View, obj, shapes};
use glam::Vec3;
use pmcip_core::scene::{Material, Scattering};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneFile {
    made_by: Option<String>,
    #[serde(default)]
    film: FilmTable,
    #[serde(default)]
    render: RenderTable,
    camera: Option<Spanned<CameraTable>>,
    #[serde(default)]
    meshes: Vec<MeshTable>,
    #[serde(default)]
    spheres: Vec<SphereTable>,
    #[serde(default)]
    lights: Vec<Spanned<LightTable>>,
    #[serde(default)]
    materials: BTreeMap<String, MaterialTable>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct FilmTable {
    width: Option<Size>,
    height: Option<Size>,
    cd_per_unit: Option<Positive>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct RenderTable {
    spp: Option<std::num::NonZeroU32>,
    max_depth: Option<std::num::NonZeroU32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraTable {
    from: Point,
    at: Point,
    up: Option<Point>,
    fov: FieldOfView,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MeshTable {
    file: String,
    translate: Option<Point>,
    rotate: Option<Point>,
    scale: Option<Scale>,
    material: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SphereTable {
    center: Point,
    radius: Positive,
    subdivisions: Option<Subdivisions>,
    material: Spanned<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LightTable {
    center: Point,
    edge_u: Point,
    edge_v: Point,
    radiance: Radiance,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MaterialTable {
    #[serde(default)]
    kind: Kind,
    diffuse: Option<Reflectance>,
    specular: Option<Reflectance>,
    roughness: Option<Unit>,
    ior: Option<Positive>,
    emission: Option<Radiance>,
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Kind {
    #[default]
    Rough,
    Mirror,
    Glass,
}

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
pub(super) fn load_scene(path: &Path) -> Result<LoadedScene, Error> {
    let text = read(path)?;
    let source = Source { path, text: &text };
    let scene: SceneFile = toml::from_str(&text).map_err(|e| source.toml_error(e))?;
    let mut assembly = Assembly::default();
    let names: BTreeMap<&str, u32> = scene
        .materials
        .iter()
        .map(|(name, m)| (name.as_str(), assembly.add_material(m.material())))
        .collect();
    let find = |name: &Spanned<String>| {
        let unknown = || format!("material \"{}\" is not among [materials]", name.get_ref());
        names.get(name.get_ref().as_str()).copied().ok_or_else(|| source.error(name.span().start, unknown()))
    };
    for mesh in &scene.meshes {
        let material = mesh.material.as_ref().map(find).transpose()?;
        let file = path.with_file_name(&mesh.file);
        if let (Some(command), false) = (&scene.made_by, file.exists()) {
            return Err(Error::in_file(&file, format!("not there: run `{command}` first")));
        }
        obj::add_mesh(&mut assembly, &file, &mesh.placement(), material)?;
    }
    for sphere in &scene.spheres {
        add(&mut assembly, path, sphere.triangles(), find(&sphere.material)?);
    }
    for light in &scene.lights {
        light.get_ref().add(&mut assembly, path).map_err(|m| source.error(light.span().start, m))?;
    }
    let view = scene
        .camera
        .as_ref()
        .map(|camera| camera.get_ref().view().map_err(|m| source.error(camera.span().start, m)));
    assembly.finish(path, scene.shot(view.transpose()?))
}

/// Adds triangles as they are.
fn add(
    assembly: &mut Assembly,
    path: &Path,
    triangles: impl IntoIterator<Item = [Corner; 3]>,
    material: u32,
) {
    let mut odd = Oddities::default();
    for triangle in triangles {
        assembly.add(triangle, &Placement::IDENTITY, material, &mut odd);
    }
    assembly.warn_oddities(path, odd);
}

impl SceneFile {
    fn shot(&self, view: Option<View>) -> Shot {
        let default = Shot::default();
        Shot {
            view,
            width: self.film.width.map_or(default.width, |v| v.0),
            height: self.film.height.map_or(default.height, |v| v.0),
            cd_per_unit: self.film.cd_per_unit.map_or(default.cd_per_unit, |v| v.0),
            spp: self.render.spp.map(Into::into),
            max_depth: self.render.max_depth.map(Into::into),
            soft_box: false,
        }
    }
}

impl CameraTable {
    fn view(&self) -> Result<View, &'static str> {
        let up = self.up.map_or(Vec3::Y, |up| up.vec3());
        let forward = (self.at.vec3() - self.from.vec3())
            .try_normalize()
            .ok_or("camera: from and at are the same point")?;
        let upward = up.try_normalize().ok_or("camera: up has no direction")?;
        if forward.cross(upward).length() < 1e-5 {
            return Err("camera: up is parallel to the view");
        }
        Ok(View { from: self.from.0, at: self.at.0, up: up.to_array(), fov: self.fov.0 })
    }
}

impl MeshTable {
    fn placement(&self) -> Placement {
        let vector = |v: Option<Point>| v.map_or(Vec3::ZERO, |v| v.vec3());
        let scale = self.scale.map_or(Vec3::ONE, Scale::factors);
        Placement::new(scale, vector(self.rotate), vector(self.translate))
    }
}

impl SphereTable {
    fn triangles(&self) -> Vec<[Corner; 3]> {
        const DEFAULT_SUBDIVISIONS: u32 = 6;
        let subdivisions = self.subdivisions.map_or(DEFAULT_SUBDIVISIONS, |s| s.0);
        shapes::sphere(self.center.vec3(), self.radius.0, subdivisions)
    }
}

impl LightTable {
    /// Adds the rectangle.
    fn add(&self, assembly: &mut Assembly, path: &Path) -> Result<(), &'static str> {
        let (u, v) = (self.edge_u.vec3(), self.edge_v.vec3());
        if u.cross(v).length_squared() <= 1e-12 * u.length_squared() * v.length_squared() {
            return Err("lights: edge_u and edge_v span no area");
        }
        assembly.add_lamp(path, self.center.vec3(), [u, v], self.radiance.0);
        Ok(())
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
