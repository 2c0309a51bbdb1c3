//! The scenes whose meshes and textures are too large for the repository, made from formulas.
//!
//! The same sources make the same bytes. A scene's files are kept in a cache under a hash of the sources that made
//! them and of the detail asked for, and are only made anew if that or their content differs.

pub mod mesh;
pub mod noise;
pub mod polygonise;
pub mod room;
pub mod sdf;
pub mod shapes;
pub mod statue;
pub mod writer;

use std::io::Result;
use std::path::Path;
use writer::Files;

/// A scene that can be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scene {
    /// A seated sage, carved in stone.
    Statue,
    /// A living room in the evening.
    Room,
}

/// What [`make`] did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The files were there.
    Kept,
    /// The files were made, with this number of triangles.
    Made(usize),
}

/// The sources that every scene depends on.
const COMMON: &str = concat!(
    include_str!("lib.rs"),
    include_str!("mesh.rs"),
    include_str!("noise.rs"),
    include_str!("polygonise.rs"),
    include_str!("sdf.rs"),
    include_str!("writer.rs"),
);

impl Scene {
    /// All scenes.
    pub const ALL: [Scene; 2] = [Scene::Statue, Scene::Room];

    /// The scene's name: that of its file and of its folder in the cache.
    pub fn name(self) -> &'static str {
        match self {
            Scene::Statue => "statue",
            Scene::Room => "room",
        }
    }

    /// The scene file, which stands beside the cache.
    pub fn file(self) -> &'static str {
        match self {
            Scene::Statue => include_str!("../statue.toml"),
            Scene::Room => include_str!("../room.toml"),
        }
    }

    fn sources(self) -> &'static str {
        match self {
            Scene::Statue => statue::SOURCES,
            Scene::Room => room::SOURCES,
        }
    }

    fn files(self, detail: f32) -> Result<Files> {
        match self {
            Scene::Statue => Ok(statue::files(detail)),
            Scene::Room => room::files(detail),
        }
    }
}

/// Makes sure that `folder` holds the scene: its scene file, and `cache/NAME` with what that refers to. `detail` is
/// 1 for the scene as it is meant; lengths of edges go with its inverse.
///
/// # Errors
/// If a file cannot be written.
pub fn make(scene: Scene, detail: f32, folder: &Path) -> Result<Outcome> {
    let cache = folder.join("cache").join(scene.name());
    let key = blake3::hash(format!("{detail} {COMMON} {}", scene.sources()).as_bytes()).to_string();
    let outcome = if writer::is_fresh(&cache, &key) {
        Outcome::Kept
    } else {
        let files = scene.files(detail)?;
        files.write(&cache, &key)?;
        Outcome::Made(files.triangles())
    };
    let file = folder.join(scene.name()).with_extension("toml");
    if !file.exists() {
        std::fs::write(file, scene.file())?;
    }
    Ok(outcome)
}
