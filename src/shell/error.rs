//! What can go wrong in the shell outside of loading a scene: one line each, with path and reason.

use std::path::{Path, PathBuf};

/// A failure of the shell.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An input file cannot be read or is not what it should be.
    #[error("cannot read {}: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// An output file cannot be written.
    #[error("cannot write {}: {reason}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// Two images that should have the same size have not.
    #[error("the image has {}×{} pixels, the reference {}×{}", image.0, image.1, reference.0, reference.1)]
    Sizes {
        /// Width and height of the image.
        image: (u32, u32),
        /// Width and height of the reference.
        reference: (u32, u32),
    },
    /// Pixels that are infinite or not a number make every mean meaningless.
    #[error("the {which} has {count} pixels that are not finite")]
    NotFinite {
        /// "image" or "reference".
        which: &'static str,
        /// How many.
        count: usize,
    },
    /// A setting of the render is out of range.
    #[error("{0}")]
    Setting(String),
    /// The work itself failed.
    #[error("{0}")]
    Work(String),
    /// Somebody has asked for the work to end.
    #[error("interrupted")]
    Interrupted,
}

impl Error {
    /// A failed read of `path`.
    pub fn read(path: &Path, reason: impl ToString) -> Self {
        Error::Read { path: path.into(), reason: reason.to_string() }
    }

    /// A setting that the core refuses.
    pub(crate) fn setting(reason: impl ToString) -> Self {
        Error::Setting(reason.to_string())
    }

    /// Work that the core refuses, such as planes that do not fit together.
    pub(crate) fn work(reason: impl ToString) -> Self {
        Error::Work(reason.to_string())
    }

    /// A failed write of `path`.
    pub fn write(path: &Path, reason: impl ToString) -> Self {
        Error::Write { path: path.into(), reason: reason.to_string() }
    }
}
