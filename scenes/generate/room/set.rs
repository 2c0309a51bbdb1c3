//! Parts of one OBJ file, gathered by material.

use super::super::mesh::Mesh;
use super::super::writer::Files;
use glam::Affine3A;
use std::collections::BTreeMap;

/// Meshes by the name of their material.
#[derive(Debug, Default)]
pub struct Set(BTreeMap<&'static str, Mesh>);

impl Set {
    /// Adds a mesh where it is.
    pub fn add(&mut self, material: &'static str, mesh: &Mesh) {
        self.0.entry(material).or_default().append(mesh);
    }

    /// Adds a mesh under a map.
    pub fn place(&mut self, material: &'static str, mesh: &Mesh, map: Affine3A) {
        self.add(material, &mesh.moved(map));
    }

    /// Adds all of another set under a map.
    pub fn place_all(&mut self, other: &Set, map: Affine3A) {
        other.0.iter().for_each(|(material, mesh)| self.place(material, mesh, map));
    }

    /// Writes it as `name.obj`.
    pub fn write(mut self, files: &mut Files, name: &str) {
        // Sharp bends of thin tubes leave a few.
        self.0.values_mut().for_each(Mesh::flatten_backward);
        let parts: Vec<_> = self.0.iter().map(|(material, mesh)| (*material, mesh)).collect();
        files.add_obj(name, &parts);
    }
}
