//! What TOML may say.

use super::keys::{CameraKey, Keys, LightKey, MaterialKey, MeshKey, SphereKey};
use super::value::{
    Exposure, FieldOfView, Part, Point, Positive, Power, Radiance, Reflectance, Roughness, Scale, Size,
    Subdivisions,
};
use crate::scene::track::Interpolation;
use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneFile {
    pub made_by: Option<String>,
    #[serde(default)]
    pub film: FilmTable,
    #[serde(default)]
    pub render: RenderTable,
    pub frames: Option<Spanned<FramesTable>>,
    pub camera: Option<Spanned<CameraTable>>,
    pub sky: Option<Spanned<SkyTable>>,
    #[serde(default)]
    pub meshes: Vec<MeshTable>,
    #[serde(default)]
    pub spheres: Vec<SphereTable>,
    #[serde(default)]
    pub lights: Vec<Spanned<LightTable>>,
    #[serde(default)]
    pub materials: BTreeMap<String, MaterialTable>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FilmTable {
    pub width: Option<Size>,
    pub height: Option<Size>,
    pub cd_per_unit: Option<Positive>,
    pub exposure: Option<Exposure>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RenderTable {
    pub spp: Option<std::num::NonZeroU32>,
    pub max_depth: Option<std::num::NonZeroU32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FramesTable {
    pub first: u32,
    pub last: u32,
    pub fps: Option<Positive>,
    pub shutter: Option<Part>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CameraTable {
    pub from: Point,
    pub at: Point,
    pub up: Option<Point>,
    pub fov: FieldOfView,
    pub aperture: Option<Power>,
    pub focus: Option<Positive>,
    #[serde(default)]
    pub interpolation: Interpolation,
    #[serde(default)]
    pub keys: Keys<CameraKey>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MeshTable {
    pub file: String,
    pub translate: Option<Point>,
    pub rotate: Option<Point>,
    pub scale: Option<Scale>,
    pub material: Option<Spanned<String>>,
    #[serde(default)]
    pub interpolation: Interpolation,
    #[serde(default)]
    pub keys: Keys<MeshKey>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SphereTable {
    pub center: Point,
    pub radius: Positive,
    pub subdivisions: Option<Spanned<Subdivisions>>,
    pub material: Spanned<String>,
    #[serde(default)]
    pub interpolation: Interpolation,
    #[serde(default)]
    pub keys: Keys<SphereKey>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LightTable {
    pub center: Point,
    pub edge_u: Point,
    pub edge_v: Point,
    pub radiance: Radiance,
    pub power: Option<Power>,
    #[serde(default)]
    pub interpolation: Interpolation,
    #[serde(default)]
    pub keys: Keys<LightKey>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MaterialTable {
    #[serde(default)]
    pub kind: Kind,
    pub diffuse: Option<Reflectance>,
    pub specular: Option<Reflectance>,
    pub roughness: Option<Roughness>,
    pub ior: Option<Positive>,
    pub emission: Option<Radiance>,
    #[serde(default)]
    pub interpolation: Interpolation,
    #[serde(default)]
    pub keys: Keys<MaterialKey>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SkyTable {
    pub file: Option<String>,
    pub color: Option<Radiance>,
    pub sun: Option<Point>,
    pub haze: Option<Power>,
    pub ground: Option<Reflectance>,
    pub scale: Option<Power>,
    pub rotate: Option<Point>,
    #[serde(default = "yes")]
    pub visible: bool,
}

fn yes() -> bool {
    true
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Kind {
    #[default]
    Rough,
    Mirror,
    Glass,
}
