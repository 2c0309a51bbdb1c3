//! Materials from MTL files: which files, which material a name means, and what is said about them.

use super::complaints::Complaints;
use super::find::find;
use super::lines::without_comment;
use super::material::convert;
use super::read::Obj;
use super::stated::{self, Library, Stated};
use crate::scene::assemble::Assembly;
use crate::scene::error::{Error, read};
use crate::scene::notes::Notes;
use pmcip_core::tracer::scene::Material;
use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

/// Names that a warning lists at most.
const NAMES: usize = 5;

/// Materials by name.
#[derive(Debug, Default)]
struct Found {
    files: Vec<PathBuf>,
    materials: Vec<(usize, Stated)>,
    /// By the name as written, without a comment, in lower case.
    by_name: [HashMap<String, usize>; 3],
}

impl Found {
    fn add(&mut self, file: &Path, library: Library) {
        let number = self.files.len();
        self.files.push(file.to_owned());
        for material in library.materials {
            let index = self.materials.len();
            for (map, name) in self.by_name.iter_mut().zip(spellings(&material.name)) {
                map.insert(name, index);
            }
            self.materials.push((number, material));
        }
    }

    /// The material that is meant, and whether its name had to be bent in its letters' case.
    fn get(&self, name: &str) -> Option<(usize, bool)> {
        let [whole, short, lower] = spellings(name);
        let [by_whole, by_short, by_lower] = &self.by_name;
        let exact = by_whole.get(&whole).or_else(|| by_whole.get(&short)).or_else(|| by_short.get(&short));
        exact.map(|index| (*index, false)).or_else(|| by_lower.get(&lower).map(|index| (*index, true)))
    }
}

/// A name as written, without a comment, in lower case.
fn spellings(name: &str) -> [String; 3] {
    let short = without_comment(name);
    [name.to_owned(), short.to_owned(), short.to_lowercase()]
}

/// Adds the materials that an OBJ uses and returns their indices, in the order of `obj.materials`.
pub(super) fn load(path: &Path, obj: &Obj<'_>, assembly: &mut Assembly) -> Result<Vec<u32>, Error> {
    let mut found = Found::default();
    let mut seen = BTreeSet::new();
    for library in &obj.libraries {
        for file in files_of(path, library, assembly) {
            if seen.insert(file.clone()) {
                read_library(&file, &mut found, assembly)?;
            }
        }
    }
    if found.files.is_empty() && !obj.materials.is_empty() {
        read_namesake(path, &mut found, assembly)?;
    }
    let mut notes: Vec<Notes> = found.files.iter().map(|_| Notes::default()).collect();
    let (mut missing, mut bent, mut indices) = (Vec::new(), Vec::new(), Vec::new());
    for name in &obj.materials {
        let (material, map) = match found.get(name) {
            Some((index, is_bent)) => {
                let (file, stated) = &found.materials[index];
                bent.extend(is_bent.then(|| format!("\"{name}\" for \"{}\"", stated.name)));
                convert(path, &found.files[*file], stated, &mut notes[*file], assembly)
            }
            None => {
                missing.push(format!("\"{name}\""));
                (Material::default(), None)
            }
        };
        let index = assembly.add_named(material, name);
        if let Some(map) = map {
            assembly.bend(index, map);
        }
        indices.push(index);
    }
    found.files.iter().zip(notes).for_each(|(file, notes)| notes.warn(file, "materials", assembly));
    let name = path.display();
    if !missing.is_empty() {
        assembly.warn(format!("{name}: no MTL file defines {}: grey instead", list(&missing)));
    }
    if !bent.is_empty() {
        assembly.warn(format!("{name}: materials differ in the case of letters: {}", list(&bent)));
    }
    Ok(indices)
}

/// The first of many, and how many more there are.
fn list(names: &[String]) -> String {
    let more = names.len().saturating_sub(NAMES);
    let first = names[..names.len() - more].join(", ");
    if more > 0 { format!("{first} and {more} more") } else { first }
}

/// The files that a `mtllib` line means: one name that may hold blanks, or several.
fn files_of(obj: &Path, library: &str, assembly: &mut Assembly) -> Vec<PathBuf> {
    for name in [library, without_comment(library)] {
        if let Some(file) = look(obj, name, assembly) {
            return vec![file];
        }
    }
    let mut files = Vec::new();
    for name in without_comment(library).split_whitespace() {
        match look(obj, name, assembly) {
            Some(file) => files.push(file),
            None => assembly.warn(format!("{}: the material file {name} is missing", obj.display())),
        }
    }
    files
}

/// The file that is meant by a name, with a note if that is not quite its own.
fn look(obj: &Path, name: &str, assembly: &mut Assembly) -> Option<PathBuf> {
    let (file, looked_for) = find(obj, name)?;
    if looked_for {
        assembly.warn(format!("{}: mtllib {name}: taken for {}", obj.display(), file.display()));
    }
    Some(file)
}

/// Reads the MTL file that is called as the OBJ is, where the OBJ names none that is there.
fn read_namesake(path: &Path, found: &mut Found, assembly: &mut Assembly) -> Result<(), Error> {
    let name = path.with_extension("mtl").file_name().unwrap_or_default().to_string_lossy().into_owned();
    let Some((file, _)) = find(path, &name) else { return Ok(()) };
    assembly.warn(format!("{}: no mtllib that is there: {} instead", path.display(), file.display()));
    read_library(&file, found, assembly)
}

fn read_library(file: &Path, found: &mut Found, assembly: &mut Assembly) -> Result<(), Error> {
    let mut complaints = Complaints::new(file, assembly.strict);
    let library = match read(file) {
        Ok(text) => stated::read(&text, &mut complaints)?,
        Err(error) if assembly.strict => return Err(error),
        Err(error) => {
            assembly.warn(format!("{error}: no materials from it"));
            return Ok(());
        }
    };
    complaints.warn(assembly);
    if let Some(key) = &library.odd_case {
        assembly.warn(format!("{}: keys differ in the case of letters: {key}", file.display()));
    }
    if !library.without_effect.is_empty() {
        let times = |(key, count): (&String, &usize)| match count {
            1 => key.clone(),
            count => format!("{key} ({count} times)"),
        };
        let keys: Vec<String> = library.without_effect.iter().map(times).collect();
        assembly.warn(format!("{}: without effect here: {}", file.display(), keys.join(", ")));
    }
    found.add(file, library);
    Ok(())
}
