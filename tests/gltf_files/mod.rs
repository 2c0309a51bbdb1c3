//! Small glTF files, built number by number.

#![allow(dead_code, reason = "each test program uses some of it")]

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A glTF file in the making: its JSON, and its only buffer.
pub struct Gltf {
    pub json: Value,
    pub bin: Vec<u8>,
}

/// Component types.
pub const U8: u32 = 5121;
pub const U16: u32 = 5123;
pub const U32: u32 = 5125;
pub const F32: u32 = 5126;

impl Gltf {
    /// Nothing but a version.
    pub fn new() -> Gltf {
        Gltf { json: json!({ "asset": { "version": "2.0" } }), bin: Vec::new() }
    }

    /// Adds an item to a list, and returns its index.
    pub fn add(&mut self, list: &str, item: Value) -> usize {
        if self.json.get(list).is_none() {
            self.json[list] = json!([]);
        }
        let items = self.json[list].as_array_mut().unwrap();
        items.push(item);
        items.len() - 1
    }

    /// Adds bytes, and a view of them.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let view = json!({ "buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len() });
        self.bin.extend(bytes);
        self.add("bufferViews", view)
    }

    /// Adds an accessor of vectors of fractions.
    pub fn vectors<const N: usize>(&mut self, vectors: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = vectors.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        let view = self.view(&bytes);
        self.add(
            "accessors",
            json!({ "bufferView": view, "componentType": F32, "count": vectors.len(), "type": kind }),
        )
    }

    /// Adds an accessor of single fractions.
    pub fn fractions(&mut self, values: &[f32]) -> usize {
        let values: Vec<[f32; 1]> = values.iter().map(|v| [*v]).collect();
        self.vectors(&values)
    }

    /// Adds an accessor of indices of a component type.
    pub fn indices(&mut self, values: &[u32], component: u32) -> usize {
        let size = match component {
            U8 => 1,
            U16 => 2,
            _ => 4,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()[..size].to_vec()).collect();
        let view = self.view(&bytes);
        self.add(
            "accessors",
            json!({ "bufferView": view, "componentType": component, "count": values.len(), "type": "SCALAR" }),
        )
    }

    /// Adds a mesh of one primitive.
    pub fn mesh(&mut self, primitive: Value) -> usize {
        self.add("meshes", json!({ "primitives": [primitive] }))
    }

    /// Adds a square of corners (±1, ±1, 0) that faces +z, its texture upright, of a material if there is one.
    pub fn square(&mut self, material: Option<usize>) -> usize {
        let positions =
            self.vectors(&[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]);
        let uvs = self.vectors(&[[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
        let indices = self.indices(&[0, 1, 2, 0, 2, 3], U16);
        let mut primitive =
            json!({ "attributes": { "POSITION": positions, "TEXCOORD_0": uvs }, "indices": indices });
        if let Some(material) = material {
            primitive["material"] = json!(material);
        }
        self.mesh(primitive)
    }

    /// Adds a node, and a texture of an embedded PNG.
    pub fn texture(&mut self, picture: &image::DynamicImage) -> usize {
        let view = self.view(&png(picture));
        let image = self.add("images", json!({ "bufferView": view, "mimeType": "image/png" }));
        self.add("textures", json!({ "source": image }))
    }

    /// A square of this material before the default view, and the number of its node.
    pub fn with_square(mut self, material: Value) -> Gltf {
        let material = self.add("materials", material);
        let mesh = self.square(Some(material));
        self.add("nodes", json!({ "mesh": mesh }));
        self
    }

    /// Says that extensions are in use.
    pub fn using(mut self, extensions: &[&str]) -> Gltf {
        self.json["extensionsUsed"] = json!(extensions);
        self
    }

    /// As text, the buffer within.
    pub fn text(&self) -> String {
        let mut json = self.json.clone();
        if !self.bin.is_empty() && json.get("buffers").is_none() {
            let uri = format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(&self.bin));
            json["buffers"] = json!([{ "byteLength": self.bin.len(), "uri": uri }]);
        }
        serde_json::to_string_pretty(&json).unwrap()
    }

    /// As binary.
    pub fn binary(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if json.get("buffers").is_none() {
            json["buffers"] = json!([{ "byteLength": self.bin.len() }]);
        }
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut bin = self.bin.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        let word = |n: usize| (n as u32).to_le_bytes();
        let length = 12 + 8 + text.len() + 8 + bin.len();
        [
            b"glTF".as_slice(),
            &word(2),
            &word(length),
            &word(text.len()),
            b"JSON",
            &text,
            &word(bin.len()),
            b"BIN\0",
            &bin,
        ]
        .concat()
    }

    /// Written to a folder of its own as `s.gltf`.
    pub fn written(&self) -> (TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = self.write(folder.path(), "s.gltf");
        (folder, path)
    }

    /// Writes it, binary if the name ends so.
    pub fn write(&self, folder: &Path, name: &str) -> PathBuf {
        let path = folder.join(name);
        let bytes = if name.ends_with(".glb") { self.binary() } else { self.text().into_bytes() };
        std::fs::write(&path, bytes).unwrap();
        path
    }
}

/// The bytes of a PNG.
pub fn png(picture: &image::DynamicImage) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// A picture of these pixels in rows of `width`.
pub fn picture(width: u32, pixels: &[[u8; 4]]) -> image::DynamicImage {
    let rows = pixels.len() as u32 / width;
    image::RgbaImage::from_fn(width, rows, |x, y| image::Rgba(pixels[(y * width + x) as usize])).into()
}
