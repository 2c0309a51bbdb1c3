//! Pictures of other programs, measured beside the methods.

use super::variant::Variant;
use crate::error::Error;
use crate::frame::settings::Settings;
use crate::picture::frame_io::{self, Picture};
use serde::Serialize;
use std::path::PathBuf;
use std::str::FromStr;

/// A picture that is there, and the time it took.
///
/// ```
/// use pmcip::compare::Other;
///
/// let other: Other = "peer=pictures/a:b.exr:1.5".parse()?;
/// assert_eq!((other.name.as_str(), other.file.to_str(), other.seconds), ("peer", Some("pictures/a:b.exr"), 1.5));
/// assert!("pmc=a.exr:1".parse::<Other>().is_err());
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Other {
    /// What made it; several pictures may have one name.
    pub name: String,
    /// The picture.
    pub file: PathBuf,
    /// Wall time that making it took, above 0.
    pub seconds: f64,
}

impl FromStr for Other {
    type Err = String;

    fn from_str(text: &str) -> Result<Other, String> {
        let wanted = || "expected NAME=PICTURE.exr:SECONDS".to_owned();
        let (name, rest) = text.split_once('=').ok_or_else(wanted)?;
        let (file, seconds) = rest.rsplit_once(':').ok_or_else(wanted)?;
        let seconds = seconds.parse().ok().filter(|seconds: &f64| *seconds > 0.0 && seconds.is_finite());
        let seconds = seconds.ok_or_else(|| format!("{}, SECONDS above 0", wanted()))?;
        if name.is_empty() || name.contains([',', '"']) || name.contains(char::is_control) || file.is_empty()
        {
            return Err(format!("{}, NAME without commas and quotes", wanted()));
        }
        if name.parse::<Variant>().is_ok() {
            return Err(format!("'{name}' is the name of a method: pick another one"));
        }
        Ok(Other { name: name.into(), file: file.into(), seconds })
    }
}

impl Other {
    /// Reads the picture.
    ///
    /// # Errors
    /// [`Error::Read`] that names the file if it cannot be read, has another size than `settings` ask for, or pixels that are
    /// not finite.
    pub fn read(&self, settings: &Settings) -> Result<Picture, Error> {
        let picture = frame_io::read_exr(&self.file)?;
        let (size, wanted) =
            ((picture.width, picture.height), (settings.sampler.width, settings.sampler.height));
        if size != wanted {
            let reason = format!("it has {}×{} pixels, not {}×{}", size.0, size.1, wanted.0, wanted.1);
            return Err(Error::read(&self.file, reason));
        }
        match picture.broken_pixels() {
            0 => Ok(picture),
            count => Err(Error::read(&self.file, format!("it has {count} pixels that are not finite"))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_picture_with_its_time_is_refused() {
        for (text, words) in [
            ("", "NAME=PICTURE.exr:SECONDS"),
            ("peer", "NAME=PICTURE.exr:SECONDS"),
            ("peer=a.exr", "NAME=PICTURE.exr:SECONDS"),
            ("peer=a.exr:", "SECONDS above 0"),
            ("peer=a.exr:0", "SECONDS above 0"),
            ("peer=a.exr:inf", "SECONDS above 0"),
            ("peer=a.exr:NaN", "SECONDS above 0"),
            ("=a.exr:1", "NAME without"),
            ("a,b=a.exr:1", "NAME without"),
            ("peer=:1", "NAME without"),
            ("uniform=a.exr:1", "the name of a method"),
            ("pmc:pooled=a.exr:1", "the name of a method"),
        ] {
            let said = text.parse::<Other>().unwrap_err();
            assert!(said.contains(words), "{text}: {said}");
        }
    }
}
