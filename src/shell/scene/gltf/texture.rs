//! Pictures of a glTF file, and how they lie.
//!
//! glTF counts `v` downwards, the tracer upwards: coordinates are turned over as they are read, and what transforms them
//! with them.

use super::data::Data;
use super::uri::{Place, resolve};
use crate::scene::notes::Notes;
use crate::scene::source;
use crate::scene::texture::{Lay, Loaded, Purpose, TextureCache, decode_bytes, is_linear, linear};
use glam::{Mat2, Vec2};
use gltf::material::NormalTexture;
use gltf::texture::{Info, MagFilter, WrappingMode};
use gltf::{Document, Texture};
use image::DynamicImage;
use serde::Deserialize;
use std::collections::HashMap;
use std::path::Path;

/// How a picture is used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Use {
    /// Index of the picture.
    pub image: usize,
    /// Number of the set of coordinates.
    pub set: u32,
    /// How it lies, but for `turn`.
    pub lay: Lay,
    /// What is done to coordinates before, where that is more than scale and offset.
    pub turn: Option<Turn>,
    /// Whether columns and rows are followed by their mirror images.
    pub mirrored: [bool; 2],
}

/// What a material says of a texture.
pub(super) struct Stated<'a> {
    texture: Texture<'a>,
    set: u32,
    transform: Option<Transform>,
}

/// `KHR_texture_transform`.
#[derive(Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Transform {
    offset: [f32; 2],
    rotation: f32,
    scale: [f32; 2],
    tex_coord: Option<u32>,
}

impl Default for Transform {
    fn default() -> Self {
        Transform { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2], tex_coord: None }
    }
}

impl<'a> From<&Info<'a>> for Stated<'a> {
    fn from(info: &Info<'a>) -> Self {
        let transform = info.texture_transform().map(|transform| Transform {
            offset: transform.offset(),
            rotation: transform.rotation(),
            scale: transform.scale(),
            tex_coord: transform.tex_coord(),
        });
        Stated { texture: info.texture(), set: info.tex_coord(), transform }
    }
}

impl<'a> From<&NormalTexture<'a>> for Stated<'a> {
    fn from(normal: &NormalTexture<'a>) -> Self {
        let transform = normal.extension_value("KHR_texture_transform");
        let transform = transform.and_then(|value| serde_json::from_value(value.clone()).ok());
        Stated { texture: normal.texture(), set: normal.tex_coord(), transform }
    }
}

/// A map of coordinates as glTF counts them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Turn {
    pub linear: Mat2,
    pub offset: Vec2,
}

impl Turn {
    /// Where coordinates go.
    pub fn apply(&self, uv: Vec2) -> Vec2 {
        self.linear * uv + self.offset
    }
}

/// The pictures of a file.
pub(super) struct Pictures<'a> {
    pub path: &'a Path,
    pub document: &'a Document,
    pub data: &'a Data,
    /// Means that are known.
    means: HashMap<(usize, bool), Result<[f32; 4], String>>,
}

impl<'a> Pictures<'a> {
    pub fn new(path: &'a Path, document: &'a Document, data: &'a Data) -> Self {
        Pictures { path, document, data, means: HashMap::new() }
    }

    /// How a texture is used; none without a picture that could be read.
    pub fn used(&self, stated: Stated<'_>, notes: &mut Notes) -> Option<Use> {
        let Stated { texture, set, transform } = stated;
        let webp =
            texture.extension_value("EXT_texture_webp").and_then(|value| value.get("source")?.as_u64());
        let webp = webp.map(|image| image as usize).filter(|image| *image < self.document.images().len());
        let image = webp.or_else(|| texture.source().map(|image| image.index()));
        let Some(image) = image else {
            notes.add("no source", || {
                format!("texture {}: it has no picture of a known kind: left out", texture.index())
            });
            return None;
        };
        let sampler = texture.sampler();
        if sampler.mag_filter() == Some(MagFilter::Nearest) {
            notes.add("nearest", || "textures without filter are filtered all the same".into());
        }
        let mirrored = [sampler.wrap_s(), sampler.wrap_t()].map(|wrap| wrap == WrappingMode::MirroredRepeat);
        let mut lay = Lay { clamp: clamps(sampler.wrap_s(), sampler.wrap_t(), notes), ..Lay::default() };
        let set = transform.as_ref().and_then(|transform| transform.tex_coord).unwrap_or(set);
        let mut turn = None;
        if let Some(Transform { offset: [ou, ov], rotation, scale: [su, sv], .. }) = transform {
            match rotation {
                0.0 => (lay.scale, lay.offset) = ([su, sv], [ou, ov]),
                // Counter-clockwise as it is seen, v downwards.
                angle => {
                    let (sin, cos) = angle.sin_cos();
                    let linear = Mat2::from_cols(Vec2::new(cos, -sin) * su, Vec2::new(sin, cos) * sv);
                    turn = Some(Turn { linear, offset: Vec2::new(ou, ov) });
                }
            }
        }
        // A picture and its mirror image beside it are twice as large.
        for axis in (0..2).filter(|axis| mirrored[*axis]) {
            lay.scale[axis] *= 0.5;
            lay.offset[axis] *= 0.5;
        }
        // Upwards: 1 − (s (1 − v) + o).
        lay.offset[1] = 1.0 - lay.scale[1] - lay.offset[1];
        Some(Use { image, set, lay, turn, mirrored })
    }

    /// The texture of a use, or why there is none.
    pub fn load(&self, textures: &mut TextureCache, of: &Use, purpose: Purpose) -> Result<Loaded, String> {
        // No file has such a name: it would be a file in a file.
        let [columns, rows] = of.mirrored;
        let name = self.path.join("image").join(format!("{} {columns} {rows}", of.image));
        textures.load_as(name, purpose, of.lay, || Ok(mirrored(self.decode(of.image)?, of.mirrored)))
    }

    /// The mean of a picture's values: linear ones of colours, or as they are written.
    pub fn mean(&mut self, image: usize, of_colours: bool) -> Result<[f32; 4], String> {
        if let Some(known) = self.means.get(&(image, of_colours)) {
            return known.clone();
        }
        let mean = self.decode(image).map(|picture| mean(picture, of_colours));
        self.means.insert((image, of_colours), mean.clone());
        mean
    }

    fn decode(&self, image: usize) -> Result<DynamicImage, String> {
        let json = &self.document.as_json().images[image];
        let decode = |bytes: &[u8]| match bytes.starts_with(b"\xabKTX") {
            true => Err("KTX pictures are not supported".to_owned()),
            false => decode_bytes(bytes),
        };
        if let Some(uri) = &json.uri {
            return match resolve(self.path, uri)? {
                Place::Here(bytes) => decode(&bytes),
                Place::File(file) => {
                    let bytes = source::bytes(&file).map_err(|e| format!("{}: {e}", file.display()))?;
                    decode(&bytes).map_err(|e| format!("{}: {e}", file.display()))
                }
            };
        }
        let view = json.buffer_view.and_then(|view| self.document.views().nth(view.value()));
        decode(self.data.view(&view.ok_or("it has neither uri nor bufferView")?)?)
    }
}

fn clamps(s: WrappingMode, t: WrappingMode, notes: &mut Notes) -> bool {
    let clamps = s == WrappingMode::ClampToEdge;
    if clamps != (t == WrappingMode::ClampToEdge) {
        notes.add("one way", || "textures that are repeated in one direction are repeated in both".into());
        return false;
    }
    clamps
}

/// A picture followed by its mirror image in these directions.
fn mirrored(picture: DynamicImage, [columns, rows]: [bool; 2]) -> DynamicImage {
    let beside = |picture: DynamicImage, image: DynamicImage, (x, y): (u32, u32)| {
        let (width, height) = (picture.width(), picture.height());
        let mut both = DynamicImage::new(width + x * width, height + y * height, picture.color());
        for (part, (x, y)) in [(picture, (0, 0)), (image, (x * width, y * height))] {
            image::imageops::replace(&mut both, &part, i64::from(x), i64::from(y));
        }
        both
    };
    let mut picture = picture;
    if columns {
        let image = picture.fliph();
        picture = beside(picture, image, (1, 0));
    }
    if rows {
        let image = picture.flipv();
        picture = beside(picture, image, (0, 1));
    }
    picture
}

fn mean(picture: DynamicImage, of_colours: bool) -> [f32; 4] {
    let converts = of_colours && !is_linear(&picture);
    let picture = picture.into_rgba32f();
    let mut sum = [0.0f64; 4];
    for pixel in picture.pixels() {
        for (i, (sum, value)) in sum.iter_mut().zip(pixel.0).enumerate() {
            let value = if converts && i < 3 { linear(value) } else { value };
            *sum += f64::from(if value.is_finite() { value.clamp(0.0, 1.0) } else { 0.0 });
        }
    }
    let count = f64::from(picture.width()) * f64::from(picture.height());
    sum.map(|sum| (sum / count.max(1.0)) as f32)
}
