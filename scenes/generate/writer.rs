//! The cache of generated files: what is in it is known by a hash, and made anew only if that differs.

use super::mesh::Mesh;
use image::RgbImage;
use std::fmt::Write;
use std::fs;
use std::io::Result;
use std::path::{Path, PathBuf};

/// Files of one scene, in memory.
#[derive(Debug, Default)]
pub struct Files {
    contents: Vec<(String, Vec<u8>)>,
    triangles: usize,
}

/// The file in the cache that lists the others.
const STAMP: &str = "stamp";

impl Files {
    /// Adds an OBJ of several meshes, each with a material of `materials.mtl`.
    pub fn add_obj(&mut self, name: &str, parts: &[(&str, &Mesh)]) {
        let mut text = String::from("mtllib materials.mtl\n");
        let mut first = 1;
        for (material, mesh) in parts {
            write_part(&mut text, material, mesh, first);
            first += mesh.positions.len();
            self.triangles += mesh.triangles.len();
        }
        self.contents.push((format!("{name}.obj"), text.into_bytes()));
    }

    /// Triangles in all OBJ files.
    pub fn triangles(&self) -> usize {
        self.triangles
    }

    /// Adds a text file.
    pub fn add_text(&mut self, name: &str, text: &str) {
        self.contents.push((name.to_owned(), text.as_bytes().to_vec()));
    }

    /// Adds a PNG.
    ///
    /// # Errors
    /// If the encoder fails.
    pub fn add_png(&mut self, name: &str, image: &RgbImage) -> Result<()> {
        let mut bytes = std::io::Cursor::new(Vec::new());
        image.write_to(&mut bytes, image::ImageFormat::Png).map_err(std::io::Error::other)?;
        self.contents.push((format!("{name}.png"), bytes.into_inner()));
        Ok(())
    }

    /// Writes all files to `folder` and, last, the stamp that says what they were made from.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn write(&self, folder: &Path, key: &str) -> Result<()> {
        fs::create_dir_all(folder)?;
        let stamp = folder.join(STAMP);
        if stamp.exists() {
            fs::remove_file(&stamp)?;
        }
        let mut text = format!("{key}\n");
        for (name, bytes) in &self.contents {
            fs::write(folder.join(name), bytes)?;
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{} {name}", blake3::hash(bytes));
        }
        fs::write(stamp, text)
    }
}

/// Whether `folder` holds, unchanged, what was made from `key`.
pub fn is_fresh(folder: &Path, key: &str) -> bool {
    let Ok(stamp) = fs::read_to_string(folder.join(STAMP)) else { return false };
    let mut lines = stamp.lines();
    lines.next() == Some(key) && lines.all(|line| is_unchanged(folder, line))
}

fn is_unchanged(folder: &Path, line: &str) -> bool {
    let Some((hash, name)) = line.split_once(' ') else { return false };
    fs::read(folder.join(PathBuf::from(name))).is_ok_and(|bytes| blake3::hash(&bytes).to_string() == hash)
}

fn write_part(text: &mut String, material: &str, mesh: &Mesh, first: usize) {
    // Writing to a string cannot fail.
    let mut line = |arguments: std::fmt::Arguments| text.write_fmt(arguments).unwrap_or_default();
    for p in &mesh.positions {
        line(format_args!("v {:.6} {:.6} {:.6}\n", p.x, p.y, p.z));
    }
    for uv in &mesh.uvs {
        line(format_args!("vt {:.4} {:.4}\n", uv.x, uv.y));
    }
    for n in &mesh.normals {
        line(format_args!("vn {:.4} {:.4} {:.4}\n", n.x, n.y, n.z));
    }
    line(format_args!("usemtl {material}\n"));
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|i| i as usize + first);
        line(format_args!("f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}\n"));
    }
}
