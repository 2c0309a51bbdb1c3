//! What the core makes of a material that an MTL file states.
//!
//! * `Ke` emits, as radiance, on the front side; `map_Ke` multiplies it.
//! * Transparency is stated by `d` below 1, by `Tr` where there is no `d`, or by `Tf` below 1. Where there is an index too
//!   (`Ni`, not one) what is mostly transparent (`d` up to ½, or `Tf` alone) is a clear dielectric, not tinted: `Tf` is
//!   written in too many meanings to colour glass by. Else the part `d` is there and the rest is not. `map_d`, or the alpha of `map_Kd`,
//!   multiplies it. `illum` 4, 6, 7 and 9 alone state nothing: Maya and others write them for everything. With an index they
//!   are glass, too, where all that is said besides is a black `Kd`, by which nothing else would be seen.
//! * `illum` 3 and 5 are a perfect mirror tinted by `Ks` where nothing else is said (no `Kd` but black, no `Ns`).
//! * All else is diffuse `Kd`, times `map_Kd`, plus a GGX lobe `Ks` of roughness √(2/(Ns+2)), or of `Pr` squared; `Pm`
//!   turns `Kd` into the colour of a metal.
//!
//! What is above 1 is clamped, with a note. Ambient light (`Ka`) is what is computed here.

use super::find::find;
use super::lines::without_comment;
use super::maps::Map;
use super::stated::Stated;
use crate::scene::assemble::Assembly;
use crate::scene::notes::Notes;
use crate::scene::texture::{Loaded, Purpose};
use pmcip_core::tracer::scene::{MIN_ROUGHNESS, Material, NO_TEXTURE, Scattering};
use std::path::{Path, PathBuf};

/// Up to so much of `d` a material with an index is glass.
const MOSTLY_CLEAR: f32 = 0.5;

/// Reflectance at normal incidence of what states roughness alone.
const PLASTIC: f32 = 0.04;

/// Converts a material of the MTL file `file` that the OBJ file `obj` uses; and its normal map, if it has any.
pub(super) fn convert(
    obj: &Path,
    file: &Path,
    stated: &Stated,
    notes: &mut Notes,
    assembly: &mut Assembly,
) -> (Material, Option<u32>) {
    Converter { obj, file, stated, notes, assembly }.convert()
}

struct Converter<'a> {
    obj: &'a Path,
    file: &'a Path,
    stated: &'a Stated,
    notes: &'a mut Notes,
    assembly: &'a mut Assembly,
}

impl Converter<'_> {
    fn note(&mut self, kind: &'static str, message: &str) {
        let name = &self.stated.name;
        self.notes.add(kind, || format!("material \"{name}\": {message}"));
    }

    fn convert(&mut self) -> (Material, Option<u32>) {
        let stated = self.stated;
        let colour = stated.map_kd.as_ref().and_then(|map| self.texture("map_Kd", map, Purpose::Colour));
        let unstated = if colour.is_some() { [1.0; 3] } else { [0.5; 3] };
        let mut material = Material {
            texture: colour.map_or(NO_TEXTURE, |loaded| loaded.texture),
            diffuse: self.reflectance("Kd", stated.kd.unwrap_or(unstated)),
            roughness: roughness(stated),
            emission: self.emission(),
            ..Material::default()
        };
        self.scatter(&mut material);
        self.cut_out(&mut material, colour);
        if let Some(map) = &stated.map_ke {
            self.glow(&mut material, map);
        }
        if stated
            .map_ka
            .as_ref()
            .is_some_and(|map| stated.map_kd.as_ref().is_none_or(|kd| kd.name != map.name))
        {
            self.note("map_Ka", "map_Ka is without effect here");
        }
        let map = self.bend(&material);
        (material, map)
    }

    /// The normal map, if there is one.
    fn bend(&mut self, material: &Material) -> Option<u32> {
        let map = self.stated.norm.as_ref()?;
        if material.scattering != Scattering::Rough {
            self.note("norm", "norm is without effect on mirrors and glass");
            return None;
        }
        self.texture("norm", map, Purpose::Normal(1.0)).map(|loaded| loaded.texture)
    }

    /// Chooses between rough, mirror and glass.
    fn scatter(&mut self, material: &mut Material) {
        let stated = self.stated;
        let is_black = |colour: Option<[f32; 3]>| colour.is_none_or(|colour| colour == [0.0; 3]);
        let only_mirrors =
            is_black(stated.kd) && stated.map_kd.is_none() && stated.ns.is_none() && stated.pr.is_none();
        if self.is_glass() {
            material.scattering = Scattering::Dielectric;
            material.specular = [1.0; 3];
            material.ior = stated.ni.unwrap_or(material.ior);
        } else if matches!(stated.illum, Some(3 | 5)) && only_mirrors {
            material.scattering = Scattering::Mirror;
            material.specular = self.reflectance("Ks", stated.ks.unwrap_or([1.0; 3]));
        } else {
            let by_roughness = if stated.pr.or(stated.pm).is_some() { PLASTIC } else { 0.0 };
            material.specular = self.reflectance("Ks", stated.ks.unwrap_or([by_roughness; 3]));
            self.metal(material);
            if (0..3).any(|i| material.diffuse[i] + material.specular[i] > 1.0 + f32::EPSILON) {
                self.note("sum", "Kd + Ks is above 1: it may reflect more light than it gets");
            }
        }
    }

    /// Turns the part `Pm` of a material into metal, whose colour is that of its mirror images.
    fn metal(&mut self, material: &mut Material) {
        let metal = self.stated.pm.unwrap_or(0.0).clamp(0.0, 1.0);
        if metal == 0.0 {
            return;
        }
        if material.texture != NO_TEXTURE {
            self.note("Pm", "Pm is without effect beside map_Kd");
            return;
        }
        for i in 0..3 {
            material.specular[i] += metal * (material.diffuse[i] - material.specular[i]);
            material.diffuse[i] *= 1.0 - metal;
        }
    }

    /// How much is there by `d`, or by `Tr` where there is no `d`.
    fn opacity(&mut self) -> f32 {
        let Stated { d, tr, .. } = *self.stated;
        let stated = match (d, tr) {
            (Some(d), Some(tr)) if (d + tr - 1.0).abs() > 1e-3 => {
                self.note("Tr", "d and Tr contradict each other: d counts");
                d
            }
            (Some(d), _) => d,
            (None, Some(tr)) if tr >= 1.0 => {
                self.note("Tr", "Tr 1 without d is taken for opaque, which some programs mean by it");
                1.0
            }
            (None, Some(tr)) => 1.0 - tr,
            (None, None) => 1.0,
        };
        stated.clamp(0.0, 1.0)
    }

    fn is_glass(&mut self) -> bool {
        let filters = self.stated.tf.is_some_and(|tf| tf.iter().any(|v| *v < 1.0));
        let refracts = self.stated.ni.is_some_and(|ni| ni != 1.0);
        let opacity = self.opacity();
        let is_clear = opacity <= MOSTLY_CLEAR || opacity == 1.0 && filters || self.is_black_but_for_glass();
        refracts && is_clear
    }

    /// Whether the material would be black if its `illum` did not mean glass, and says nothing of how opaque it is.
    fn is_black_but_for_glass(&self) -> bool {
        let Stated { illum, kd, ks, ns, pr, pm, ke, tf, d, tr, map_kd, map_d, map_ke, .. } = self.stated;
        let maps = [map_kd, map_d, map_ke];
        let is_dark = |colour: &Option<[f32; 3]>| colour.is_none_or(|colour| colour == [0.0; 3]);
        matches!(illum, Some(4 | 6 | 7 | 9))
            && *kd == Some([0.0; 3])
            && is_dark(ke)
            && (is_dark(ks) || ns.or(*pr).is_none())
            && pm.is_none()
            && tf.is_none()
            && d.or(*tr).is_none()
            && maps.iter().all(|map| map.is_none())
    }

    /// Says how much of the surface is there.
    fn cut_out(&mut self, material: &mut Material, colour: Option<Loaded>) {
        if material.scattering == Scattering::Dielectric {
            return;
        }
        material.opacity = self.opacity();
        let tf = self.stated.tf.filter(|tf| tf.iter().any(|v| *v < 1.0));
        if let Some(tf) = tf.filter(|_| material.opacity == 1.0) {
            match self.stated.illum {
                Some(4 | 6 | 7 | 9) => material.opacity = (tf.iter().sum::<f32>() / 3.0).clamp(0.0, 1.0),
                _ => self.note("Tf", "Tf without an index (Ni) is without effect here"),
            }
        }
        if material.opacity == 0.0 {
            self.note("d", "d is 0: nothing is seen of it");
        }
        let alpha = colour.and_then(|loaded| loaded.alpha);
        let mask = self.stated.map_d.as_ref().and_then(|map| self.texture("map_d", map, Purpose::Mask));
        material.opacity_texture = mask.map(|loaded| loaded.texture).or(alpha).unwrap_or(NO_TEXTURE);
    }

    /// Lets a texture shine. What lamps are chosen by is found triangle by triangle, when they are added.
    fn glow(&mut self, material: &mut Material, map: &Map) {
        let tint = match self.stated.ke {
            Some([0.0, 0.0, 0.0]) => {
                self.note("map_Ke", "map_Ke with a black Ke: taken as it is");
                [1.0; 3]
            }
            Some(_) => material.emission,
            None => [1.0; 3],
        };
        if let Some(loaded) = self.texture("map_Ke", map, Purpose::Light(tint)) {
            material.emission_texture = loaded.texture;
            material.emission = [0.0; 3];
        }
    }

    fn reflectance(&mut self, key: &'static str, value: [f32; 3]) -> [f32; 3] {
        let clamped = value.map(|v| v.clamp(0.0, 1.0));
        if clamped != value {
            self.note(key, &format!("{key} is outside 0 to 1: clamped"));
        }
        clamped
    }

    fn emission(&mut self) -> [f32; 3] {
        let value = self.stated.ke.unwrap_or_default();
        let clamped = value.map(|v| v.max(0.0));
        if clamped != value {
            self.note("Ke", "Ke is below 0: clamped");
        }
        clamped
    }

    /// The texture of a map, or none with a note.
    fn texture(&mut self, key: &'static str, map: &Map, purpose: Purpose) -> Option<Loaded> {
        let mut lay = map.lay;
        let found = self.find(&map.name).or_else(|| self.find(without_comment(&map.name))).or_else(|| {
            let (name, after) = map.shorter.as_ref()?;
            lay = *after;
            self.find(name)
        });
        let Some((path, looked_for)) = found else {
            self.note(key, &format!("{key}: {}: no such file: left out", map.name));
            return None;
        };
        if looked_for {
            self.note("name", &format!("{key}: {}: taken for {}", map.name, path.display()));
        }
        match self.assembly.textures.load(&path, purpose, lay) {
            Ok(loaded) => Some(loaded),
            Err(reason) => {
                self.note(key, &format!("{key}: {}: {reason}: left out", path.display()));
                None
            }
        }
    }

    /// A file named in the MTL, beside that or beside the OBJ.
    fn find(&self, name: &str) -> Option<(PathBuf, bool)> {
        find(self.file, name).or_else(|| find(self.obj, name))
    }
}

/// Width of the lobe: the square of `Pr`, or that of a Phong exponent, by equal slope variance (Walter et al. 2007).
fn roughness(stated: &Stated) -> f32 {
    match stated.pr {
        Some(pr) => (pr * pr).clamp(MIN_ROUGHNESS, 1.0),
        None => (2.0 / (stated.ns.unwrap_or(0.0).max(0.0) + 2.0)).sqrt().max(MIN_ROUGHNESS),
    }
}
