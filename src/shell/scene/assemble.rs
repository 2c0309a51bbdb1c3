//! Collects triangles, materials and textures from all sources and puts the scene together.

use super::place::Placement;
use super::texture::TextureCache;
use super::{Error, LoadedScene, View, bvh};
use glam::{Vec2, Vec3};
use pmcip_core::scene::{Light, LightNode8, Material, Surface, Triangle};
use pmcip_core::shade::{light, light_tree};
use std::path::Path;

/// The vertical field of view of the automatic camera: that of the Cornell box.
pub(super) const DEFAULT_FOV: f32 = 39.3;

/// The height of a triangle over its longest edge below which it is a line to `f32` arithmetic.
const DEGENERATE_HEIGHT: f64 = 1e-6;

/// How far a shading normal may lean towards the back: its least cosine with the geometric normal.
const LEAST_COSINE: f32 = 0.01;

/// A corner of a triangle; a zero normal means that the source has none.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Corner {
    pub position: Vec3,
    pub normal: Vec3,
    pub uv: Vec2,
}

/// What the scene file or the lack of one says about the image.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shot {
    pub view: Option<View>,
    pub width: u32,
    pub height: u32,
    pub cd_per_unit: f32,
    pub spp: Option<u32>,
    pub max_depth: Option<u32>,
}

impl Default for Shot {
    fn default() -> Self {
        Shot { view: None, width: 512, height: 512, cd_per_unit: 100.0, spp: None, max_depth: None }
    }
}

/// A scene in the making.
#[derive(Debug, Default)]
pub(super) struct Assembly {
    triangles: Vec<Triangle>,
    surfaces: Vec<Surface>,
    materials: Vec<Material>,
    pub textures: TextureCache,
    warnings: Vec<String>,
}

/// What was odd about the triangles of one mesh.
#[derive(Debug, Default)]
pub(super) struct Oddities {
    degenerate: usize,
    backward: usize,
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

    /// Adds a triangle, or counts it if it has no area.
    pub fn add(&mut self, corners: [Corner; 3], placement: &Placement, material: u32, odd: &mut Oddities) {
        let mut placed = corners.map(|c| Corner {
            position: placement.position(c.position),
            normal: placement.normal(c.normal).normalize_or_zero(),
            uv: c.uv,
        });
        if placement.is_mirrored() {
            placed.swap(1, 2);
        }
        let positions = placed.map(|c| c.position);
        let Some(front) = front_of(positions) else {
            odd.degenerate += 1;
            return;
        };
        let normals = shading_normals(placed.map(|c| c.normal), front, odd);
        self.triangles.push(Triangle { corners: positions.map(|p| p.to_array()) });
        self.surfaces.push(Surface {
            normals: normals.map(|n| n.to_array()),
            uv: placed.map(|c| c.uv.to_array()),
            material,
        });
    }

    /// Reports what was odd about a mesh.
    pub fn warn_oddities(&mut self, path: &Path, odd: Oddities) {
        let name = path.display();
        if odd.degenerate > 0 {
            self.warn(format!("{name}: {} triangles without area left out", odd.degenerate));
        }
        if odd.backward > 0 {
            let count = odd.backward;
            self.warn(format!("{name}: {count} triangles have normals on the back of their winding; turned"));
        }
    }

    /// Builds the hierarchy and the lights, and frames the view if there is none.
    pub fn finish(mut self, path: &Path, shot: Shot) -> Result<LoadedScene, Error> {
        if self.triangles.is_empty() {
            return Err(Error::in_file(path, "the scene is empty: no triangle has an area"));
        }
        let bounds = self.bounds();
        if !(bounds.0.is_finite() && bounds.1.is_finite()) {
            return Err(Error::in_file(path, "a transform moves a vertex to infinity"));
        }
        let bvh = bvh::build(&self.triangles);
        self.triangles = bvh.order.iter().map(|&i| self.triangles[i as usize]).collect();
        self.surfaces = bvh.order.iter().map(|&i| self.surfaces[i as usize]).collect();
        let mut lights = vec![Default::default(); light::count(&self.surfaces, &self.materials)];
        let used = light::build(&self.triangles, &self.surfaces, &self.materials, &mut lights);
        lights.truncate(used);
        let light_nodes = light_tree(&self.triangles, &self.surfaces, &self.materials, &mut lights);
        let (textures, texels) = self.textures.into_parts();
        Ok(LoadedScene {
            name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            path: path.to_owned(),
            nodes: bvh.nodes,
            triangles: self.triangles,
            surfaces: self.surfaces,
            materials: self.materials,
            textures,
            texels,
            lights,
            light_nodes,
            view: shot.view.unwrap_or_else(|| frame(bounds, shot.width, shot.height)),
            width: shot.width,
            height: shot.height,
            cd_per_unit: shot.cd_per_unit,
            spp: shot.spp,
            max_depth: shot.max_depth,
            warnings: self.warnings,
        })
    }

    /// The box around all triangles.
    fn bounds(&self) -> (Vec3, Vec3) {
        let positions = self.triangles.iter().flat_map(|t| t.corners).map(Vec3::from);
        positions.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
    }
}

/// Tree over the lights, and their places in it.
fn light_tree(
    triangles: &[Triangle],
    surfaces: &[Surface],
    materials: &[Material],
    lights: &mut [Light],
) -> Vec<LightNode8> {
    let mut nodes = vec![LightNode8::default(); light_tree::required(lights.len())];
    let mut order = vec![0; lights.len()];
    let used = light_tree::build(triangles, surfaces, materials, lights, &mut order, &mut nodes);
    nodes.truncate(used);
    nodes
}

/// The unit normal of the side from which the corners run counter-clockwise; none without an area.
fn front_of([a, b, c]: [Vec3; 3]) -> Option<Vec3> {
    let (u, v) = ((b - a).as_dvec3(), (c - a).as_dvec3());
    let area = u.cross(v);
    let longest_squared = u.length_squared().max(v.length_squared()).max((u - v).length_squared());
    let slender = area.length() <= DEGENERATE_HEIGHT * longest_squared;
    let in_f32 = (b - a).cross(c - a).length_squared();
    (!slender && in_f32.is_normal()).then(|| area.normalize().as_vec3())
}

/// Normals on the front side, or none if a corner has none.
fn shading_normals(normals: [Vec3; 3], front: Vec3, odd: &mut Oddities) -> [Vec3; 3] {
    if normals.iter().any(|n| *n == Vec3::ZERO || !n.is_finite()) {
        return [Vec3::ZERO; 3];
    }
    let backward = normals.iter().map(|n| n.dot(front)).sum::<f32>() < 0.0;
    odd.backward += usize::from(backward);
    let sign = if backward { -1.0 } else { 1.0 };
    normals.map(|n| raised(sign * n, front))
}

/// A normal that leans to the back, raised to the front.
fn raised(normal: Vec3, front: Vec3) -> Vec3 {
    let cosine = normal.dot(front);
    if cosine >= LEAST_COSINE {
        return normal;
    }
    let along = (normal - cosine * front).normalize_or_zero();
    along * (1.0 - LEAST_COSINE * LEAST_COSINE).sqrt() + front * LEAST_COSINE
}

/// A view along −z that holds the whole box.
fn frame((low, high): (Vec3, Vec3), width: u32, height: u32) -> View {
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
    }
}
