//! Frames of an animation on disk: their numbers, their names, and which of them are there already.
//!
//! Frame 7 of `walk.exr` is `walk.0007.exr`, with `walk.0007.png` beside it. A frame that is on disk with the same
//! settings, of the same scene, is complete: since files appear whole or not at all, and rendering again would give
//! the same bits, an interrupted sequence goes on where it stopped. A frame made otherwise is never overwritten
//! unasked; one that cannot be read is rendered again.

use crate::error::Error;
use crate::frame::attributes::difference;
use crate::picture::frame_io;
use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Frames that a list may have: more are a mistake.
pub const MOST: u64 = 1_000_000;

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
        let count = u64::from(last - first) + 1;
        if count > MOST {
            return Err(format!(
                "frames {self}: {count} frames are more than the {MOST} that one run may have"
            ));
        }
        Ok(first..=last)
    }
}

impl FromStr for Range {
    type Err = String;

    fn from_str(text: &str) -> Result<Range, String> {
        let wanted = || "expected A..B or A-B, both included, A.., ..B, .. or one number".to_owned();
        let number = |text: &str| match text {
            "" => Ok(None),
            digits => digits.parse().map(Some).map_err(|_| wanted()),
        };
        let text = text.trim();
        let (first, last) = match (text.split_once(".."), text.split_once('-')) {
            (Some((first, last)), _) => (number(first)?, number(last)?),
            (None, Some((first, last))) if !first.is_empty() && !last.is_empty() => {
                (number(first)?, number(last)?)
            }
            _ => (number(text)?, number(text)?),
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

/// Ranges of frames and single ones: `2,4,10-20,25` or `1..8`.
///
/// ```
/// use pmcip::animation::sequence::{self, List};
///
/// let list: List = "4,10-12,2,11".parse()?;
/// assert_eq!(list.within(None), Ok(vec![2, 4, 10, 11, 12]));
/// assert_eq!(sequence::compact(&[2, 4, 10, 11, 12]), "2,4,10-12");
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct List(Vec<Range>);

impl List {
    /// The numbers in order, each once, with open ends from the first and last frame that a scene names.
    ///
    /// # Errors
    /// As [`Range::within`], and if there are more than [`MOST`].
    pub fn within(&self, scene: Option<(u32, u32)>) -> Result<Vec<u32>, String> {
        let ranges = self.0.iter().map(|range| range.within(scene)).collect::<Result<Vec<_>, _>>()?;
        let count: u64 = ranges.iter().map(|range| u64::from(range.end() - range.start()) + 1).sum();
        if count > MOST {
            return Err(format!("--frames: {count} frames are more than the {MOST} that one run may have"));
        }
        let mut numbers: Vec<u32> = ranges.into_iter().flatten().collect();
        numbers.sort_unstable();
        numbers.dedup();
        Ok(numbers)
    }
}

impl FromStr for List {
    type Err = String;

    fn from_str(text: &str) -> Result<List, String> {
        text.split(',').map(str::parse).collect::<Result<_, _>>().map(List)
    }
}

/// Numbers in order as a list that [`List`] reads, without open ends.
pub fn compact(numbers: &[u32]) -> String {
    let runs = numbers.chunk_by(|a, b| a.checked_add(1) == Some(*b));
    let words = runs.map(|run| match run {
        [first, .., last] => format!("{first}-{last}"),
        run => run.iter().map(u32::to_string).collect(),
    });
    words.collect::<Vec<_>>().join(",")
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
    /// There, but not to be read: why.
    Damaged(String),
}

/// Looks at the frame on disk that shall be made with `wanted` attributes.
pub fn state(file: &Path, wanted: &BTreeMap<String, String>) -> State {
    if !file.exists() {
        return State::Missing;
    }
    let found = match frame_io::read_attributes(file) {
        Ok(found) => found,
        Err(error) if begins_as_exr(file) => return State::Damaged(reason(&error)),
        Err(error) => return State::Other(reason(&error)),
    };
    difference(&found, wanted).map_or(State::Complete, State::Other)
}

/// Whether a file was an EXR file, as far as it goes: any other is somebody's own.
fn begins_as_exr(file: &Path) -> bool {
    const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
    let mut start = Vec::new();
    let read = File::open(file).and_then(|file| file.take(MAGIC.len() as u64).read_to_end(&mut start));
    read.is_ok() && MAGIC.starts_with(&start)
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
        assert_eq!(within("1-5", None), Ok(1..=5));
        assert!(within("1..4000000000", None).unwrap_err().contains("4000000000 frames"));
        for text in ["", "a", "1..b", "4..2", "-1..2", "1-", "-5", "1...5"] {
            assert!(text.parse::<Range>().is_err(), "{text}");
        }
    }

    #[test]
    fn lists_are_sorted_and_written_as_they_are_read() {
        let within = |text: &str| text.parse::<List>().unwrap().within(Some((1, 9)));
        assert_eq!(within("2,4,10-12,25"), Ok(vec![2, 4, 10, 11, 12, 25]));
        assert_eq!(within("8.., 3,3,2..4"), Ok(vec![2, 3, 4, 8, 9]));
        assert!(within("0..999999,2000000..2000001").unwrap_err().contains("1000002 frames"));
        assert!(["1,,2", "1,", "1,b", ""].iter().all(|text| text.parse::<List>().is_err()));
        for numbers in [vec![], vec![7], vec![1, 2], vec![1, 3, 4, 5, 9, u32::MAX]] {
            let text = compact(&numbers);
            assert!(numbers.is_empty() || within(&text) == Ok(numbers), "{text}");
        }
    }

    #[test]
    fn names_carry_the_number() {
        assert_eq!(path(Path::new("a/b.exr"), 7), Path::new("a/b.0007.exr"));
        assert_eq!(path(Path::new("b.c.exr"), 12345), Path::new("b.c.12345.exr"));
    }
}
