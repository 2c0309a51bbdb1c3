//! Textures: PNG and JPEG, sRGB on disk, linear in memory, each file once.

use pmcip_core::tracer::scene::Texture;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// All textures of a scene.
#[derive(Debug, Default)]
pub(super) struct TextureCache {
    by_path: HashMap<PathBuf, u32>,
    textures: Vec<Texture>,
    texels: Vec<[f32; 3]>,
}

impl TextureCache {
    /// The index of the texture in a file, which is read if it is new; the error says why it cannot be used.
    pub fn load(&mut self, path: &Path) -> Result<u32, String> {
        let key = path.canonicalize().map_err(|e| e.to_string())?;
        if let Some(&index) = self.by_path.get(&key) {
            return Ok(index);
        }
        let image = image::open(&key).map_err(|e| e.to_string())?.into_rgb32f();
        let first = u32::try_from(self.texels.len()).map_err(|_| "too many texels".to_owned())?;
        let index = self.textures.len() as u32;
        self.textures.push(Texture { width: image.width(), height: image.height(), first });
        self.texels.extend(image.pixels().map(|p| p.0.map(linear)));
        self.by_path.insert(key, index);
        Ok(index)
    }

    /// The arrays that the core borrows.
    pub fn into_parts(self) -> (Vec<Texture>, Vec<[f32; 3]>) {
        (self.textures, self.texels)
    }
}

/// Linear value of an sRGB value (IEC 61966-2-1).
fn linear(v: f32) -> f32 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}
