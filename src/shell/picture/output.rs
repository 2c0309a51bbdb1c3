//! Output files that are either complete or not there.
//!
//! A file is written under a temporary name in the folder where it shall live and renamed at the end, so that
//! neither a full disk nor an interrupt leaves half a picture under the final name.

use crate::error::Error;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

/// Writes the file `path` through `fill`.
///
/// # Errors
/// [`Error::Write`] if the file cannot be made, filled or renamed; nothing of it is left then.
pub fn write(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> Result<(), Error> {
    let part = part_path(path)?;
    let result = File::create_new(&part).and_then(|mut file| {
        fill(&mut file)?;
        file.sync_all()?;
        fs::rename(&part, path)
    });
    result.map_err(|reason| {
        // The part may not exist; the first error is the one worth telling.
        let _ = fs::remove_file(&part);
        Error::write(path, plain(&reason))
    })
}

/// Checks that `path` can be written, before hours of work depend on it.
///
/// # Errors
/// [`Error::Write`] if `path` is a folder or no file can be made beside it.
pub fn check(path: &Path) -> Result<(), Error> {
    let part = part_path(path)?;
    if path.is_dir() {
        return Err(Error::write(path, "it is a folder"));
    }
    File::create_new(&part)
        .and_then(|_| fs::remove_file(&part))
        .map_err(|reason| Error::write(path, plain(&reason)))
}

/// The temporary name beside `path`; the process number keeps two runs apart.
fn part_path(path: &Path) -> Result<PathBuf, Error> {
    let name = path.file_name().ok_or_else(|| Error::write(path, "it is not a file name"))?;
    let part = format!(".{}.{}.part", name.to_string_lossy(), std::process::id());
    Ok(path.with_file_name(part))
}

/// An operating system's reason in plain words, without its number.
pub fn plain(reason: &io::Error) -> String {
    match reason.kind() {
        io::ErrorKind::NotFound => "no such file or folder".into(),
        io::ErrorKind::PermissionDenied => "permission denied".into(),
        io::ErrorKind::NotADirectory => "a part of the path is not a folder".into(),
        io::ErrorKind::IsADirectory => "it is a folder".into(),
        io::ErrorKind::StorageFull => "the disk is full".into(),
        _ => reason.to_string(),
    }
}
