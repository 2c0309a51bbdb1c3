//! The picture that all others are measured by: rendered once, kept beside the report.
//!
//! The file `reference.exr` names, as attributes, its samples a pixel and a hash (BLAKE3) of everything its light
//! depends on: geometry, materials, textures as loaded, camera, size, integrator, depth, this program's version and
//! [`PICTURE_VERSION`], which is raised with every change of the picture. It is used again only if both are those asked for. It is rendered in [`parts`], which tell its [`noise`]. A sequence has one for each frame, `reference.0001.exr` and so on.

pub mod noise;
pub mod parts;

pub use noise::{Noise, Source};

use super::spread::Spread;
use super::variant::Variant;
use crate::animation::sequence;
use crate::error::Error;
use crate::frame::settings::{Method, Settings};
use crate::frame::version::PICTURE_VERSION;
use crate::picture::frame_io::{self, Picture};
use crate::picture::metrics;
use crate::scene::LoadedScene;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Its name in the report's folder.
pub const FILE: &str = "reference.exr";
/// Its last seed; its parts have this one and those before it, and [`run`](super::run) gives them to no other render.
const SEED: u32 = u32::MAX;
/// Attribute with the hash.
const HASH: &str = "scene_hash";
/// What the hash begins with, so that another version or another meaning of its parts gives another hash.
const FORMAT: &str = concat!("pmcip ", env!("CARGO_PKG_VERSION"), " reference 3");

/// Where the reference came from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Origin {
    /// Rendered now.
    Rendered,
    /// Found in the report's folder.
    Reused,
    /// Named by the user.
    Given,
}

/// A reference and what is known of it.
#[derive(Clone, Debug, Serialize)]
pub struct Reference {
    /// Its file.
    pub file: PathBuf,
    /// Where it came from.
    pub origin: Origin,
    /// Samples a pixel, if the file says so.
    pub spp: Option<u32>,
    /// Its seed, if the file says so.
    pub seed: Option<u32>,
    /// Hash of the scene it shows, if the file says so.
    pub scene_hash: Option<String>,
    /// What its own noise adds to every Err, if anything tells it.
    pub noise_err: Option<f64>,
    /// Standard error of its energy over the energy, likewise.
    pub noise_energy: Option<f64>,
    /// Half the width of the interval of 95 % that follows from it.
    pub noise_energy_ci95: Option<f64>,
    /// What told the noise, if anything did.
    pub noise_source: Option<Source>,
    /// The picture.
    #[serde(skip)]
    pub picture: Picture,
}

impl Reference {
    fn new(file: PathBuf, origin: Origin, picture: Picture, cd_per_unit: f64) -> Reference {
        let attribute = |name: &str| picture.attributes.get(name);
        let number = |name: &str| attribute(name).and_then(|text| text.parse().ok());
        let noise = Noise::of(&picture, cd_per_unit);
        Reference {
            file,
            origin,
            spp: number("spp"),
            seed: number("seed"),
            scene_hash: attribute(HASH).cloned(),
            noise_err: noise.map(|noise| noise.err),
            noise_energy: noise.map(|noise| noise.energy.stderr),
            noise_energy_ci95: noise.map(|noise| noise.energy.ci95),
            noise_source: noise.map(|noise| noise.source),
            picture,
        }
    }

    /// Reads a reference that the user names.
    ///
    /// # Errors
    /// [`Error::Read`] if it cannot be read, [`Error::Sizes`] and [`Error::NotFinite`] if it does not fit `settings`.
    pub fn read(file: &Path, settings: &Settings, cd_per_unit: f32) -> Result<Reference, Error> {
        let picture = frame_io::read_exr(file)?;
        let blank = blank(settings.sampler.width, settings.sampler.height);
        metrics::measure(&blank, &picture, f64::from(cd_per_unit))?;
        Ok(Reference::new(file.into(), Origin::Given, picture, f64::from(cd_per_unit)))
    }

    /// Finds the reference in `file`.
    ///
    /// # Errors
    /// Why it cannot be used, in words that complete "renders the reference: …".
    pub fn find(
        file: &Path,
        scene: &LoadedScene,
        settings: &Settings,
        spp: u32,
    ) -> Result<Reference, String> {
        if !file.exists() {
            return Err("there is none yet".into());
        }
        let picture = frame_io::read_exr(file).map_err(|error| error.to_string())?;
        if picture.attributes.get(HASH) != Some(&fingerprint(scene, settings)) {
            return Err(format!(
                "{} shows another scene, size, integrator, depth or camera, or is of another version",
                file.display()
            ));
        }
        let known = picture.attributes.get("spp").map_or("unknown", String::as_str);
        if known != spp.to_string() {
            return Err(format!("{} has {known} samples a pixel, not {spp}", file.display()));
        }
        Ok(Reference::new(file.into(), Origin::Reused, picture, f64::from(scene.cd_per_unit)))
    }

    /// Standard error of its energy over the energy, if anything tells it.
    pub fn energy_noise(&self) -> Option<Spread> {
        let (stderr, ci95) = self.noise_energy.zip(self.noise_energy_ci95)?;
        Some(Spread { stderr, ci95 })
    }

    /// Renders the reference in [`parts`] and keeps it in `file`.
    ///
    /// # Errors
    /// As [`parts::render`], and [`Error::Write`].
    pub fn render(
        file: &Path,
        scene: &LoadedScene,
        settings: &Settings,
        spp: u32,
        threads: Option<usize>,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Reference, Error> {
        let uniform = |spp| {
            let mut uniform = Variant::from(Method::Uniform).settings(scene, settings, spp);
            uniform.sampler.frame = settings.sampler.frame;
            uniform
        };
        let mut picture = parts::render(scene, uniform, (spp, SEED), threads, progress)?;
        picture.attributes.insert(HASH.into(), fingerprint(scene, settings));
        frame_io::write_exr(file, &picture)?;
        Ok(Reference::new(file.into(), Origin::Rendered, picture, f64::from(scene.cd_per_unit)))
    }
}

/// Seeds that no other render must have, since the reference has them.
pub fn seeds(picture: &Picture) -> Option<std::ops::RangeInclusive<u32>> {
    let last: u32 = picture.attributes.get("seed")?.parse().ok()?;
    Some(last.saturating_sub(noise::seeds(picture) - 1)..=last)
}

/// The reference of a frame of a sequence, by the name of one of a still picture.
pub fn of_frame(file: &Path, frame: u32) -> PathBuf {
    sequence::path(file, frame)
}

/// A black picture, to see whether another one has its size.
fn blank(width: u32, height: u32) -> Picture {
    Picture { width, height, rgb: vec![[0.0; 3]; width as usize * height as usize], ..Picture::default() }
}

/// Hash of everything the light in a picture depends on.
pub fn fingerprint(scene: &LoadedScene, settings: &Settings) -> String {
    fingerprint_of(PICTURE_VERSION, scene, settings)
}

/// The same for a program that makes such pictures.
fn fingerprint_of(picture_version: u32, scene: &LoadedScene, settings: &Settings) -> String {
    let mut hash = blake3::Hasher::new();
    let mut add = |part: &[u8]| {
        // Lengths keep what ends one part from counting as the beginning of the next.
        hash.update(&(part.len() as u64).to_le_bytes());
        hash.update(part);
    };
    add(FORMAT.as_bytes());
    add(&picture_version.to_le_bytes());
    add(bytemuck::cast_slice(&scene.triangles));
    add(bytemuck::cast_slice(&scene.surfaces));
    if !scene.moved.triangles.is_empty() {
        add(bytemuck::cast_slice(&scene.moved.triangles));
        add(bytemuck::cast_slice(&scene.moved.normals));
    }
    add(bytemuck::cast_slice(&scene.materials));
    add(bytemuck::cast_slice(&scene.colours));
    if !scene.normal_maps.is_empty() {
        add(bytemuck::cast_slice(&scene.normal_maps));
    }
    for t in &scene.textures {
        add(bytemuck::cast_slice(&[t.width, t.height, t.first, u32::from(t.clamp)]));
        add(bytemuck::cast_slice(&[t.scale, t.offset]));
    }
    add(bytemuck::cast_slice(&scene.texels));
    if let Some(sky) = &scene.sky {
        add(bytemuck::cast_slice(&[sky.width, sky.height, u32::from(sky.visible)]));
        add(bytemuck::cast_slice(&sky.texels));
        add(bytemuck::cast_slice(&sky.axes));
        let sun = sky.sun.map(|sun| [sun.direction, sun.radiance, [sun.radius, 0.0, 0.0]]);
        add(bytemuck::cast_slice(sun.as_slice()));
    }
    let view = &settings.view;
    add(bytemuck::cast_slice(&[view.from, view.at, view.up]));
    add(&view.fov.to_le_bytes());
    for lens in [Some(*view), settings.closing_view].into_iter().flatten().filter(|v| v.aperture > 0.0) {
        add(bytemuck::cast_slice(&[lens.aperture, lens.focus.unwrap_or(0.0)]));
    }
    if let Some(view) = &settings.closing_view {
        add(bytemuck::cast_slice(&[view.from, view.at, view.up, [view.fov, 0.0, 0.0]]));
    }
    add(&scene.cd_per_unit.to_le_bytes());
    let numbers = [settings.sampler.width, settings.sampler.height, settings.max_depth];
    add(bytemuck::cast_slice(&numbers));
    add(settings.integrator.limit().as_bytes());
    hash.finalize().to_hex().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reference_does_not_survive_a_change_of_the_picture() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell.toml");
        let scene = crate::scene::load(&file).unwrap();
        let settings = Settings::new(&scene, Method::Uniform, Some(4), Some((8, 8)));
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(FILE);
        let mut picture = Reference::render(&file, &scene, &settings, 4, Some(1), &|_| ()).unwrap().picture;
        assert!(Reference::find(&file, &scene, &settings, 4).is_ok());
        picture.attributes.insert(HASH.into(), fingerprint_of(PICTURE_VERSION - 1, &scene, &settings));
        frame_io::write_exr(&file, &picture).unwrap();
        assert!(Reference::find(&file, &scene, &settings, 4).unwrap_err().contains("another version"));
    }

    #[test]
    fn seeds_of_a_reference_are_those_of_its_parts() {
        let of = |list: &[(&str, &str)]| {
            let attributes = list.iter().map(|(name, value)| ((*name).into(), (*value).into())).collect();
            seeds(&Picture { attributes, ..Picture::default() })
        };
        assert_eq!(of(&[("seed", "9"), ("parts", "8")]), Some(2..=9));
        assert_eq!(of(&[("seed", "9")]), Some(9..=9));
        assert_eq!(of(&[("seed", "1"), ("parts", "8")]), Some(0..=1));
        assert_eq!(of(&[]), None);
    }
}
