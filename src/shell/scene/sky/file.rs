//! Reads pictures of the sky: OpenEXR, and Radiance HDR by the crate `image`.

use super::map::SkyMap;
use crate::scene::error::Error;
use crate::scene::{openexr, source};
use exr::math::Vec2;
use exr::meta::MetaData;
use pmcip_core::tracer::scene::sky::MAX_SKY_SIDE;
use std::fs::File;
use std::path::Path;

/// The brightest that half precision holds: what is infinite was meant to be at least that.
const BRIGHTEST: f32 = 65504.0;

/// Most texels of a picture: 16384×8192 of them, 2 GB in memory.
const MOST_TEXELS: usize = 1 << 27;

struct Picture {
    size: (usize, usize),
    texels: Vec<[f32; 3]>,
}

impl SkyMap {
    /// Reads an equirectangular picture, EXR or Radiance HDR, and says what was odd about it.
    ///
    /// # Errors
    /// If it cannot be read or is too large.
    pub fn load(path: &Path) -> Result<(SkyMap, Vec<String>), Error> {
        load(path, 1.0)
    }
}

/// Reads a picture and multiplies it by `scale`.
pub(super) fn load(path: &Path, scale: f32) -> Result<(SkyMap, Vec<String>), Error> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let picture = match extension.as_str() {
        "exr" | "hdr" if source::check_regular(path).is_err() => {
            Err("it is missing, or no regular file".to_owned())
        }
        "exr" => read_exr(path),
        "hdr" => read_hdr(path),
        _ => Err("a sky is an .exr or .hdr file".to_owned()),
    };
    let Picture { size: (width, height), mut texels } = picture.map_err(|why| Error::in_file(path, why))?;
    let mut warnings = Vec::new();
    if width != 2 * height {
        let what = "an equirectangular picture is twice as wide as high";
        warnings.push(format!("{}: {what}, this one is {width}x{height}", path.display()));
    }
    let repaired = texels.iter_mut().map(|texel| repair(texel, scale)).filter(|repaired| *repaired).count();
    if repaired > 0 {
        let what = "texels are negative, infinite or not a number; made 0 or 65504";
        warnings.push(format!("{}: {repaired} {what}", path.display()));
    }
    let name = path.display().to_string();
    Ok((SkyMap::new((width as u32, height as u32), texels, None, name), warnings))
}

/// Scales a texel; makes a number of what is none, and says so.
fn repair(texel: &mut [f32; 3], scale: f32) -> bool {
    let sound = texel.map(|v| if v.is_nan() { 0.0 } else { v.clamp(0.0, f32::MAX) });
    let sound = sound.map(|v| if v == f32::MAX { BRIGHTEST } else { v });
    let repaired = sound != *texel;
    *texel = sound.map(|v| (v * scale).min(f32::MAX));
    repaired
}

/// Checks a size before there is memory for it.
fn check_size(width: usize, height: usize) -> Result<(), String> {
    let sides = 1..=MAX_SKY_SIDE as usize;
    let fits = sides.contains(&width) && sides.contains(&height) && width * height <= MOST_TEXELS;
    let most = || format!("a sky has at most {MOST_TEXELS} texels, this one {width}x{height}");
    if fits { Ok(()) } else { Err(most()) }
}

fn read_exr(path: &Path) -> Result<Picture, String> {
    let file = File::open(path).map_err(|e| e.to_string())?;
    let check = |head: &MetaData| {
        let size = head.headers.first().map_or(Vec2(0, 0), |header| header.layer_size);
        check_size(size.width(), size.height())
    };
    let (width, height, pixels) = openexr::rgba(file, check)?;
    Ok(Picture { size: (width, height), texels: pixels.into_iter().map(|[r, g, b, _]| [r, g, b]).collect() })
}

fn read_hdr(path: &Path) -> Result<Picture, String> {
    let reader = image::ImageReader::open(path).map_err(|e| e.to_string())?;
    let reader = reader.with_guessed_format().map_err(|e| e.to_string())?;
    if reader.format() != Some(image::ImageFormat::Hdr) {
        return Err("not a Radiance HDR picture".into());
    }
    let picture = reader.decode().map_err(|e| e.to_string())?.into_rgb32f();
    let size = (picture.width() as usize, picture.height() as usize);
    check_size(size.0, size.1)?;
    Ok(Picture { size, texels: picture.pixels().map(|pixel| pixel.0).collect() })
}
