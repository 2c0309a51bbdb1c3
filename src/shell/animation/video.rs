//! A video of numbered pictures, made by the program `ffmpeg` where it is installed.
//!
//! H.264 in 4:2:0 with the colours of Rec. 709, which every player shows; a picture of an odd width or height gets a
//! black column or row, since 4:2:0 wants even ones.

use crate::error::Error;
use crate::picture::output::Part;
use std::ffi::OsString;
use std::io::ErrorKind;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The program.
const FFMPEG: &str = "ffmpeg";

/// A video to be made.
#[derive(Clone, Debug, PartialEq)]
pub struct Video {
    /// The file, whose name ends in `.mp4`.
    pub file: PathBuf,
    /// The pictures' name without a number: `walk.png` for `walk.0001.png` and those after it.
    pub pictures: PathBuf,
    /// Numbers of the pictures; all must be there.
    pub frames: RangeInclusive<u32>,
    /// Pictures a second.
    pub fps: f32,
}

impl Video {
    /// What `ffmpeg` is told, to write into `out`.
    pub fn arguments(&self, out: &Path) -> Vec<OsString> {
        let (first, count) = (*self.frames.start(), self.frames.clone().count());
        let [fps, first, count] = [self.fps.to_string(), first.to_string(), count.to_string()];
        let filter = "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv,format=yuv420p";
        let colours = ["-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709"];
        let mut list: Vec<OsString> =
            ["-nostdin", "-y", "-loglevel", "error", "-framerate", &fps, "-start_number", &first, "-i"]
                .map(OsString::from)
                .into();
        list.push(self.pattern());
        list.extend(
            ["-frames:v", &count, "-vf", filter, "-c:v", "libx264", "-crf", "16"].map(OsString::from),
        );
        list.extend(colours.map(OsString::from));
        list.extend(["-movflags", "+faststart", "-f", "mp4"].map(OsString::from));
        list.push(out.into());
        list
    }

    /// The pictures' names as ffmpeg's image reader wants them: a percent sign of a name is doubled.
    fn pattern(&self) -> OsString {
        let stem = self.pictures.with_extension("").to_string_lossy().replace('%', "%%");
        let extension = self.pictures.extension().unwrap_or_default().to_string_lossy().replace('%', "%%");
        // A name that begins with a dash or looks like a protocol must not be taken for one.
        let here = if self.pictures.is_absolute() { "" } else { "./" };
        format!("{here}{stem}.%04d.{extension}").into()
    }

    /// Makes the video; an old one stays until the new one is complete.
    ///
    /// # Errors
    /// [`Error::Work`] if ffmpeg is missing or fails, with its last words; [`Error::Write`] if the file cannot be put
    /// in its place.
    pub fn make(&self) -> Result<(), Error> {
        let part = Part::begin(&self.file)?;
        let here = if part.path().is_absolute() { "" } else { "." };
        let out = Path::new(here).join(part.path());
        let run = Command::new(FFMPEG).args(self.arguments(&out)).stdin(Stdio::null()).output();
        let output = run.map_err(|reason| match reason.kind() {
            ErrorKind::NotFound => Error::Work(MISSING.into()),
            _ => Error::Work(format!("cannot run ffmpeg: {reason}")),
        })?;
        if !output.status.success() {
            let words = String::from_utf8_lossy(&output.stderr);
            let last = words.lines().rev().find(|line| !line.trim().is_empty()).unwrap_or("no reason given");
            return Err(Error::Work(format!("ffmpeg made no video: {}", last.trim())));
        }
        part.finish()
    }
}

/// What to say where ffmpeg is not installed.
pub const MISSING: &str = "no video: the program ffmpeg is not installed";

/// Whether ffmpeg can be run.
pub fn available() -> bool {
    let quiet = Command::new(FFMPEG).arg("-version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    quiet.is_ok_and(|status| status.success())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ffmpeg_is_told_names_numbers_and_colours() {
        let video =
            Video { file: "out.mp4".into(), pictures: "100%/walk.png".into(), frames: 5..=14, fps: 23.976 };
        let list = video.arguments(Path::new("part.mp4"));
        let words: Vec<_> = list.iter().map(|word| word.to_str().unwrap()).collect();
        let line = words.join(" ");
        for part in [
            "-framerate 23.976 -start_number 5 -i ./100%%/walk.%04d.png -frames:v 10",
            "-c:v libx264",
            "format=yuv420p",
            "pad=ceil(iw/2)*2:ceil(ih/2)*2",
            "-f mp4 part.mp4",
        ] {
            assert!(line.contains(part), "{part} is not in {line}");
        }
    }
}
