//! What an MTL file states, material by material.

use super::complaints::Complaints;
use super::lines::{data, logical_lines, split, without_comment};
use super::maps::{self, Map};
use crate::scene::error::Error;
use std::collections::BTreeMap;

/// What became of lines.
const IGNORED: &str = "line left out";

/// A material as stated.
#[derive(Clone, Debug, Default)]
pub(super) struct Stated {
    pub name: String,
    pub kd: Option<[f32; 3]>,
    pub ks: Option<[f32; 3]>,
    pub ke: Option<[f32; 3]>,
    pub tf: Option<[f32; 3]>,
    pub ns: Option<f32>,
    pub ni: Option<f32>,
    pub d: Option<f32>,
    pub tr: Option<f32>,
    /// Roughness and metal of the PBR extension.
    pub pr: Option<f32>,
    pub pm: Option<f32>,
    pub illum: Option<u32>,
    pub map_kd: Option<Map>,
    pub map_ke: Option<Map>,
    pub map_d: Option<Map>,
    pub map_ka: Option<Map>,
    pub norm: Option<Map>,
}

/// An MTL file.
#[derive(Debug, Default)]
pub(super) struct Library {
    pub materials: Vec<Stated>,
    /// Statements without effect, and how many there are.
    pub without_effect: BTreeMap<String, usize>,
    /// A key whose letters are not of the case they should be.
    pub odd_case: Option<String>,
}

/// Spellings of the keys that mean something.
const KEYS: [&str; 19] = [
    "newmtl", "Kd", "Ks", "Ke", "Ka", "Tf", "Ns", "Ni", "d", "Tr", "Pr", "Pm", "illum", "map_Kd", "map_Ke",
    "map_d", "map_Ka", "map_aat", "norm",
];

/// Reads the text of an MTL file.
///
/// # Errors
/// The first complaint, where files are taken strictly.
pub(super) fn read(source: &str, complaints: &mut Complaints<'_>) -> Result<Library, Error> {
    let mut library = Library::default();
    for (number, line) in logical_lines(source) {
        let (key, rest) = split(&line);
        if key.is_empty() || key.starts_with('#') {
            continue;
        }
        let Some(known) = KEYS.iter().find(|known| known.eq_ignore_ascii_case(key)) else {
            *library.without_effect.entry(key.to_owned()).or_default() += 1;
            continue;
        };
        if *known != key && library.odd_case.is_none() {
            library.odd_case = Some(format!("{key} (for {known})"));
        }
        if let Err(message) = library.state(known, rest) {
            let name = library.materials.last().map_or("", |material| &material.name);
            complaints.note(number, IGNORED, || format!("material \"{name}\": {key}: {message}"))?;
        }
    }
    Ok(library)
}

impl Library {
    /// Takes in a statement.
    fn state(&mut self, key: &str, rest: &str) -> Result<(), String> {
        if key == "newmtl" {
            if rest.is_empty() {
                return Err("expected a name".to_owned());
            }
            self.materials.push(Stated { name: rest.to_owned(), ..Stated::default() });
            return Ok(());
        }
        let map = if key.starts_with("map_K") || key == "map_d" || key == "norm" {
            Some(self.map(rest)?)
        } else {
            None
        };
        let Some(material) = self.materials.last_mut() else {
            return Err("expected a newmtl before it".to_owned());
        };
        match key {
            "Kd" => material.kd = Some(colour(rest)?),
            "Ks" => material.ks = Some(colour(rest)?),
            "Ke" => material.ke = Some(colour(rest)?),
            "Tf" => material.tf = Some(colour(rest)?),
            "Ns" => material.ns = Some(last(rest)?),
            "Ni" => material.ni = Some(above_zero(last(rest)?)?),
            "d" => material.d = Some(last(rest)?),
            "Tr" => material.tr = Some(last(rest)?),
            "Pr" => material.pr = Some(last(rest)?),
            "Pm" => material.pm = Some(last(rest)?),
            "illum" => material.illum = Some(finite(words(rest).next())?.clamp(0.0, 1e6) as u32),
            "map_Kd" => material.map_kd = map,
            "map_Ke" => material.map_ke = map,
            "map_d" => material.map_d = map,
            "map_Ka" => material.map_ka = map,
            "norm" => material.norm = map,
            _ => {}
        }
        Ok(())
    }

    fn map(&mut self, text: &str) -> Result<Map, String> {
        let map = maps::parse(text);
        if without_comment(&map.name).is_empty() || map.name.starts_with('#') {
            return Err("expected a name".to_owned());
        }
        for option in &map.skipped {
            *self.without_effect.entry(format!("option {option}")).or_default() += 1;
        }
        Ok(map)
    }
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    data(text).split_whitespace()
}

/// Three numbers, or one for all three channels.
fn colour(text: &str) -> Result<[f32; 3], String> {
    let mut words = words(text).filter(|word| !word.eq_ignore_ascii_case("rgb")).peekable();
    if words
        .peek()
        .is_some_and(|word| word.eq_ignore_ascii_case("spectral") || word.eq_ignore_ascii_case("xyz"))
    {
        return Err("expected red, green and blue, found another kind of colour".to_owned());
    }
    let red = finite(words.next())?;
    match words.next() {
        None => Ok([red; 3]),
        green => Ok([red, finite(green)?, finite(words.next())?]),
    }
}

/// The last number: `d` may have an option before it.
fn last(text: &str) -> Result<f32, String> {
    finite(words(text).last())
}

fn above_zero(value: f32) -> Result<f32, String> {
    if value > 0.0 { Ok(value) } else { Err("expected an index above 0".to_owned()) }
}

fn finite(word: Option<&str>) -> Result<f32, String> {
    let word = word.ok_or("expected a number, found the end of the line")?;
    let value = word.parse::<f32>().or_else(|_| word.replacen(',', ".", 1).parse::<f32>());
    value
        .ok()
        .filter(|value| value.is_finite())
        .ok_or_else(|| format!("expected a finite number, found \"{word}\""))
}
