//! A report goes to disk, or onto a terminal.

use super::report::{FILES, Report};
use super::{page, table};
use crate::error::Error;
use crate::picture::output;
use std::fmt::{self, Display, Formatter};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Name of the file with the curves over frames.
const FRAMES_FILE: &str = "frames.csv";

impl Report<'_> {
    /// Writes the files into `folder` and names them.
    ///
    /// # Errors
    /// [`Error::Write`]; [`Error::Work`] if a plot cannot be drawn.
    pub fn write(&self, folder: &Path) -> Result<Vec<PathBuf>, Error> {
        // Plain data with string keys: it cannot fail to become JSON.
        let json = serde_json::to_string_pretty(self).unwrap_or_default() + "\n";
        let page = page::html(self, self.comparison, self.cd_per_unit)?;
        let mut files: Vec<_> = FILES.into_iter().zip([json, table::csv(self.rows), page]).collect();
        if !self.frames.is_empty() {
            files.push((FRAMES_FILE, table::frames_csv(self.frames)));
        }
        let write = |(name, text): (&str, String)| {
            let path = folder.join(name);
            output::write(&path, |file| file.write_all(text.as_bytes())).map(|()| path)
        };
        files.into_iter().map(write).collect()
    }
}

impl Display for Report<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(&table::ratios(self))
    }
}
