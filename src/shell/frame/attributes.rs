//! What a frame's file says of how it was made, and whether that is what is asked for now.

use super::settings::Settings;
use crate::scene::LoadedScene;
use serde_json::Value;
use std::collections::BTreeMap;

/// Every setting of a frame by name, as its file has them, and the scene's name.
pub fn attributes(scene: &LoadedScene, settings: &Settings) -> BTreeMap<String, String> {
    let mut settings_by_name = settings.list();
    settings_by_name.insert("scene".into(), Value::String(scene.name.clone()));
    if scene.origin != [0.0; 3] {
        let world =
            |point: [f32; 3]| [0, 1, 2].map(|i| f64::from(point[i]) + scene.origin[i]).to_vec().into();
        settings_by_name.insert("look_from".into(), world(settings.view.from));
        settings_by_name.insert("look_at".into(), world(settings.view.at));
    }
    if let Some(sky) = &scene.sky {
        settings_by_name.insert("sky".into(), Value::String(sky.source.clone()));
    }
    settings_by_name.into_iter().map(|(name, value)| (name, plain(value))).collect()
}

/// Attributes that tell what became of a frame or of the one before it, not what was asked for.
const OUTCOMES: [&str; 4] = ["estimated_err", "spent_spp", "expected_spp", MERGED_SEEDS];

/// Attribute of a frame that was merged: the seeds of its parts.
pub const MERGED_SEEDS: &str = "merged_seeds";

/// What was asked for otherwise in `found` than in `wanted`, if anything was.
pub fn difference(found: &BTreeMap<String, String>, wanted: &BTreeMap<String, String>) -> Option<String> {
    let asked = |name: &&String| !OUTCOMES.contains(&name.as_str());
    let mut names: Vec<&String> = wanted.keys().chain(found.keys()).filter(asked).collect();
    // The scene's hash follows from nearly every other setting: say it last.
    names.sort_by_key(|name| (name.as_str() == "scene_hash", name.as_str()));
    let name = names.into_iter().find(|name| found.get(*name) != wanted.get(*name))?;
    if name == "scene_hash" {
        return Some("the scene or the program was another".into());
    }
    let say = |attributes: &BTreeMap<String, String>| {
        attributes.get(name).map_or("not set".into(), |value| format!("'{value}'"))
    };
    Some(format!("{name} was {}, now it is {}", say(found), say(wanted)))
}

/// A setting as the command line takes it: no quotes, no brackets.
fn plain(value: Value) -> String {
    match value {
        Value::String(text) => text,
        Value::Array(parts) => parts.into_iter().map(plain).collect::<Vec<_>>().join(","),
        other => other.to_string(),
    }
}
