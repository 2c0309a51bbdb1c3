//! What can be wrong with a scene on disk.

use super::source;
use std::path::{Path, PathBuf};

/// Bad input: one line that names the file and, where known, the line in it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read.
    #[error("{path}: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// A line of a file is wrong.
    #[error("{path}:{line}: {message}")]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// What is wrong and what was expected.
        message: String,
    },
    /// A file as a whole is wrong.
    #[error("{path}: {message}")]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong and what was expected.
        message: String,
    },
}

impl Error {
    pub(super) fn at(path: &Path, line: usize, message: impl Into<String>) -> Error {
        Error::Line { path: path.to_owned(), line, message: message.into() }
    }

    pub(super) fn in_file(path: &Path, message: impl Into<String>) -> Error {
        Error::File { path: path.to_owned(), message: message.into() }
    }
}

/// The text of a file, in whatever way that is written.
///
/// # Errors
/// If it cannot be read, or is something else than text: what it seems to be.
pub(super) fn read(path: &Path) -> Result<String, Error> {
    match source::bytes(path) {
        Ok(bytes) => match source::other_kind(&bytes) {
            Some(kind) => Err(Error::in_file(path, format!("it seems to be {kind}"))),
            None => Ok(source::decode(bytes)),
        },
        Err(source) => Err(Error::Read { path: path.to_owned(), source }),
    }
}
