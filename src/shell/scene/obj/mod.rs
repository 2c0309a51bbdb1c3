//! Meshes from OBJ files.
//!
//! Convex polygons become fans, others are clipped into ears in their plane. A triangle without normals at all its
//! corners is flat. Colours of vertices (three numbers after the position, or ZBrush's `#MRGB`) are taken for sRGB, and
//! multiply `Kd` where there is no `map_Kd`. Groups and objects do not matter. Curves, free-form surfaces, points and
//! lines are left out and named.
//!
//! A line that means nothing (an index that leads nowhere, a face of two corners, a number that is none) is left out
//! with its faces, and said once with the number of its like; strictly taken it is an error.

mod complaints;
mod find;
mod lines;
mod maps;
mod material;
mod mtl;
mod polygon;
mod read;
mod stated;

use super::home;
use crate::scene::assemble::Assembly;
use crate::scene::error::{Error, read};
use crate::scene::object::Corner;
use complaints::Complaints;
use glam::{DVec3, Vec2, Vec3};
use pmcip_core::tracer::scene::{Material, NO_TEXTURE};
use read::{FACE_LEFT_OUT, NONE, Obj};
use std::path::Path;

const UV_LEFT_OUT: &str = "taken for 0 0";
const NORMAL_LEFT_OUT: &str = "taken as flat there";

/// Adds the triangles of an OBJ file as an object, all of one `material` if it is given.
pub(super) fn add_mesh(assembly: &mut Assembly, path: &Path, material: Option<u32>) -> Result<(), Error> {
    let text = read(path)?;
    let mut complaints = Complaints::new(path, assembly.strict);
    let mut obj = read::read(&text, &mut complaints)?;
    obj.drop_impossible(&mut complaints)?;
    if obj.faces.is_empty() {
        return Err(complaints.first().unwrap_or_else(|| Error::in_file(path, "no faces")));
    }
    obj.name_others(path, assembly);
    obj.make_colours_linear(path, assembly);
    let indices = match material {
        Some(index) => vec![index; obj.materials.len()],
        None => mtl::load(path, &obj, assembly)?,
    };
    complaints.warn(assembly);
    let triangles = obj.corners.len() - 2 * obj.faces.len();
    assembly.ask_for(triangles).map_err(|message| Error::in_file(path, message))?;
    obj.add_to(assembly, path, &indices, material);
    Ok(())
}

impl Obj<'_> {
    /// Leaves out faces of which a corner has no position, and attributes that are not there.
    fn drop_impossible(&mut self, complaints: &mut Complaints<'_>) -> Result<(), Error> {
        let (mut kept, mut used, mut start) = (0, 0, 0);
        for number in 0..self.faces.len() {
            let face = self.faces[number];
            let corners = start..face.end as usize;
            start = corners.end;
            if !self.is_possible(corners.clone(), face.line as usize, complaints)? {
                continue;
            }
            let count = corners.len();
            self.corners.copy_within(corners, used);
            used += count;
            self.faces[kept] = read::Face { end: used as u32, ..face };
            kept += 1;
        }
        self.faces.truncate(kept);
        self.corners.truncate(used);
        Ok(())
    }

    fn is_possible(
        &mut self,
        corners: std::ops::Range<usize>,
        line: usize,
        complaints: &mut Complaints<'_>,
    ) -> Result<bool, Error> {
        let (positions, uvs, normals) = (self.positions.len(), self.uvs.len(), self.normals.len());
        let wrong = |what: &str, index: u32, total: usize| {
            format!("face: {what} index {} is out of range, there are {total}", i64::from(index) + 1)
        };
        for [v, t, n] in &mut self.corners[corners] {
            match self.positions.get(*v as usize) {
                None => {
                    complaints.note(line, FACE_LEFT_OUT, || wrong("vertex", *v, positions))?;
                    return Ok(false);
                }
                Some(position) if !position.is_finite() => return Ok(false),
                Some(_) => {}
            }
            if *t != NONE && *t as usize >= uvs {
                complaints.note(line, UV_LEFT_OUT, || wrong("texture coordinate", *t, uvs))?;
                *t = NONE;
            }
            if *n != NONE && *n as usize >= normals {
                complaints.note(line, NORMAL_LEFT_OUT, || wrong("normal", *n, normals))?;
                *n = NONE;
            }
        }
        Ok(true)
    }

    /// Says what is no surface.
    fn name_others(&self, path: &Path, assembly: &mut Assembly) {
        if !self.others.is_empty() {
            let list: Vec<String> = self.others.iter().map(|(key, count)| format!("{count} {key}")).collect();
            let what = "points, lines and curves are left out";
            assembly.warn(format!("{}: {what}: {}", path.display(), list.join(", ")));
        }
    }

    /// Makes colours linear that are written as sRGB, in numbers up to 1 or 255.
    fn make_colours_linear(&mut self, path: &Path, assembly: &mut Assembly) {
        let most = self.colours.iter().fold(0.0f32, |most, colour| most.max(colour.max_element()));
        let scale = if most > 1.5 { 1.0 / 255.0 } else { 1.0 };
        if scale != 1.0 {
            assembly.warn(format!("{}: colours of vertices are taken as 0 to 255", path.display()));
        }
        for colour in &mut self.colours {
            let value = |v: f32| crate::scene::texture::linear((v * scale).clamp(0.0, 1.0));
            *colour = Vec3::new(value(colour.x), value(colour.y), value(colour.z));
        }
    }

    /// Where the object's own coordinates begin.
    fn home(&self) -> DVec3 {
        let used = self.corners.iter().map(|corner| self.positions[corner[0] as usize]);
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = used.fold(start, |(low, high), p| (low.min(p), high.max(p)));
        home::home(low, high)
    }

    /// Adds all triangles. `indices` are those of `self.materials`; `unnamed` is for faces of none.
    fn add_to(&self, assembly: &mut Assembly, path: &Path, indices: &[u32], mut unnamed: Option<u32>) {
        let home = self.home();
        assembly.begin(path, home);
        let (mut start, mut polygon, mut triangles) = (0, Vec::new(), Vec::new());
        for face in &self.faces {
            let corners = &self.corners[start..face.end as usize];
            start = face.end as usize;
            let material = match indices.get(face.material as usize) {
                Some(&index) => index,
                None => *unnamed.get_or_insert_with(|| assembly.add_material(self.unnamed())),
            };
            polygon.clear();
            polygon.extend(corners.iter().map(|corner| self.positions[corner[0] as usize]));
            polygon::triangles(&polygon, &mut triangles);
            let coloured = !self.colours.is_empty() && assembly.material(material).texture == NO_TEXTURE;
            for triangle in &triangles {
                let corner = |i: usize| self.corner(corners[i], polygon[i] - home);
                let colours = |i: usize| self.colours[corners[i][0] as usize].to_array();
                let colours = coloured.then(|| triangle.map(colours));
                assembly.add_coloured(triangle.map(corner), material, colours);
            }
        }
    }

    /// The material of faces that name none.
    fn unnamed(&self) -> Material {
        match self.colours.is_empty() {
            true => Material::default(),
            false => Material { diffuse: [1.0; 3], ..Material::default() },
        }
    }

    fn corner(&self, [_, t, n]: [u32; 3], position: DVec3) -> Corner {
        Corner {
            position: position.as_vec3(),
            normal: self.normals.get(n as usize).copied().unwrap_or(Vec3::ZERO),
            uv: self.uvs.get(t as usize).copied().unwrap_or(Vec2::ZERO),
        }
    }
}
