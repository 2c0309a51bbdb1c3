//! Checks the text of an OBJ and completes it, before tobj reads it.
//!
//! tobj names no lines, mixes up attributes when only some corners of a mesh have them, and forgets the names of
//! materials that it does not find. So every number and every index is checked here, with the line at hand, and
//! what tobj gets is plain: all vertices, then faces whose corners all have position, texture coordinate and
//! normal (zero where the file has none), and `usemtl` lines. Points, lines, curves and names are left out.

use super::lines::{data, logical_lines, split};
use crate::scene::error::Error;
use std::fmt::Write;
use std::path::Path;

/// An OBJ without surprises.
#[derive(Debug, Default)]
pub(super) struct CheckedObj {
    /// What tobj reads.
    pub text: String,
    /// The arguments of `mtllib` lines.
    pub libraries: Vec<String>,
    /// The materials in use, in order of their first appearance.
    pub materials: Vec<String>,
}

/// Numbers of positions, texture coordinates and normals.
type Counts = [usize; 3];

const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// Checks an OBJ file's text.
pub(super) fn check(path: &Path, source: &str) -> Result<CheckedObj, Error> {
    let mut obj = CheckedObj { text: "mtllib all\n".to_owned(), ..CheckedObj::default() };
    let totals = copy_vertices(path, source, &mut obj.text)?;
    // What a corner refers to where the file gives it nothing.
    obj.text.push_str("vt 0 0\nvn 0 0 0\n");
    let mut counts = Counts::default();
    for (number, line) in logical_lines(source) {
        let (key, rest) = split(&line);
        match key {
            "v" => counts[0] += 1,
            "vt" => counts[1] += 1,
            "vn" => counts[2] += 1,
            "f" => write_face(&mut obj.text, rest, counts, totals).map_err(|m| Error::at(path, number, m))?,
            "usemtl" => use_material(&mut obj, rest).map_err(|m| Error::at(path, number, m))?,
            "mtllib" => obj.libraries.push(rest.to_owned()),
            _ => {}
        }
    }
    Ok(obj)
}

/// Writes all vertices, texture coordinates and normals, and counts them.
fn copy_vertices(path: &Path, source: &str, out: &mut String) -> Result<Counts, Error> {
    let mut totals = Counts::default();
    for (number, line) in logical_lines(source) {
        let (key, rest) = split(&line);
        let (kind, least, len) = match key {
            "v" => (0, 3, 3),
            "vt" => (1, 1, 2),
            "vn" => (2, 3, 3),
            _ => continue,
        };
        let mut values = numbers(rest, least, len)
            .map_err(|m| Error::at(path, number, format!("{}: {m}", KINDS[kind])))?;
        if values.iter().any(|v| !v.is_finite()) {
            if key != "vn" {
                return Err(Error::at(path, number, format!("{}: a coordinate is not finite", KINDS[kind])));
            }
            values = [0.0; 3];
        }
        totals[kind] += 1;
        write_line(out, key, &values[..len]);
    }
    Ok(totals)
}

fn write_line(out: &mut String, key: &str, values: &[f32]) {
    out.push_str(key);
    for v in values {
        // Writing to a string cannot fail.
        let _ = write!(out, " {v}");
    }
    out.push('\n');
}

/// At least `least` and at most `len` numbers, the rest 0; more are ignored.
fn numbers(text: &str, least: usize, len: usize) -> Result<[f32; 3], String> {
    let mut values = [0.0; 3];
    let mut found = 0;
    for (value, word) in values[..len].iter_mut().zip(data(text).split_whitespace()) {
        *value = word.parse().map_err(|_| format!("expected a number, found \"{word}\""))?;
        found += 1;
    }
    if found < least {
        return Err(format!("expected {least} numbers, found {found}"));
    }
    Ok(values)
}

/// Writes a face whose corners are all complete.
fn write_face(out: &mut String, text: &str, counts: Counts, totals: Counts) -> Result<(), String> {
    let start = out.len();
    out.push('f');
    let mut corners = 0;
    for word in data(text).split_whitespace() {
        let [v, t, n] = corner(word, counts, totals)?;
        let _ = write!(out, " {v}/{t}/{n}");
        corners += 1;
    }
    if corners < 3 {
        out.truncate(start);
        return Err(format!("face: expected at least 3 corners, found {corners}"));
    }
    out.push('\n');
    Ok(())
}

/// The three positive indices of a corner `v`, `v/t`, `v//n` or `v/t/n`.
fn corner(word: &str, counts: Counts, totals: Counts) -> Result<[usize; 3], String> {
    let mut indices = [0, totals[1] + 1, totals[2] + 1];
    let mut fields = word.split('/');
    for (kind, field) in fields.by_ref().take(3).enumerate() {
        if kind == 0 || !field.is_empty() {
            indices[kind] = index(field, counts[kind], totals[kind])
                .map_err(|m| format!("face corner \"{word}\": {} {m}", KINDS[kind]))?;
        }
    }
    match fields.next() {
        Some(_) => Err(format!("face corner \"{word}\": expected at most three indices")),
        None => Ok(indices),
    }
}

/// A positive index from one that may count back from the `so_far` last element.
fn index(field: &str, so_far: usize, total: usize) -> Result<usize, String> {
    let given: i64 = field.parse().map_err(|_| "index is not a whole number".to_owned())?;
    let resolved = if given < 0 { so_far as i64 + 1 + given } else { given };
    match usize::try_from(resolved) {
        Ok(i) if (1..=total).contains(&i) => Ok(i),
        _ => Err(format!("index {given} is out of range, there are {total}")),
    }
}

fn use_material(obj: &mut CheckedObj, name: &str) -> Result<(), String> {
    if name.is_empty() {
        return Err("usemtl: expected the name of a material".to_owned());
    }
    if !obj.materials.iter().any(|m| m == name) {
        obj.materials.push(name.to_owned());
    }
    let _ = writeln!(obj.text, "usemtl {name}");
    Ok(())
}
