//! The statements of an OBJ file, as arrays.
//!
//! Numbers are read in double precision: geo-referenced models have coordinates of millions. What a line cannot mean is
//! left out with a complaint; what is not a surface (points, lines, curves) is counted.

use super::complaints::Complaints;
use super::lines::{data, logical_lines, split};
use crate::scene::error::Error;
use glam::{DVec3, Vec2, Vec3};
use std::collections::HashMap;

/// An index that is not given.
pub(super) const NONE: u32 = u32::MAX;

/// What became of lines.
pub(super) const FACE_LEFT_OUT: &str = "face left out";
const NO_UV: &str = "texture coordinate taken for 0 0";
const NO_NORMAL: &str = "normal left out";
const NOT_A_VERTEX: &str = "vertex and its faces left out";
const IGNORED: &str = "line left out";

/// The arrays of an OBJ file.
#[derive(Debug, Default)]
pub(super) struct Obj<'a> {
    pub positions: Vec<DVec3>,
    /// Colours of the vertices as written; empty, or white where a vertex has none.
    pub colours: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    pub normals: Vec<Vec3>,
    /// Corners of all faces: indices of position, texture coordinate and normal.
    pub corners: Vec<[u32; 3]>,
    pub faces: Vec<Face>,
    /// The arguments of `mtllib` lines.
    pub libraries: Vec<String>,
    /// The materials in use, in order of their first appearance.
    pub materials: Vec<String>,
    /// Statements that make no surface, and how many there are.
    pub others: Vec<(&'a str, usize)>,
    /// Colours that ZBrush hides in comments.
    painted: Vec<Vec3>,
}

/// A face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    /// Where its corners end; they begin where those of the face before do.
    pub end: u32,
    /// Index of its material, or [`NONE`].
    pub material: u32,
    /// Its line.
    pub line: u32,
}

/// Reads the text of an OBJ file.
///
/// # Errors
/// The first complaint, where files are taken strictly.
pub(super) fn read<'a>(source: &'a str, complaints: &mut Complaints<'_>) -> Result<Obj<'a>, Error> {
    let mut reader = Reader { obj: Obj::default(), material: NONE, names: HashMap::new(), complaints };
    let mut others: HashMap<String, usize> = HashMap::new();
    for (number, line) in logical_lines(source) {
        let (key, rest) = split(&line);
        match key {
            "v" => reader.vertex(number, rest)?,
            "vt" => reader.uv(number, rest)?,
            "vn" => reader.normal(number, rest)?,
            "f" | "fo" => reader.face(number, rest)?,
            "usemtl" => reader.use_material(number, rest)?,
            "mtllib" => reader.obj.libraries.push(rest.to_owned()),
            "#MRGB" => reader.paint(rest),
            "l" | "p" | "curv" | "curv2" | "surf" | "call" => *others.entry(key.to_owned()).or_default() += 1,
            _ => {}
        }
    }
    let mut obj = reader.obj;
    if obj.colours.is_empty() && obj.painted.len() >= obj.positions.len() {
        obj.colours = std::mem::take(&mut obj.painted);
    }
    if !obj.colours.is_empty() {
        obj.colours.resize(obj.positions.len(), Vec3::ONE);
    }
    let names = ["curv", "curv2", "surf", "call", "l", "p"].into_iter();
    obj.others = names.filter_map(|name| Some((name, *others.get(name)?))).collect();
    Ok(obj)
}

struct Reader<'r, 'a, 'c> {
    obj: Obj<'a>,
    /// The material of the faces that follow.
    material: u32,
    names: HashMap<String, u32>,
    complaints: &'r mut Complaints<'c>,
}

/// A number; one with a comma for its point, as some countries write it, counts.
fn number(word: &str) -> Option<f64> {
    let value = word.parse::<f64>().or_else(|error| match word.matches(',').count() {
        1 => word.replace(',', ".").parse::<f64>(),
        _ => Err(error),
    });
    value.ok().filter(|value| value.abs() <= f64::from(f32::MAX))
}

/// Fills `values` from the front; returns how many there are, or what is wrong with one.
fn numbers(text: &str, values: &mut [f64]) -> Result<usize, String> {
    let mut found = 0;
    for (value, word) in values.iter_mut().zip(data(text).split_ascii_whitespace()) {
        *value = number(word).ok_or_else(|| format!("expected a finite number, found \"{word}\""))?;
        found += 1;
    }
    Ok(found)
}

/// As many numbers as there is room for, at least `least`.
fn at_least<const N: usize>(text: &str, least: usize) -> Result<[f64; N], String> {
    let mut values = [0.0; N];
    match numbers(text, &mut values)? {
        found if found < least => Err(format!("expected {least} numbers, found {found}")),
        _ => Ok(values),
    }
}

impl Reader<'_, '_, '_> {
    fn vertex(&mut self, line: usize, text: &str) -> Result<(), Error> {
        let mut values = [0.0; 6];
        let position = at_least::<3>(text, 3);
        let position = position.map(DVec3::from).or_else(|message| {
            let complaint = || format!("vertex: {message}");
            self.complaints.note(line, NOT_A_VERTEX, complaint).map(|()| DVec3::NAN)
        })?;
        // Three numbers more are a colour; one is a weight that only curves have.
        if position.is_finite() && numbers(text, &mut values).is_ok_and(|found| found == 6) {
            self.obj.colours.resize(self.obj.positions.len(), Vec3::ONE);
            self.obj.colours.push(DVec3::new(values[3], values[4], values[5]).as_vec3());
        }
        self.obj.positions.push(position);
        Ok(())
    }

    fn uv(&mut self, line: usize, text: &str) -> Result<(), Error> {
        let uv = at_least::<2>(text, 1).or_else(|message| {
            let complaint = || format!("texture coordinate: {message}");
            self.complaints.note(line, NO_UV, complaint).map(|()| [0.0; 2])
        })?;
        self.obj.uvs.push(Vec2::from(uv.map(|v| v as f32)));
        Ok(())
    }

    fn normal(&mut self, line: usize, text: &str) -> Result<(), Error> {
        let normal = at_least::<3>(text, 3).or_else(|message| {
            self.complaints.note(line, NO_NORMAL, || format!("normal: {message}")).map(|()| [0.0; 3])
        })?;
        self.obj.normals.push(DVec3::from(normal).as_vec3());
        Ok(())
    }

    fn face(&mut self, line: usize, text: &str) -> Result<(), Error> {
        let start = self.obj.corners.len();
        for word in data(text).split_ascii_whitespace() {
            match self.corner(word) {
                Ok(corner) => self.obj.corners.push(corner),
                Err(message) => {
                    self.obj.corners.truncate(start);
                    let complaint = || format!("face corner \"{word}\": {message}");
                    return self.complaints.note(line, FACE_LEFT_OUT, complaint);
                }
            }
        }
        let corners = self.obj.corners.len() - start;
        if corners < 3 {
            self.obj.corners.truncate(start);
            let complaint = || format!("face: expected at least 3 corners, found {corners}");
            return self.complaints.note(line, FACE_LEFT_OUT, complaint);
        }
        let end = self.obj.corners.len() as u32;
        self.obj.faces.push(Face { end, material: self.material, line: line as u32 });
        Ok(())
    }

    /// The indices of a corner `v`, `v/t`, `v//n` or `v/t/n`, counted from 0.
    fn corner(&self, word: &str) -> Result<[u32; 3], String> {
        let so_far = [self.obj.positions.len(), self.obj.uvs.len(), self.obj.normals.len()];
        let mut indices = [NONE; 3];
        let mut fields = word.split('/');
        for (kind, field) in fields.by_ref().take(3).enumerate() {
            if kind == 0 || !field.is_empty() {
                indices[kind] = index(field, so_far[kind])?;
            }
        }
        match fields.next() {
            Some(_) => Err("expected at most three indices".to_owned()),
            None => Ok(indices),
        }
    }

    fn use_material(&mut self, line: usize, name: &str) -> Result<(), Error> {
        if name.is_empty() {
            let complaint = || "usemtl: expected the name of a material".to_owned();
            return self.complaints.note(line, IGNORED, complaint);
        }
        if let Some(&material) = self.names.get(name) {
            self.material = material;
            return Ok(());
        }
        self.material = self.obj.materials.len() as u32;
        self.names.insert(name.to_owned(), self.material);
        self.obj.materials.push(name.to_owned());
        Ok(())
    }

    /// Colours of vertices in a row as ZBrush writes them into comments: eight hexadecimal digits each, mask first.
    fn paint(&mut self, text: &str) {
        for code in text.trim().as_bytes().as_chunks::<8>().0 {
            let code = std::str::from_utf8(code).ok().and_then(|code| u32::from_str_radix(code, 16).ok());
            let Some(code) = code else { return };
            let [_, r, g, b] = code.to_be_bytes().map(|byte| f32::from(byte) / 255.0);
            self.obj.painted.push(Vec3::new(r, g, b));
        }
    }
}

/// An index counted from 0, of one that counts from 1 or back from the `so_far` last element. Whether there is such an
/// element is known when all lines are read.
fn index(field: &str, so_far: usize) -> Result<u32, String> {
    let given: i64 = field.parse().map_err(|_| "index is not a whole number".to_owned())?;
    let resolved = if given < 0 { so_far as i64 + given } else { given - 1 };
    match u32::try_from(resolved) {
        Ok(index) if index != NONE => Ok(index),
        _ => Err(format!("index {given} is out of range, there are {so_far} so far")),
    }
}
