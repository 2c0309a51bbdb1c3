//! Output files that are either complete or not there.
//!
//! A file is written under a temporary name in the folder where it shall live and renamed at the end, so that
//! neither a full disk nor an interrupt leaves half a picture under the final name.
//!
//! What a killed run has left under such a name is removed by the next run that writes the same file, but never the file
//! of a run that is alive, on whatever machine: `.NAME.HOST.PROCESS.NUMBER.part` is locked as long as somebody writes it, and
//! the system takes the lock from who is killed. A part without a lock is removed if it is of this machine, or if nobody has
//! written to it for an hour: folders are shared by machines between which locks may not hold (tried on local file systems alone:
//! NFS was not at hand). Where there are no locks at all, parts stay.

use crate::error::Error;
use std::fs::{self, DirEntry, File};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

/// Time after which a part of another machine is taken for what a killed run has left, if it is not locked.
const LONG: Duration = Duration::from_secs(3600);

/// What parts of this machine have in their names; none if it has no name.
static HOST: LazyLock<Option<String>> = LazyLock::new(|| {
    let mut hasher = DefaultHasher::new();
    sysinfo::System::host_name().ok()?.hash(&mut hasher);
    Some(format!("{:08x}", hasher.finish() as u32))
});

/// Writes the file `path` through `fill`.
///
/// # Errors
/// [`Error::Write`] if the file cannot be made, filled or renamed; nothing of it is left then.
pub fn write(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> Result<(), Error> {
    let mut part = Part::begin(path)?;
    let filled = fill(&mut part.file).and_then(|()| part.file.sync_all());
    filled.map_err(|reason| Error::write(path, plain(&reason)))?;
    part.finish()
}

/// Checks that `path` can be written, before hours of work depend on it.
///
/// # Errors
/// [`Error::Write`] if `path` is a folder or no file can be made beside it.
pub fn check(path: &Path) -> Result<(), Error> {
    let _part = Part::begin(path)?;
    match path.is_dir() {
        true => Err(Error::write(path, "it is a folder")),
        false => Ok(()),
    }
}

/// Removes what killed runs have left of the file `path`.
pub fn sweep(path: &Path) {
    let Some(prefix) = prefix(path) else { return };
    let Ok(entries) = fs::read_dir(folder(path)) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let rest = name.strip_prefix(&prefix).filter(|rest| rest.ends_with(".part"));
        let is_ours = |rest: &str| HOST.as_ref().is_some_and(|host| rest.split('.').next() == Some(host));
        if rest.is_some_and(|rest| is_ours(rest) || is_old(&entry)) {
            remove_unlocked(&entry.path());
        }
    }
}

fn is_old(entry: &DirEntry) -> bool {
    let written = entry.metadata().and_then(|metadata| metadata.modified());
    written.is_ok_and(|written| written.elapsed().is_ok_and(|age| age >= LONG))
}

/// Removes a part that nobody has locked.
fn remove_unlocked(part: &Path) {
    // Some systems lock only what is open for writing. Whatever fails, the file stays, which does no harm.
    if let Ok(file) = File::options().write(true).open(part)
        && file.try_lock().is_ok()
    {
        let _ = fs::remove_file(part);
    }
}

/// What the names of all parts of a file begin with.
fn prefix(path: &Path) -> Option<String> {
    Some(format!(".{}.", path.file_name()?.to_string_lossy()))
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// A file on its way, under a temporary name beside its final one. Unless it is [finished](Part::finish) it is removed.
#[derive(Debug)]
pub struct Part<'a> {
    /// Locked, so that nobody takes it for what a killed run has left.
    file: File,
    part: PathBuf,
    path: &'a Path,
}

impl<'a> Part<'a> {
    /// An empty file that shall become `path`. What killed runs have left of that is removed.
    ///
    /// # Errors
    /// [`Error::Write`] if it cannot be made.
    pub fn begin(path: &'a Path) -> Result<Part<'a>, Error> {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let prefix = prefix(path).ok_or_else(|| Error::write(path, "it is not a file name"))?;
        sweep(path);
        let (host, process) = (HOST.as_deref().unwrap_or("-"), std::process::id());
        loop {
            let number = NUMBER.fetch_add(1, Ordering::Relaxed);
            let part = path.with_file_name(format!("{prefix}{host}.{process}.{number}.part"));
            let file = match File::create_new(&part) {
                // Of a process of the same number, in another container.
                Err(reason) if reason.kind() == io::ErrorKind::AlreadyExists => continue,
                made => made.map_err(|reason| Error::write(path, plain(&reason)))?,
            };
            // There are file systems without locks: parts stay there.
            let is_locked = file.lock().is_ok();
            // Somebody may have swept it away between the two.
            if !is_locked || part.exists() {
                return Ok(Part { file, part, path });
            }
        }
    }

    /// Where it is now.
    pub fn path(&self) -> &Path {
        &self.part
    }

    /// Gives the file its final name.
    ///
    /// # Errors
    /// [`Error::Write`] if it cannot be renamed; it is removed then.
    pub fn finish(self) -> Result<(), Error> {
        fs::rename(&self.part, self.path).map_err(|reason| Error::write(self.path, plain(&reason)))
    }
}

impl Drop for Part<'_> {
    fn drop(&mut self) {
        // Where it has its final name there is nothing to remove.
        let _ = fs::remove_file(&self.part);
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::SystemTime;

    fn parts(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
        let mut names: Vec<String> = entries.map(|name| name.into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn what_the_dead_have_left_is_removed_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let host = HOST.clone().unwrap();
        let make = |name: &str| File::create_new(folder.path().join(name)).unwrap();
        make(&format!(".a.exr.{host}.1.0.part"));
        make(".a.exr.elsewhere.1.0.part");
        let ages_ago = SystemTime::now() - 2 * LONG;
        make(".a.exr.elsewhere.2.0.part").set_modified(ages_ago).unwrap();
        let slow = make(".a.exr.elsewhere.3.0.part");
        slow.set_modified(ages_ago).unwrap();
        slow.lock().unwrap();
        for other in [".b.exr.elsewhere.2.0.part", ".a.exr.elsewhere.2.0", "a.exr.part"] {
            make(other).set_modified(ages_ago).unwrap();
        }
        let alive = Part::begin(&path).unwrap();
        write(&path, |_| Ok(())).unwrap();
        assert!(alive.path().exists());
        let mut left =
            [".a.exr.elsewhere.1.0.part", ".a.exr.elsewhere.3.0.part", ".b.exr.elsewhere.2.0.part"].to_vec();
        left.extend([".a.exr.elsewhere.2.0", "a.exr.part", "a.exr"]);
        left.sort();
        alive.finish().unwrap();
        assert_eq!(parts(folder.path()), left);
    }

    #[test]
    fn two_who_write_the_same_file_leave_one_of_both() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        std::thread::scope(|scope| {
            for text in [[b'a'; 999], [b'b'; 999]] {
                let path = &path;
                scope.spawn(move || {
                    for _ in 0..50 {
                        write(path, |file| io::Write::write_all(file, &text)).unwrap();
                    }
                });
            }
        });
        let text = fs::read(&path).unwrap();
        assert!(text.len() == 999 && text.iter().all(|byte| *byte == text[0]));
        assert_eq!(parts(folder.path()), ["a.exr"]);
    }
}
