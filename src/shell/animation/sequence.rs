//! Frames of an animation on disk: their numbers, their names, and which of them are there already.
//!
//! Frame 7 of `walk.exr` is `walk.0007.exr`, with `walk.0007.png` beside it. A frame that is on disk with the same
//! settings, of the same scene, is complete: since files appear whole or not at all, and rendering again would give
//! the same bits, an interrupted sequence goes on where it stopped. A frame made otherwise is never overwritten
//! unasked.

use crate::error::Error;
use crate::picture::frame_io;
use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Attributes that tell what became of a frame or of the one before it, not what was asked for.
const OUTCOMES: [&str; 3] = ["estimated_err", "spent_spp", "expected_spp"];

/// Numbers of frames, both ends included; an open end is that of the scene.
///
/// ```
/// use pmcip::animation::sequence::Range;
///
/// let range: Range = "3..".parse()?;
/// assert_eq!(range.within(Some((1, 100))), Ok(3..=100));
/// assert_eq!("7".parse::<Range>()?.within(None), Ok(7..=7));
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Range {
    first: Option<u32>,
    last: Option<u32>,
}

impl Range {
    /// The numbers, with open ends from the first and last frame that a scene names.
    ///
    /// # Errors
    /// If an end is open and the scene does not name it, or the last frame comes before the first.
    pub fn within(self, scene: Option<(u32, u32)>) -> Result<std::ops::RangeInclusive<u32>, String> {
        let missing = || format!("frames {self}: the scene has no [frames], so name the first and the last");
        let first = self.first.or(scene.map(|s| s.0)).ok_or_else(missing)?;
        let last = self.last.or(scene.map(|s| s.1)).ok_or_else(missing)?;
        if first > last {
            return Err(format!("frames {self}: the last, {last}, comes before the first, {first}"));
        }
        Ok(first..=last)
    }
}

impl FromStr for Range {
    type Err = String;

    fn from_str(text: &str) -> Result<Range, String> {
        let wanted = || "expected A..B, both included, A.., ..B, .. or one number".to_owned();
        let number = |text: &str| match text {
            "" => Ok(None),
            digits => digits.parse().map(Some).map_err(|_| wanted()),
        };
        let (first, last) = match text.split_once("..") {
            Some((first, last)) => (number(first)?, number(last)?),
            None => (number(text)?, number(text)?),
        };
        match (first, last) {
            (Some(first), Some(last)) if first > last => Err(format!("{last} comes before {first}")),
            (None, None) if !text.contains("..") => Err(wanted()),
            _ => Ok(Range { first, last }),
        }
    }
}

impl Display for Range {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let end = |end: Option<u32>| end.map_or(String::new(), |n| n.to_string());
        write!(f, "{}..{}", end(self.first), end(self.last))
    }
}

/// The file of a frame: `name.exr` becomes `name.0007.exr`.
pub fn path(name: &Path, frame: u32) -> PathBuf {
    let extension = name.extension().unwrap_or_default().to_string_lossy().into_owned();
    name.with_extension(format!("{frame:04}.{extension}"))
}

/// What a frame's file is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum State {
    /// Not there.
    Missing,
    /// There, and what rendering would make.
    Complete,
    /// There, but made otherwise: why.
    Other(String),
}

/// Looks at the frame on disk that shall be made with `wanted` attributes.
pub fn state(file: &Path, wanted: &BTreeMap<String, String>) -> State {
    if !file.exists() {
        return State::Missing;
    }
    let found = match frame_io::read_attributes(file) {
        Ok(found) => found,
        Err(error) => return State::Other(reason(&error)),
    };
    let asked = |name: &&String| !OUTCOMES.contains(&name.as_str());
    let mut names: Vec<&String> = wanted.keys().chain(found.keys()).filter(asked).collect();
    // The scene's hash follows from nearly every other setting: say it last.
    names.sort_by_key(|name| (name.as_str() == "scene_hash", name.as_str()));
    match names.into_iter().find(|name| found.get(*name) != wanted.get(*name)) {
        None => State::Complete,
        Some(name) if name == "scene_hash" => State::Other("the scene or the program was another".into()),
        Some(name) => {
            let say = |attributes: &BTreeMap<String, String>| {
                attributes.get(name).map_or("not set".into(), |value| format!("'{value}'"))
            };
            State::Other(format!("{name} was {}, now it is {}", say(&found), say(wanted)))
        }
    }
}

fn reason(error: &Error) -> String {
    match error {
        Error::Read { reason, .. } => reason.clone(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_include_both_ends() {
        let within = |text: &str, scene| text.parse::<Range>().unwrap().within(scene);
        assert_eq!(within("2..4", None), Ok(2..=4));
        assert_eq!(within("7", None), Ok(7..=7));
        assert_eq!(within("..", Some((1, 9))), Ok(1..=9));
        assert_eq!(within("..3", Some((1, 9))), Ok(1..=3));
        assert_eq!(within("12..13", Some((1, 9))), Ok(12..=13));
        assert!(within("12..", Some((1, 9))).unwrap_err().contains("9, comes before the first, 12"));
        assert!(within("..4", None).unwrap_err().contains("no [frames]"));
        for text in ["", "a", "1..b", "4..2", "-1..2", "1-5", "1...5"] {
            assert!(text.parse::<Range>().is_err(), "{text}");
        }
    }

    #[test]
    fn names_carry_the_number() {
        assert_eq!(path(Path::new("a/b.exr"), 7), Path::new("a/b.0007.exr"));
        assert_eq!(path(Path::new("b.c.exr"), 12345), Path::new("b.c.12345.exr"));
    }
}
