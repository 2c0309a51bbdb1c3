//! A glTF file's bytes: JSON, and what is binary beside it; what versions and extensions it asks for.

use crate::scene::error::Error;
use crate::scene::source;
use gltf::Document;
use gltf::json::animation::Channel;
use gltf::json::validation::{Error as Invalid, Validate};
use gltf::json::{Path as Place, Root};
use serde_json::Value;
use std::path::Path;

/// Extensions that are taken into account, at least in part.
const KNOWN: [&str; 10] = [
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// Attributes that mean something by themselves; others are the application's own.
const ATTRIBUTES: [&str; 7] = ["POSITION", "NORMAL", "TANGENT", "TEXCOORD_", "COLOR_", "JOINTS_", "WEIGHTS_"];

/// A glTF file, read.
pub(super) struct Container {
    pub document: Document,
    /// The binary chunk of a `.glb`.
    pub binary: Option<Vec<u8>>,
    /// Extensions in use that nothing is known of.
    pub unknown: Vec<String>,
    /// Channels of animations that move something else than nodes.
    pub odd_channels: usize,
}

/// Reads a glTF file, whether it is text or binary.
///
/// # Errors
/// If it is something else, of another version, damaged, or needs extensions that are not known.
pub(super) fn open(path: &Path) -> Result<Container, Error> {
    let bytes = source::bytes(path).map_err(|source| Error::Read { path: path.to_owned(), source })?;
    let blame = |message: String| Error::in_file(path, message);
    if bytes.starts_with(b"glTF") {
        let (json, binary) = chunks(&bytes).map_err(blame)?;
        let text = std::str::from_utf8(json).map_err(|_| blame("its JSON is no UTF-8".into()))?;
        return parse(path, text, false)
            .map(|container| Container { binary: binary.map(<[u8]>::to_vec), ..container });
    }
    if let Some(kind) = source::other_kind(&bytes).filter(|_| !is_json(&bytes)) {
        return Err(blame(format!("it seems to be {kind}")));
    }
    parse(path, &source::decode(bytes), true)
}

/// Whether a text begins as JSON does.
fn is_json(bytes: &[u8]) -> bool {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start().starts_with(b"{")
}

/// The JSON and the binary chunk of a `.glb`.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let word = |at: usize| {
        let four = bytes.get(at..at + 4).and_then(|four| <[u8; 4]>::try_from(four).ok());
        four.map(u32::from_le_bytes).ok_or_else(|| "it ends within its header".to_owned())
    };
    let (version, length) = (word(4)?, word(8)? as usize);
    if version != 2 {
        return Err(format!("it is binary glTF of version {version}, expected 2"));
    }
    if length > bytes.len() {
        return Err(format!("it is cut off: {} of {length} bytes are there", bytes.len()));
    }
    let (mut at, mut json, mut binary) = (12, None, None);
    while at < length && (json.is_none() || binary.is_none()) {
        let (size, kind) = (word(at)? as usize, word(at + 4)?.to_le_bytes());
        let chunk = bytes.get(at + 8..).and_then(|rest| rest.get(..size));
        let chunk = chunk.ok_or_else(|| format!("a chunk of {size} bytes ends beyond the file"))?;
        match &kind {
            b"JSON" => json = json.or(Some(chunk)),
            b"BIN\0" => binary = binary.or(Some(chunk)),
            _ => {}
        }
        at += 8 + size;
    }
    json.map(|json| (json, binary)).ok_or_else(|| "it has no JSON chunk".to_owned())
}

/// Understands the JSON; only of a text file of its own do lines mean anything.
fn parse(path: &Path, text: &str, has_lines: bool) -> Result<Container, Error> {
    let blame = |message: String| Error::in_file(path, message);
    let at_line = |error: serde_json::Error| {
        let whole = error.to_string();
        // The message ends with the place, which the error says by itself.
        let message = whole.split(" at line ").next().unwrap_or(&whole).replace('\n', " ");
        match has_lines && error.line() > 0 {
            true => Error::at(path, error.line(), message),
            false => blame(format!("JSON: {message}")),
        }
    };
    let mut value: Value = serde_json::from_str(text.trim_end_matches('\0')).map_err(at_line)?;
    check_version(&value).map_err(blame)?;
    check_required(&value).map_err(blame)?;
    let unknown = names(&value, "extensionsUsed").filter(|name| !KNOWN.contains(name));
    let unknown = unknown.map(str::to_owned).collect();
    let odd_channels = drop_odd_channels(&mut value);
    drop_odd_attributes(&mut value);
    let root: Root = serde_json::from_value(value).map_err(at_line)?;
    check_indices(&root).map_err(blame)?;
    let document = Document::from_json_without_validation(root);
    Ok(Container { document, binary: None, unknown, odd_channels })
}

/// The strings of a list.
fn names<'a>(value: &'a Value, key: &str) -> impl Iterator<Item = &'a str> {
    value.get(key).and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str)
}

fn check_version(value: &Value) -> Result<(), String> {
    let asset = value.get("asset").ok_or("it has no asset: it is JSON, but no glTF")?;
    let least = asset.get("minVersion").or(asset.get("version")).and_then(Value::as_str);
    match least.ok_or("asset: expected a version")? {
        "2.0" => Ok(()),
        version if version.starts_with("2.") && asset.get("minVersion").is_none() => Ok(()),
        version => Err(format!("it is glTF of version {version}, expected 2.0")),
    }
}

fn check_required(value: &Value) -> Result<(), String> {
    let missing: Vec<&str> =
        names(value, "extensionsRequired").filter(|name| !KNOWN.contains(name)).collect();
    match missing.is_empty() {
        true => Ok(()),
        false => Err(format!("it needs extensions that are not supported: {}", missing.join(", "))),
    }
}

/// Takes away channels that move no node, which the rest cannot be read with; returns how many there were.
fn drop_odd_channels(value: &mut Value) -> usize {
    let mut dropped = 0;
    for animation in list(value.get_mut("animations")) {
        if let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) {
            let before = channels.len();
            channels.retain(|channel| {
                let target = channel.get("target");
                let path = target.and_then(|target| target.get("path")).and_then(Value::as_str);
                let known = matches!(path, Some("translation" | "rotation" | "scale" | "weights"));
                known && target.is_some_and(|target| target.get("node").is_some())
            });
            dropped += before - channels.len();
        }
    }
    dropped
}

/// Takes away attributes whose names are none of glTF's.
fn drop_odd_attributes(value: &mut Value) {
    for mesh in list(value.get_mut("meshes")) {
        for primitive in list(mesh.get_mut("primitives")) {
            if let Some(attributes) = primitive.get_mut("attributes").and_then(Value::as_object_mut) {
                attributes.retain(|name, _| {
                    let known = ATTRIBUTES.iter().find_map(|known| name.strip_prefix(known));
                    known.is_some_and(|set| set.is_empty() || set.parse::<u32>().is_ok())
                });
            }
        }
    }
}

fn list(value: Option<&mut Value>) -> impl Iterator<Item = &mut Value> {
    value.and_then(Value::as_array_mut).into_iter().flatten()
}

/// Checks what everything else relies on: that all indices lead somewhere.
fn check_indices(root: &Root) -> Result<(), String> {
    check_unchecked(root)?;
    let mut first = None;
    root.validate(root, Place::new, &mut |place, error| {
        let place = place();
        let name = place.as_str();
        // Bounds are not used, accessors without data are looked at where they are read.
        let harmless = [".min", ".max", ".bufferView"].iter().any(|end| name.ends_with(end));
        let counts = error != Invalid::Unsupported && !(error == Invalid::Missing && harmless);
        if counts && first.is_none() {
            let error = match error {
                Invalid::IndexOutOfBounds => "the index leads nowhere",
                Invalid::Missing => "something is missing",
                Invalid::Oversize => "too large a number",
                _ => "not a valid value",
            };
            first = Some(format!("{name}: {error}"));
        }
    });
    first.map_or(Ok(()), Err)
}

/// Checks indices that the crate's own check takes for granted.
fn check_unchecked(root: &Root) -> Result<(), String> {
    for (number, mesh) in root.meshes.iter().enumerate() {
        let mut attributes = mesh.primitives.iter().flat_map(|primitive| primitive.attributes.values());
        if attributes.any(|index| index.value() >= root.accessors.len()) {
            return Err(format!("meshes[{number}]: the index of an attribute leads nowhere"));
        }
    }
    for (number, animation) in root.animations.iter().enumerate() {
        let leads = |channel: &Channel| {
            channel.sampler.value() < animation.samplers.len()
                && channel.target.node.value() < root.nodes.len()
        };
        if !animation.channels.iter().all(leads) {
            return Err(format!("animations[{number}]: the index of a channel leads nowhere"));
        }
    }
    Ok(())
}
