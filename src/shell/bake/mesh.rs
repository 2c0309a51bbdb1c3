//! The scene's triangles with their places in the lightmap, as an OBJ file.

use super::atlas::Atlas;
use crate::error::Error;
use crate::picture::output;
use crate::scene::LoadedScene;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

/// Writes the triangles that have an irradiance: positions as in the scene's files, and texture coordinates from 0 to 1, v growing
/// upwards, that belong to the lightmap.
///
/// # Errors
/// [`Error::Write`]; no partial file is left.
pub fn write(path: &Path, scene: &LoadedScene, atlas: &Atlas<'_>) -> Result<(), Error> {
    let mut text = String::from("# Positions of the scene, texture coordinates of its lightmap.\n");
    let size = atlas.size as f32;
    let mut corners = 0;
    for (triangle, flat) in scene.triangles.iter().zip(&atlas.corners) {
        let Some(flat) = flat else { continue };
        for (corner, [u, v]) in triangle.corners.iter().zip(flat) {
            let [x, y, z] = [0, 1, 2].map(|i| f64::from(corner[i]) + scene.origin[i]);
            // A string takes everything.
            let _ = writeln!(text, "v {x} {y} {z}\nvt {} {}", u / size, 1.0 - v / size);
        }
        let [a, b, c] = [corners + 1, corners + 2, corners + 3];
        let _ = writeln!(text, "f {a}/{a} {b}/{b} {c}/{c}");
        corners += 3;
    }
    output::write(path, |file| file.write_all(text.as_bytes()))
}
