//! From a file's name to a scene: a scene file, an OBJ or a glTF file as a scene of its own.

use super::animation::Animation;
use super::assemble::{Assembly, Shot};
use super::error::Error;
use super::model::{Kind, LoadedScene};
use super::options::{LightChoice, Options};
use super::script::Script;
use super::{file, gltf, obj};
use std::path::Path;

impl Animation {
    /// Loads a scene file, a glTF file, or an OBJ as a scene that never changes, and brings it to its first frame.
    ///
    /// # Errors
    /// If a file cannot be read or understood, or holds no triangle.
    pub fn load(path: &Path) -> Result<Animation, Error> {
        Animation::open(path, &Options { light: LightChoice::Own, ..Options::default() })
    }

    /// Loads a scene to be rendered: as [`load`](Self::load), but something shines in it. An OBJ or glTF file
    /// without light gets a soft sky and a key light, in a room a lamp by the camera, and a warning that says so.
    ///
    /// # Errors
    /// As [`load`](Self::load), and if a scene file has no light.
    pub fn load_lit(path: &Path) -> Result<Animation, Error> {
        let animation = Animation::open(path, &Options::default())?;
        animation.scene().require_light().map(|()| animation)
    }

    /// Loads a scene as `options` say.
    ///
    /// # Errors
    /// If a file cannot be read or understood, or holds no triangle.
    pub fn open(path: &Path, options: &Options) -> Result<Animation, Error> {
        match Kind::of(path) {
            Kind::Obj => bare_obj(path, options),
            Kind::Gltf => gltf::scene(path, options),
            Kind::Other => {
                // A lamp that nobody has asked for is for files that cannot have one.
                let light =
                    if options.light == LightChoice::Sky { LightChoice::Sky } else { LightChoice::Own };
                file::load_scene(path, add_mesh, &Options { light, ..*options })
            }
        }
    }
}

/// Adds a mesh file's triangles, all of one material if it is given.
fn add_mesh(assembly: &mut Assembly, path: &Path, material: Option<u32>) -> Result<(), Error> {
    match Kind::of(path) {
        Kind::Gltf => gltf::add_mesh(assembly, path, material),
        _ => obj::add_mesh(assembly, path, material),
    }
}

/// An OBJ as a scene of its own: default film, a camera framed on it, lights from its materials.
fn bare_obj(path: &Path, options: &Options) -> Result<Animation, Error> {
    let mut assembly = Assembly::new(options);
    obj::add_mesh(&mut assembly, path, None)?;
    assembly.finish(path, Shot::default(), options, Script::still(1))
}

/// Loads a scene file, or an OBJ or a glTF file as a scene of its own; of an animation the first frame.
///
/// # Errors
/// If a file cannot be read or understood, or holds no triangle.
pub fn load(path: &Path) -> Result<LoadedScene, Error> {
    Animation::load(path).map(Animation::into_scene)
}

/// Loads a scene to be rendered: as [`load`], but something shines in it. An OBJ or glTF file without light gets a
/// soft sky and a key light, in a room a lamp by the camera, and a warning that says so.
///
/// # Errors
/// As [`load`], and if a scene file has no light.
pub fn load_lit(path: &Path) -> Result<LoadedScene, Error> {
    Animation::load_lit(path).map(Animation::into_scene)
}
