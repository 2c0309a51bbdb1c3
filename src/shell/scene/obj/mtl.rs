//! Materials from MTL files, through tobj.
//!
//! `Ke` emits, as radiance, on the front side; `illum` 3 and 5 are a perfect mirror tinted by `Ks`; `illum` 4, 6,
//! 7 and 9, or `Tf` or `d` below 1 with `Ni` other than 1, a clear dielectric of index `Ni`, not tinted (`Tf` is
//! written in too many meanings to colour glass by); all else is diffuse `Kd` plus a GGX lobe `Ks` of roughness
//! √(2/(Ns+2)). `map_Kd` multiplies `Kd`. What is above 1 is clamped, with a warning.

use super::lines::{data, logical_lines, split};
use super::text::CheckedObj;
use crate::scene::assemble::Assembly;
use crate::scene::error::{Error, read};
use pmcip_core::tracer::scene::{MIN_ROUGHNESS, Material, NO_TEXTURE, Scattering};
use std::collections::HashMap;
use std::fmt::Write;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The index of a dielectric that does not give one: glass.
const DEFAULT_IOR: f32 = 1.5;

/// A material and the file it stands in.
type Found = HashMap<String, (PathBuf, tobj::Material)>;

/// Adds the materials that an OBJ uses and returns their indices, in the order of `obj.materials`.
pub(super) fn load(path: &Path, obj: &CheckedObj, assembly: &mut Assembly) -> Result<Vec<u32>, Error> {
    let mut found = Found::new();
    for library in &obj.libraries {
        for file in files_of(path, library) {
            read_library(path, &file, &mut found, assembly)?;
        }
    }
    let mut missing = Vec::new();
    let mut indices = Vec::new();
    for name in &obj.materials {
        let material = match found.get(name) {
            Some((file, source)) => convert(file, source, assembly)?,
            None => {
                missing.push(format!("\"{name}\""));
                Material::default()
            }
        };
        indices.push(assembly.add_material(material));
    }
    if !missing.is_empty() {
        let names = missing.join(", ");
        assembly.warn(format!("{}: no MTL file defines {names}: grey instead", path.display()));
    }
    Ok(indices)
}

/// The files a `mtllib` line means: one name that may hold blanks, or several.
fn files_of(obj: &Path, library: &str) -> Vec<PathBuf> {
    let whole = obj.with_file_name(library.replace('\\', "/"));
    if whole.exists() {
        return vec![whole];
    }
    library.split_whitespace().map(|name| obj.with_file_name(name.replace('\\', "/"))).collect()
}

/// Reads an MTL file; one that is not there is worth a warning only.
fn read_library(obj: &Path, file: &Path, found: &mut Found, assembly: &mut Assembly) -> Result<(), Error> {
    let source = match read(file) {
        Err(Error::Read { source, .. }) if source.kind() == ErrorKind::NotFound => {
            assembly.warn(format!("{}: the material file {} is missing", obj.display(), file.display()));
            return Ok(());
        }
        other => other?,
    };
    let text = checked(file, &source)?;
    let (materials, _) =
        tobj::load_mtl_buf(&mut text.as_bytes()).map_err(|e| Error::in_file(file, e.to_string()))?;
    for material in materials {
        found.insert(material.name.clone(), (file.to_owned(), material));
    }
    Ok(())
}

/// The lines that matter, with colours of three numbers: tobj panics on fewer.
fn checked(path: &Path, source: &str) -> Result<String, Error> {
    let mut text = String::new();
    let mut name = String::new();
    for (number, line) in logical_lines(source) {
        let (key, rest) = split(&line);
        let value = match key {
            "Kd" | "Ks" | "Ke" | "Tf" => colour(rest).map(|[r, g, b]| format!("{r} {g} {b}")),
            "Ns" | "Ni" | "d" => finite(data(rest).split_whitespace().last()).map(|v| v.to_string()),
            "illum" => finite(data(rest).split_whitespace().next()).map(|v| (v as u8).to_string()),
            "newmtl" | "map_Kd" if rest.is_empty() => Err("expected a name".to_owned()),
            "newmtl" | "map_Kd" => Ok(rest.to_owned()),
            _ => continue,
        };
        if key == "newmtl" {
            name = rest.to_owned();
        }
        let value = value.map_err(|m| Error::at(path, number, format!("material \"{name}\": {key}: {m}")))?;
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{key} {value}");
    }
    Ok(text)
}

/// Three numbers, or one for all three channels.
fn colour(text: &str) -> Result<[f32; 3], String> {
    let mut words = data(text).split_whitespace();
    let red = finite(words.next())?;
    match words.next() {
        None => Ok([red; 3]),
        green => Ok([red, finite(green)?, finite(words.next())?]),
    }
}

fn finite(word: Option<&str>) -> Result<f32, String> {
    let word = word.ok_or("expected a number, found the end of the line")?;
    match word.parse::<f32>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("expected a finite number, found \"{word}\"")),
    }
}

/// What the core makes of a material.
fn convert(file: &Path, source: &tobj::Material, assembly: &mut Assembly) -> Result<Material, Error> {
    let context = format!("{}: material \"{}\"", file.display(), source.name);
    let texture = match &source.diffuse_texture {
        Some(name) => texture(file, name, &context, assembly),
        None => NO_TEXTURE,
    };
    let unstated = if texture == NO_TEXTURE { [0.5; 3] } else { [1.0; 3] };
    let mut material = Material {
        scattering: scattering(source),
        texture,
        diffuse: reflectance(source.diffuse.unwrap_or(unstated), "Kd", &context, assembly),
        roughness: roughness(source.shininess.unwrap_or(0.0)),
        emission: emission(source.emissive.unwrap_or_default(), &context, assembly),
        ..Material::default()
    };
    let mut specular = |unstated| reflectance(source.specular.unwrap_or(unstated), "Ks", &context, assembly);
    match material.scattering {
        Scattering::Rough => material.specular = specular([0.0; 3]),
        Scattering::Mirror => material.specular = specular([1.0; 3]),
        Scattering::Dielectric => {
            material.specular = [1.0; 3];
            material.ior = source.optical_density.unwrap_or(DEFAULT_IOR);
        }
    }
    if material.ior <= 0.0 {
        let message = format!("material \"{}\": Ni: expected an index above 0", source.name);
        return Err(Error::in_file(file, message));
    }
    if reflects_more_than_all(&material) {
        assembly.warn(format!("{context}: Kd + Ks is above 1: it may reflect more light than it gets"));
    }
    Ok(material)
}

fn reflects_more_than_all(material: &Material) -> bool {
    let sums = (0..3).map(|i| material.diffuse[i] + material.specular[i]);
    material.scattering == Scattering::Rough && sums.into_iter().any(|sum| sum > 1.0 + f32::EPSILON)
}

fn scattering(source: &tobj::Material) -> Scattering {
    let filters = |tf: &String| tf.split_whitespace().any(|v| v.parse::<f32>().is_ok_and(|v| v < 1.0));
    let transmits =
        source.dissolve.is_some_and(|d| d < 1.0) || source.unknown_param.get("Tf").is_some_and(filters);
    let refracts = source.optical_density.is_some_and(|ni| ni != 1.0);
    match source.illumination_model {
        Some(3 | 5) => Scattering::Mirror,
        Some(4 | 6 | 7 | 9) => Scattering::Dielectric,
        _ if transmits && refracts => Scattering::Dielectric,
        _ => Scattering::Rough,
    }
}

/// GGX width of a Phong exponent, by equal slope variance (Walter et al. 2007).
fn roughness(exponent: f32) -> f32 {
    (2.0 / (exponent.max(0.0) + 2.0)).sqrt().max(MIN_ROUGHNESS)
}

fn reflectance(value: [f32; 3], key: &str, context: &str, assembly: &mut Assembly) -> [f32; 3] {
    let clamped = value.map(|v| v.clamp(0.0, 1.0));
    if clamped != value {
        assembly.warn(format!("{context}: {key} is outside 0 to 1: clamped"));
    }
    clamped
}

fn emission(value: [f32; 3], context: &str, assembly: &mut Assembly) -> [f32; 3] {
    let clamped = value.map(|v| v.max(0.0));
    if clamped != value {
        assembly.warn(format!("{context}: Ke is below 0: clamped"));
    }
    clamped
}

/// The texture of a `map_Kd` line, or none with a warning.
fn texture(file: &Path, value: &str, context: &str, assembly: &mut Assembly) -> u32 {
    let mut name = value;
    if value.starts_with('-') {
        name = value.split_whitespace().last().unwrap_or(value);
        assembly.warn(format!("{context}: the options of map_Kd are ignored"));
    }
    let path = file.with_file_name(name.replace('\\', "/"));
    match assembly.textures.load(&path) {
        Ok(index) => index,
        Err(reason) => {
            assembly.warn(format!("{context}: map_Kd: {}: {reason}: Kd instead", path.display()));
            NO_TEXTURE
        }
    }
}
