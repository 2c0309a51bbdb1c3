//! Textures: pictures in every format that `image` reads, sRGB or linear on disk, linear in memory, each file once.

use super::room::{Kind, Lease, Room};
use super::{openexr, source};
use image::{DynamicImage, ImageFormat, ImageReader, Rgba32FImage};
use pmcip_core::tracer::scene::Texture;
use std::collections::HashMap;
use std::io::{BufRead, Seek};
use std::path::{Path, PathBuf};

/// How a picture lies on the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lay {
    /// Factors of the texture coordinates.
    pub scale: [f32; 2],
    /// Added to them.
    pub offset: [f32; 2],
    /// Whether it ends at its edges instead of repeating.
    pub clamp: bool,
}

impl Default for Lay {
    fn default() -> Self {
        Lay { scale: [1.0; 2], offset: [0.0; 2], clamp: false }
    }
}

/// What a picture is used for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Purpose {
    /// Reflectance: linear, at most 1.
    Colour,
    /// How much is there: its alpha if it has any, else its brightness as it is written.
    Mask,
    /// Radiance: linear, times this colour.
    Light([f32; 3]),
    /// Reflectance as [`Colour`](Self::Colour), whatever the alpha.
    Solid,
    /// Normals, whose parts along the surface are multiplied by this.
    Normal(f32),
    /// How much is there: alpha times this factor, or with a cutoff all from there on and nothing below.
    Alpha(f32, Option<f32>),
}

impl Purpose {
    fn key(self) -> [u32; 4] {
        match self {
            Purpose::Colour => [0; 4],
            Purpose::Mask => [1, 0, 0, 0],
            Purpose::Light([r, g, b]) => [2, r.to_bits(), g.to_bits(), b.to_bits()],
            Purpose::Solid => [3, 0, 0, 0],
            Purpose::Normal(scale) => [6, scale.to_bits(), 0, 0],
            Purpose::Alpha(factor, None) => [4, factor.to_bits(), 0, 0],
            Purpose::Alpha(factor, Some(cutoff)) => [5, factor.to_bits(), cutoff.to_bits(), 0],
        }
    }
}

/// Texels of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Sheet {
    width: u32,
    height: u32,
    first: u32,
}

/// A picture and, if it has any, its alpha.
type Sheets = (Sheet, Option<Sheet>);

/// A picture in memory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Loaded {
    /// Index of its texture.
    pub texture: u32,
    /// Index of the texture of its alpha, if a colour has any.
    pub alpha: Option<u32>,
}

/// Texels in memory for each of a picture while it is made linear: as it was read, and four numbers in single precision.
const WORKED_ON: usize = 2;

/// All textures of a scene.
#[derive(Debug)]
pub(super) struct TextureCache {
    room: Room,
    /// Why there was no room for a picture.
    refusal: Option<String>,
    /// Sheets by file and purpose: the picture, and its alpha; or why there is none.
    sheets: HashMap<(PathBuf, [u32; 4]), Result<Sheets, String>>,
    /// Textures by first texel and lay.
    by_lay: HashMap<[u32; 6], u32>,
    textures: Vec<Texture>,
    texels: Vec<[f32; 3]>,
}

impl TextureCache {
    /// None yet.
    pub fn new(room: Room) -> TextureCache {
        TextureCache {
            room,
            refusal: None,
            sheets: HashMap::new(),
            by_lay: HashMap::new(),
            textures: Vec::new(),
            texels: Vec::new(),
        }
    }

    /// Whether there was room for all pictures so far.
    ///
    /// # Errors
    /// If there was not: a scene that looks otherwise for lack of memory is of no use.
    pub fn check(&self) -> Result<(), String> {
        self.refusal.clone().map_or(Ok(()), Err)
    }

    /// The picture in a file, which is read if it is new; the error says why it cannot be used.
    pub fn load(&mut self, path: &Path, purpose: Purpose, lay: Lay) -> Result<Loaded, String> {
        let name = path.canonicalize().map_err(|e| e.to_string())?;
        self.load_as(name, purpose, lay, || decode(path))
    }

    /// The picture of a name that no other has, which is read if it is new; the error says why it cannot be used.
    pub fn load_as(
        &mut self,
        name: PathBuf,
        purpose: Purpose,
        lay: Lay,
        read: impl FnOnce() -> Result<DynamicImage, String>,
    ) -> Result<Loaded, String> {
        let key = (name, purpose.key());
        let (sheet, alpha) = match self.sheets.get(&key) {
            Some(known) => known.clone()?,
            None => {
                let read = read().and_then(|picture| self.keep(picture, purpose));
                self.sheets.insert(key, read.clone());
                read?
            }
        };
        Ok(Loaded { texture: self.lay(sheet, lay), alpha: alpha.map(|sheet| self.lay(sheet, lay)) })
    }

    fn keep(&mut self, picture: DynamicImage, purpose: Purpose) -> Result<Sheets, String> {
        let linear_already = is_linear(&picture);
        let (width, height) = (picture.width(), picture.height());
        let lease = Lease::new(&self.room);
        self.fits(width, height, lease.take(WORKED_ON * width as usize * height as usize, Kind::Texels))?;
        let picture = picture.into_rgba32f();
        let pixels = || picture.pixels().map(|pixel| pixel.0);
        let alphas = || pixels().map(|[.., a]| a);
        // What is transparent everywhere has its alpha by mistake.
        let has_alpha = alphas().any(|a| a < 1.0) && alphas().any(|a| a > 0.0);
        let clean = |v: f32| if v.is_finite() { v.max(0.0) } else { 0.0 };
        let light = |v: f32| clean(if linear_already { v } else { linear(v) });
        let mut alpha = None;
        let sheet = match purpose {
            Purpose::Colour | Purpose::Solid => {
                if has_alpha && purpose == Purpose::Colour {
                    alpha = Some(self.sheet(width, height, alphas().map(|a| [clean(a).min(1.0); 3]))?);
                }
                self.sheet(width, height, pixels().map(|[r, g, b, _]| [r, g, b].map(|v| light(v).min(1.0))))?
            }
            Purpose::Mask => {
                let bright = |[r, g, b]: [f32; 3]| 0.2126 * r + 0.7152 * g + 0.0722 * b;
                let value = |[r, g, b, a]: [f32; 4]| if has_alpha { a } else { bright([r, g, b]) };
                self.sheet(width, height, pixels().map(|pixel| [clean(value(pixel)).min(1.0); 3]))?
            }
            Purpose::Alpha(factor, cutoff) => {
                let value = |a: f32| match cutoff {
                    Some(cutoff) => f32::from(u8::from(a * factor >= cutoff)),
                    None => clean(a * factor).min(1.0),
                };
                self.sheet(width, height, alphas().map(|a| [value(a); 3]))?
            }
            Purpose::Normal(scale) => {
                // As they are written, from −1 to 1.
                let signed = |v: f32| if v.is_finite() { 2.0 * v - 1.0 } else { 0.0 };
                let normal = |[x, y, z, _]: [f32; 4]| [scale * signed(x), scale * signed(y), signed(z)];
                self.sheet(width, height, pixels().map(normal))?
            }
            Purpose::Light(colour) => {
                let shine =
                    |[r, g, b, _]: [f32; 4]| [0, 1, 2].map(|i| clean(light([r, g, b][i]) * colour[i]));
                self.sheet(width, height, pixels().map(shine))?
            }
        };
        Ok((sheet, alpha))
    }

    /// Remembers if there is no room for a picture.
    fn fits(&mut self, width: u32, height: u32, room: Result<(), String>) -> Result<(), String> {
        let room = room.map_err(|message| format!("a picture of {width}×{height}: {message}"));
        self.refusal = self.refusal.take().or_else(|| room.as_ref().err().cloned());
        room
    }

    /// Keeps texels.
    fn sheet(
        &mut self,
        width: u32,
        height: u32,
        texels: impl Iterator<Item = [f32; 3]>,
    ) -> Result<Sheet, String> {
        if width == 0 || height == 0 {
            return Err("it has no pixels".to_owned());
        }
        self.fits(width, height, self.room.take(width as usize * height as usize, Kind::Texels))?;
        let first = u32::try_from(self.texels.len()).map_err(|_| "too many texels".to_owned())?;
        self.texels.extend(texels);
        Ok(Sheet { width, height, first })
    }

    /// The index of a texture of this sheet and lay.
    fn lay(&mut self, Sheet { width, height, first }: Sheet, Lay { scale, offset, clamp }: Lay) -> u32 {
        let [s, t, u, v] = [scale[0], scale[1], offset[0], offset[1]].map(f32::to_bits);
        *self.by_lay.entry([first, s, t, u, v, u32::from(clamp)]).or_insert_with(|| {
            self.textures.push(Texture { width, height, first, scale, offset, clamp });
            (self.textures.len() - 1) as u32
        })
    }

    /// The mean over a triangle of what is at these texture coordinates, by a grid of points; where that finds nothing,
    /// but something may be there, a little.
    pub fn mean(&self, texture: u32, uv: [[f32; 2]; 3]) -> [f32; 3] {
        let texture = &self.textures[texture as usize];
        let size = [texture.width as f32, texture.height as f32];
        let at = uv.map(|uv| [0, 1].map(|i| (uv[i] * texture.scale[i] + texture.offset[i]) * size[i]));
        let extent = [0, 1]
            .map(|i| at.map(|p| p[i]).into_iter().fold(0.0f32, |most, x| most.max((x - at[0][i]).abs())));
        let longest = extent[0].max(extent[1]);
        let steps = if longest.is_finite() { longest.ceil().clamp(2.0, 32.0) as u32 } else { 2 };
        let (mut sum, mut count) = ([0.0f64; 3], 0.0);
        for (i, j) in (0..steps).flat_map(|i| (0..steps - i).map(move |j| (i, j))) {
            let [u, v] = [i, j].map(|n| (n as f32 + 1.0 / 3.0) / steps as f32);
            let point = [0, 1].map(|k| at[0][k] + u * (at[1][k] - at[0][k]) + v * (at[2][k] - at[0][k]));
            self.add(&mut sum, texture, point);
            count += 1.0;
        }
        if sum.iter().any(|v| *v > 0.0) {
            return sum.map(|v| (v / count) as f32);
        }
        self.least(texture, at)
    }

    /// A tenth of the mean over the texels in and next to a triangle, in texels; of the whole texture if they are many.
    fn least(&self, texture: &Texture, at: [[f32; 2]; 3]) -> [f32; 3] {
        const MOST: f32 = 65_536.0;
        let low = [0, 1].map(|i| at.iter().fold(f32::INFINITY, |low, p| low.min(p[i])).floor() - 1.0);
        let high = [0, 1].map(|i| at.iter().fold(f32::NEG_INFINITY, |high, p| high.max(p[i])).ceil() + 1.0);
        let [columns, rows] = [0, 1].map(|i| high[i] - low[i]);
        let (mut sum, mut count) = ([0.0f64; 3], 0.0);
        let small = columns * rows <= MOST;
        let (from, size) = match small {
            true => (low, [columns as u32, rows as u32]),
            false => ([0.0; 2], [texture.width, texture.height]),
        };
        for (x, y) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))) {
            let point = [from[0] + x as f32 + 0.5, from[1] + y as f32 + 0.5];
            if !small || is_near(at, point) {
                self.add(&mut sum, texture, point);
                count += 10.0;
            }
        }
        sum.map(|v| (v / f64::max(count, 1.0)) as f32)
    }

    /// Adds the texel at a point in texels, upwards from the lower left corner.
    fn add(&self, sum: &mut [f64; 3], texture: &Texture, point: [f32; 2]) {
        let place = |x: f32, size: u32| match texture.clamp {
            true => (x.max(0.0) as u32).min(size - 1),
            false => (x.rem_euclid(size as f32) as u32).min(size - 1),
        };
        let (x, y) = (place(point[0], texture.width), texture.height - 1 - place(point[1], texture.height));
        let texel = self.texels[texture.first as usize + (y * texture.width) as usize + x as usize];
        (0..3).for_each(|i| sum[i] += f64::from(texel[i]));
    }

    /// The arrays that the core borrows.
    pub fn into_parts(self) -> (Vec<Texture>, Vec<[f32; 3]>) {
        (self.textures, self.texels)
    }
}

/// Whether a point is in a triangle or less than two texels beside it.
fn is_near(corners: [[f32; 2]; 3], [x, y]: [f32; 2]) -> bool {
    let edge = |i: usize| {
        let ([ax, ay], [bx, by]) = (corners[i], corners[(i + 1) % 3]);
        let (dx, dy) = (bx - ax, by - ay);
        (dx * (y - ay) - dy * (x - ax)) / dx.hypot(dy).max(f32::MIN_POSITIVE)
    };
    let distances = [edge(0), edge(1), edge(2)];
    distances.iter().all(|d| *d > -2.0) || distances.iter().all(|d| *d < 2.0)
}

/// Reads a picture by what it is, whatever its name says; the name counts where contents have no mark.
fn decode(path: &Path) -> Result<DynamicImage, String> {
    let open = |()| ImageReader::open(path).and_then(ImageReader::with_guessed_format);
    let mut reader = source::check_regular(path).and_then(open).map_err(|e| e.to_string())?;
    if reader.format().is_none() {
        // TGA has no mark.
        reader.set_format(ImageFormat::Tga);
    }
    pixels(reader)
}

/// Reads a picture in memory by what it is.
pub(super) fn decode_bytes(bytes: &[u8]) -> Result<DynamicImage, String> {
    let reader = ImageReader::new(std::io::Cursor::new(bytes)).with_guessed_format();
    pixels(reader.map_err(|e| e.to_string())?)
}

fn pixels(reader: ImageReader<impl BufRead + Seek>) -> Result<DynamicImage, String> {
    if reader.format() != Some(ImageFormat::OpenExr) {
        return reader.decode().map_err(|e| e.to_string().replace('\n', " "));
    }
    let (width, height, pixels) = openexr::rgba(reader.into_inner(), |_| Ok(()))?;
    let picture = Rgba32FImage::from_raw(width as u32, height as u32, pixels.into_flattened());
    picture.map(DynamicImage::ImageRgba32F).ok_or_else(|| "it has too many pixels".to_owned())
}

/// Whether the values of a picture are linear as they are.
pub(super) fn is_linear(picture: &DynamicImage) -> bool {
    matches!(picture, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_))
}

/// Linear value of an sRGB value (IEC 61966-2-1).
pub(super) fn linear(v: f32) -> f32 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}
