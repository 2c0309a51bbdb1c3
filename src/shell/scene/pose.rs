//! Puts the triangles of all objects where a frame wants them, and builds the hierarchy over them.

use super::bvh;
use super::model::Moved;
use super::object::{Corner, NO_UVS, Object, Piece};
use super::place::Placement;
use glam::Vec3;
use pmcip_core::tracer::scene::{Node8, Surface, Triangle};
use std::collections::BTreeMap;
use std::path::Path;

/// The height of a triangle over its longest edge below which it is a line to `f32` arithmetic.
const DEGENERATE_HEIGHT: f64 = 1e-6;

/// How far a shading normal may lean towards the back: its least cosine with the geometric normal.
const LEAST_COSINE: f32 = 0.01;

/// All objects in their places.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    pub nodes: Vec<Node8>,
    pub leaves: Vec<f32>,
    pub triangles: Vec<Triangle>,
    pub surfaces: Vec<Surface>,
    /// Colours of the corners of each triangle; empty if no object has any.
    pub colours: Vec<[[f32; 3]; 3]>,
    /// Second texture coordinates, as those of [`Object`].
    pub second: Vec<[[f32; 2]; 3]>,
    /// The object of each triangle.
    pub objects: Vec<u32>,
    /// The triangles as the shutter closes.
    pub moved: Moved,
    /// The box around all triangles.
    pub bounds: (Vec3, Vec3),
    pub warnings: Vec<String>,
}

/// What was odd about the triangles of one file.
#[derive(Debug, Default)]
struct Oddities {
    degenerate: usize,
    backward: usize,
}

/// Poses `objects`, each by its placement and that as the shutter closes, and builds the hierarchy.
///
/// # Errors
/// If nothing has an area, or a vertex is at infinity.
pub(super) fn pose(
    objects: &[Object],
    placements: &[Placement],
    closing: &[Placement],
) -> Result<Geometry, &'static str> {
    let mut geometry = place(objects, placements, closing)?;
    geometry.sort();
    Ok(geometry)
}

/// Poses `objects`; there is no hierarchy yet.
///
/// # Errors
/// If nothing has an area, or a vertex is at infinity.
pub(super) fn place(
    objects: &[Object],
    placements: &[Placement],
    closing: &[Placement],
) -> Result<Geometry, &'static str> {
    let mut geometry = Geometry::default();
    let moves = placements != closing;
    let coloured = objects.iter().any(|object| !object.colours.is_empty());
    let twice = objects.iter().any(|object| !object.second.is_empty());
    let mut odd: BTreeMap<&Path, Oddities> = BTreeMap::new();
    for (number, (object, (placement, closing))) in
        objects.iter().zip(placements.iter().zip(closing)).enumerate()
    {
        let odd = odd.entry(&object.source).or_default();
        for (i, piece) in object.pieces.iter().enumerate() {
            if !geometry.add(piece, placement, number as u32, odd) {
                continue;
            }
            if moves {
                geometry.add_moved(piece, placement, closing);
            }
            if coloured {
                let colours = object.colours.get(i).copied().unwrap_or([[1.0; 3]; 3]);
                geometry.colours.push(turned(colours, placement));
            }
            if twice {
                geometry.second.push(turned(object.second.get(i).copied().unwrap_or(NO_UVS), placement));
            }
        }
    }
    odd.into_iter().for_each(|(source, odd)| geometry.warn(source, odd));
    if geometry.triangles.is_empty() {
        return Err("the scene is empty: no triangle has an area");
    }
    geometry.bounds = bounds(&geometry.triangles);
    let is_finite = |(low, high): (Vec3, Vec3)| low.is_finite() && high.is_finite();
    if !(is_finite(geometry.bounds) && (!moves || is_finite(bounds(&geometry.moved.triangles)))) {
        return Err("a transform moves a vertex to infinity");
    }
    Ok(geometry)
}

impl Geometry {
    /// Adds a triangle, or counts it if it has no area; whether it has added it.
    fn add(&mut self, piece: &Piece, placement: &Placement, object: u32, odd: &mut Oddities) -> bool {
        let placed = turned(placed(piece, placement), placement);
        let positions = placed.map(|c| c.position);
        let Some(front) = front_of(positions) else {
            odd.degenerate += 1;
            return false;
        };
        let normals = shading_normals(placed.map(|c| c.normal), front, odd);
        self.triangles.push(Triangle { corners: positions.map(|p| p.to_array()) });
        self.surfaces.push(Surface {
            normals: normals.map(|n| n.to_array()),
            uv: placed.map(|c| c.uv.to_array()),
            material: piece.material,
        });
        self.objects.push(object);
        true
    }

    /// Adds where the triangle added last is as the shutter closes: the same corners in the same order, whatever its shape is
    /// by then.
    fn add_moved(&mut self, piece: &Piece, placement: &Placement, closing: &Placement) {
        let placed = turned(placed(piece, closing), placement);
        let positions = placed.map(|c| c.position);
        let normals = front_of(positions)
            .map(|front| shading_normals(placed.map(|c| c.normal), front, &mut Oddities::default()));
        self.moved.triangles.push(Triangle { corners: positions.map(|p| p.to_array()) });
        self.moved.normals.push(normals.unwrap_or_default().map(|n| n.to_array()));
    }

    /// Reports what was odd about the objects of a file.
    fn warn(&mut self, source: &Path, odd: Oddities) {
        let name = source.display();
        if odd.degenerate > 0 {
            self.warnings.push(format!("{name}: {} triangles without area left out", odd.degenerate));
        }
        if odd.backward > 0 {
            let count = odd.backward;
            let what = "triangles have normals on the back of their winding; turned";
            self.warnings.push(format!("{name}: {count} {what}"));
        }
    }

    /// Builds the hierarchy and brings everything into the order of its leaves.
    pub fn sort(&mut self) {
        let bvh = bvh::build(&self.triangles, &self.moved.triangles);
        self.triangles = bvh.order.iter().map(|&i| self.triangles[i as usize]).collect();
        self.surfaces = bvh.order.iter().map(|&i| self.surfaces[i as usize]).collect();
        if !self.colours.is_empty() {
            self.colours = bvh.order.iter().map(|&i| self.colours[i as usize]).collect();
        }
        if !self.second.is_empty() {
            self.second = bvh.order.iter().map(|&i| self.second[i as usize]).collect();
        }
        if !self.moved.triangles.is_empty() {
            let Moved { triangles, leaves, normals } = &mut self.moved;
            *triangles = bvh.order.iter().map(|&i| triangles[i as usize]).collect();
            *normals = bvh.order.iter().map(|&i| normals[i as usize]).collect();
            *leaves = bvh::leaves(&bvh.nodes, triangles);
        }
        self.objects = bvh.order.iter().map(|&i| self.objects[i as usize]).collect();
        self.leaves = bvh::leaves(&bvh.nodes, &self.triangles);
        self.nodes = bvh.nodes;
    }
}

/// A triangle's corners where it is placed.
fn placed(piece: &Piece, placement: &Placement) -> [Corner; 3] {
    piece.corners.map(|c| Corner {
        position: placement.position(c.position),
        normal: placement.normal(c.normal).normalize_or_zero(),
        uv: c.uv,
    })
}

/// What belongs to corners, in the order that makes them counter-clockwise where they are placed.
fn turned<T>(mut of_corners: [T; 3], placement: &Placement) -> [T; 3] {
    if placement.is_mirrored() {
        of_corners.swap(1, 2);
    }
    of_corners
}

/// The box around all triangles.
fn bounds(triangles: &[Triangle]) -> (Vec3, Vec3) {
    let positions = triangles.iter().flat_map(|t| t.corners).map(Vec3::from);
    positions.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
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
