//! From a file's name to a scene: a scene file, or an OBJ as a scene of its own.

use super::animation::Animation;
use super::assemble::{Assembly, Shot};
use super::error::Error;
use super::model::{LoadedScene, is_obj};
use super::script::Script;
use super::{file, obj};
use std::path::Path;

impl Animation {
    /// Loads a scene file, or an OBJ as a scene that never changes, and brings it to its first frame.
    ///
    /// # Errors
    /// If a file cannot be read or understood, or holds no triangle.
    pub fn load(path: &Path) -> Result<Animation, Error> {
        if is_obj(path) { bare_obj(path, false) } else { file::load_scene(path, obj::add_mesh) }
    }

    /// Loads a scene to be rendered: as [`load`](Self::load), but something shines in it. An OBJ without light gets a
    /// soft sky and a key light, and a warning that says so.
    ///
    /// # Errors
    /// As [`load`](Self::load), and if a scene file has no light.
    pub fn load_lit(path: &Path) -> Result<Animation, Error> {
        if is_obj(path) {
            return bare_obj(path, true);
        }
        let animation = Animation::load(path)?;
        animation.scene().require_light().map(|()| animation)
    }
}

/// An OBJ as a scene of its own: default film, a camera framed on it, lights from its materials, or if none of them
/// shines and `soft_light` allows it, a soft sky and a key light.
fn bare_obj(path: &Path, soft_light: bool) -> Result<Animation, Error> {
    let mut assembly = Assembly::default();
    obj::add_mesh(&mut assembly, path, None)?;
    assembly.finish(path, Shot { soft_light, ..Shot::default() }, Script::still(1))
}

/// Loads a scene file, or an OBJ as a scene of its own; of an animation the first frame.
///
/// # Errors
/// If a file cannot be read or understood, or holds no triangle.
pub fn load(path: &Path) -> Result<LoadedScene, Error> {
    Animation::load(path).map(Animation::into_scene)
}

/// Loads a scene to be rendered: as [`load`], but something shines in it. An OBJ without light gets a soft sky and
/// a key light, and a warning that says so.
///
/// # Errors
/// As [`load`], and if a scene file has no light.
pub fn load_lit(path: &Path) -> Result<LoadedScene, Error> {
    Animation::load_lit(path).map(Animation::into_scene)
}
