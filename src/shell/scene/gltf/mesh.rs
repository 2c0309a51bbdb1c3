//! Triangles of a glTF mesh.

use super::data::Data;
use super::material::Look;
use crate::scene::assemble::Assembly;
use crate::scene::home;
use crate::scene::notes::Notes;
use crate::scene::object::{Corner, Extras};
use crate::scene::place::Placement;
use glam::{DAffine3, DVec3, Vec2, Vec3};
use gltf::mesh::Mode;
use gltf::{Mesh, Primitive, Semantic};
use std::collections::HashMap;

/// Triangles of one material.
pub(super) struct Part {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    /// The sets of texture coordinates, as written; those that are not there are empty.
    sets: [Vec<Vec2>; 2],
    colours: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

/// The triangles of a mesh, primitive by primitive.
///
/// # Errors
/// If numbers are not there.
pub(super) fn parts(mesh: &Mesh<'_>, data: &Data, notes: &mut Notes) -> Result<Vec<Option<Part>>, String> {
    let number = mesh.index();
    let parts = mesh.primitives().enumerate().map(|(i, primitive)| {
        part(&primitive, data, notes).map_err(|message| format!("mesh {number}, primitive {i}: {message}"))
    });
    parts.collect()
}

fn part(primitive: &Primitive<'_>, data: &Data, notes: &mut Notes) -> Result<Option<Part>, String> {
    if primitive.morph_targets().len() > 0 {
        notes.add("morph", || "morph targets are left out: meshes have their own shape".into());
    }
    let Some(order) = order(primitive.mode()) else {
        notes.add("lines", || "points and lines are left out".into());
        return Ok(None);
    };
    let Some(positions) = primitive.get(&Semantic::Positions) else {
        notes.add("positions", || "primitives without positions are left out".into());
        return Ok(None);
    };
    let positions: Vec<Vec3> = data.vectors::<3>(&positions)?.into_iter().map(Vec3::from).collect();
    let count = positions.len();
    let normals = attribute(primitive, Semantic::Normals, count, |a| data.vectors::<3>(a))?;
    let set = |n: u32| attribute(primitive, Semantic::TexCoords(n), count, |a| data.vectors::<2>(a));
    let vectors = |list: Vec<[f32; 2]>| list.into_iter().map(Vec2::from).collect();
    let colours = attribute(primitive, Semantic::Colors(0), count, |a| colours(a, data))?;
    if colours.iter().any(|c| c[3] < 1.0) {
        notes.add("vertex alpha", || "the alpha of colours of vertices is without effect here".into());
    }
    let corners = match primitive.indices() {
        Some(indices) => data.indices(&indices)?,
        None => (0..count as u32).collect(),
    };
    let mut triangles = order(&corners);
    let before = triangles.len();
    triangles.retain(|triangle| {
        triangle.iter().all(|i| positions.get(*i as usize).is_some_and(|p| p.is_finite()))
    });
    if triangles.len() < before {
        let lost = before - triangles.len();
        let what = "triangles have corners that are not there or no numbers: left out";
        notes.add("corners", || format!("{lost} {what}"));
    }
    Ok(Some(Part {
        positions,
        normals: normals.into_iter().map(Vec3::from).collect(),
        sets: [vectors(set(0)?), vectors(set(1)?)],
        colours: colours.into_iter().map(|[r, g, b, _]| [r, g, b].map(unit)).collect(),
        triangles,
    }))
}

fn unit(value: f32) -> f32 {
    if value.is_finite() { value.clamp(0.0, 1.0) } else { 1.0 }
}

/// An attribute, empty if the primitive has none.
fn attribute<T>(
    primitive: &Primitive<'_>,
    semantic: Semantic,
    count: usize,
    read: impl Fn(&gltf::Accessor<'_>) -> Result<Vec<T>, String>,
) -> Result<Vec<T>, String> {
    let Some(accessor) = primitive.get(&semantic) else { return Ok(Vec::new()) };
    let values = read(&accessor)?;
    match values.len() == count {
        true => Ok(values),
        false => Err(format!("{} of {} for {count} positions", values.len(), semantic.to_string())),
    }
}

/// Linear colours of vertices, opaque where they have no alpha.
fn colours(accessor: &gltf::Accessor<'_>, data: &Data) -> Result<Vec<[f32; 4]>, String> {
    match accessor.dimensions() {
        gltf::accessor::Dimensions::Vec3 => {
            Ok(data.vectors::<3>(accessor)?.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect())
        }
        _ => data.vectors::<4>(accessor),
    }
}

/// How corners become triangles.
type Order = fn(&[u32]) -> Vec<[u32; 3]>;

fn order(mode: Mode) -> Option<Order> {
    match mode {
        Mode::Triangles => Some(|corners| corners.as_chunks::<3>().0.to_vec()),
        Mode::TriangleStrip => Some(|corners| {
            // Every other triangle of a strip runs the other way round.
            let turned =
                |(i, c): (usize, &[u32])| if i % 2 == 0 { [c[0], c[1], c[2]] } else { [c[0], c[2], c[1]] };
            corners.windows(3).enumerate().map(turned).collect()
        }),
        Mode::TriangleFan => Some(|corners| {
            let rim = corners.get(1..).unwrap_or_default();
            rim.windows(2).map(|pair| [pair[0], pair[1], corners[0]]).collect()
        }),
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => None,
    }
}

impl Part {
    /// Whether it has no border: every edge belongs to two triangles that run along it in opposite ways.
    pub fn is_closed(&self) -> bool {
        let mut edges: HashMap<[[u32; 3]; 2], i32> = HashMap::new();
        // A zero is a zero, whatever its sign.
        let key = |i: u32| self.positions[i as usize].to_array().map(|x| (x + 0.0).to_bits());
        for &[a, b, c] in &self.triangles {
            for [from, to] in [[a, b], [b, c], [c, a]].map(|edge| edge.map(key)) {
                let (edge, way) = if from < to { ([from, to], 1) } else { ([to, from], -1) };
                *edges.entry(edge).or_default() += way;
            }
        }
        !edges.is_empty() && edges.values().all(|ways| *ways == 0)
    }

    /// All corners in use.
    fn used(&self) -> impl Iterator<Item = DVec3> {
        self.triangles.iter().flatten().map(|i| self.positions[*i as usize].as_dvec3())
    }

    /// Adds all triangles to the object begun last.
    pub fn add_to(&self, assembly: &mut Assembly, look: &Look, site: &Site) {
        let set = self.sets.get(look.set as usize).filter(|set| !set.is_empty());
        let corner = |i: u32| {
            let i = i as usize;
            let uv = set.map_or(Vec2::ZERO, |set| set[i]);
            let normal = self.normals.get(i).copied().unwrap_or(Vec3::ZERO);
            Corner {
                position: (site.map.transform_point3(self.positions[i].as_dvec3()) - site.home).as_vec3(),
                normal: site.placement.normal(normal),
                uv: upwards(look.turn.map_or(uv, |turn| turn.apply(uv))),
            }
        };
        let colours = Some(&self.colours).filter(|colours| !colours.is_empty() && look.coloured);
        let second = Some(&self.sets[1]).filter(|set| !set.is_empty());
        for &[a, b, c] in &self.triangles {
            let triangle = if site.placement.is_mirrored() { [a, c, b] } else { [a, b, c] };
            let extras = Extras {
                colours: colours.map(|colours| triangle.map(|i| colours[i as usize])),
                second: second.map(|set| triangle.map(|i| upwards(set[i as usize]).to_array())),
            };
            assembly.add_with(triangle.map(corner), look.material, extras);
        }
    }

    /// Names what a look needs that is not there.
    pub fn note_missing(&self, look: &Look, notes: &mut Notes) {
        if look.textured && self.sets.get(look.set as usize).is_none_or(Vec::is_empty) {
            let set = look.set;
            notes.add("coordinates", || {
                format!("textures without TEXCOORD_{set}, or of a set beyond 1, show one place")
            });
        }
        if look.tinted && !self.colours.is_empty() {
            notes.add("tint", || "colours of vertices do not tint metal and glass here".into());
        }
    }

    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }
}

/// Where corners go: by a map, relative to a home.
pub(super) struct Site {
    map: DAffine3,
    placement: Placement,
    home: DVec3,
}

impl Site {
    pub fn new(map: DAffine3, home: DVec3) -> Site {
        Site { map, placement: Placement::affine(map), home }
    }
}

/// Texture coordinates with v upwards.
fn upwards(uv: Vec2) -> Vec2 {
    let uv = Vec2::new(uv.x, 1.0 - uv.y);
    if uv.is_finite() { uv } else { Vec2::ZERO }
}

/// Where the coordinates of an object begin whose parts are mapped like this.
pub(super) fn home_of(places: &[(&Vec<Option<Part>>, DAffine3)]) -> DVec3 {
    let points = places.iter().flat_map(|(parts, map)| {
        parts.iter().flatten().flat_map(Part::used).map(|point| map.transform_point3(point))
    });
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = points.fold(start, |(low, high), p| (low.min(p), high.max(p)));
    home::home(low, high)
}
