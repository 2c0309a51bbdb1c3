//! Meshes from OBJ files, through tobj.
//!
//! Polygons become fans around their first corner, which is right for convex ones (and for concave ones only if
//! the first corner sees all others). A triangle without normals at all its corners is flat. Groups and objects
//! do not matter. Curves, free-form surfaces, points and lines are left out.

mod lines;
mod mtl;
mod text;

use crate::scene::assemble::Assembly;
use crate::scene::error::{Error, read};
use crate::scene::object::Corner;
use glam::{Vec2, Vec3};
use pmcip_core::tracer::scene::Material;
use std::path::Path;
use text::CheckedObj;
use tobj::{LoadOptions, Mesh, Model};

/// Adds the triangles of an OBJ file as an object, all of one `material` if it is given.
pub(super) fn add_mesh(assembly: &mut Assembly, path: &Path, material: Option<u32>) -> Result<(), Error> {
    let checked = text::check(path, &read(path)?)?;
    let models = parse(path, &checked)?;
    if models.iter().all(|m| m.mesh.indices.is_empty()) {
        return Err(Error::in_file(path, "no faces"));
    }
    let indices = match material {
        Some(index) => vec![index; checked.materials.len()],
        None => mtl::load(path, &checked, assembly)?,
    };
    assembly.begin(path);
    let mut unnamed = material;
    for Model { mesh, .. } in &models {
        let index = match mesh.material_id {
            Some(id) => indices[id],
            None => *unnamed.get_or_insert_with(|| assembly.add_material(Material::default())),
        };
        for triangle in mesh.indices.as_chunks::<3>().0 {
            assembly.add(triangle.map(|i| corner(mesh, i as usize)), index);
        }
    }
    Ok(())
}

/// Lets tobj read the checked text; the materials of its meshes index `checked.materials`.
fn parse(path: &Path, checked: &CheckedObj) -> Result<Vec<Model>, Error> {
    let options = LoadOptions { single_index: true, triangulate: true, ..LoadOptions::default() };
    let names = &checked.materials;
    let named = |name: &String| tobj::Material { name: name.clone(), ..tobj::Material::default() };
    let library = |_: &Path| {
        let by_name = names.iter().enumerate().map(|(i, name)| (name.clone(), i)).collect();
        Ok((names.iter().map(named).collect(), by_name))
    };
    match tobj::load_obj_buf(&mut checked.text.as_bytes(), &options, library) {
        Ok((models, _)) => Ok(models),
        Err(error) => Err(Error::in_file(path, error.to_string())),
    }
}

/// A vertex of a mesh whose vertices are all complete.
fn corner(mesh: &Mesh, i: usize) -> Corner {
    Corner {
        position: Vec3::from_slice(&mesh.positions[3 * i..]),
        normal: Vec3::from_slice(&mesh.normals[3 * i..]),
        uv: Vec2::from_slice(&mesh.texcoords[2 * i..]),
    }
}
