//! Finding files by names that were true on another computer: other letter case, other separators, folders that are
//! not there.

use std::path::{Path, PathBuf};

/// The file that `name` means beside the file `from`, and whether it had to be looked for; none if there is none.
pub(super) fn find(from: &Path, name: &str) -> Option<(PathBuf, bool)> {
    let folder = from.parent().unwrap_or(Path::new(""));
    let plain = name.trim().trim_matches(['"', '\'']).replace('\\', "/");
    if plain.is_empty() {
        return None;
    }
    let exact = from.with_file_name(&plain);
    if exact.is_file() {
        return Some((exact, plain != name.trim().replace('\\', "/")));
    }
    let parts: Vec<&str> =
        plain.split('/').filter(|part| !part.is_empty() && *part != "." && *part != "..").collect();
    // With as many of its folders as are there.
    let looked = (0..parts.len()).find_map(|skipped| descend(folder, &parts[skipped..]));
    looked.map(|file| (file, true))
}

/// The file at `parts` below a folder, whatever the case of their letters.
fn descend(folder: &Path, parts: &[&str]) -> Option<PathBuf> {
    let (last, folders) = parts.split_last()?;
    let mut at = folder.to_owned();
    for part in folders {
        at = entry(&at, part).filter(|path| path.is_dir())?;
    }
    entry(&at, last).filter(|path| path.is_file())
}

/// What is called `name` in a folder; of several that differ in case only, the first by name.
fn entry(folder: &Path, name: &str) -> Option<PathBuf> {
    let exact = folder.join(name);
    if exact.exists() {
        return Some(exact);
    }
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let lower = name.to_lowercase();
    let entries = std::fs::read_dir(here).ok()?.filter_map(|entry| Some(entry.ok()?.file_name()));
    let found = entries.filter(|entry| entry.to_string_lossy().to_lowercase() == lower).min()?;
    Some(folder.join(found))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_found_whatever_was_written() {
        let dir = tempfile::tempdir().unwrap();
        std::fs::create_dir(dir.path().join("Maps")).unwrap();
        for name in ["a b.png", "Maps/Wood.PNG"] {
            std::fs::write(dir.path().join(name), "").unwrap();
        }
        let from = dir.path().join("s.mtl");
        let found = |name: &str| {
            let (file, looked) = find(&from, name)?;
            Some((file.strip_prefix(dir.path()).unwrap().to_str().unwrap().replace('\\', "/"), looked))
        };
        for (name, file, looked) in [
            ("a b.png", "a b.png", false),
            ("\"a b.png\"", "a b.png", true),
            ("A B.png", "a b.png", true),
            ("C:\\Users\\me\\a b.png", "a b.png", true),
            ("/home/me/a b.png", "a b.png", true),
            ("Maps/Wood.PNG", "Maps/Wood.PNG", false),
            ("Maps\\Wood.PNG", "Maps/Wood.PNG", false),
            ("D:\\x\\maps\\wood.png", "Maps/Wood.PNG", true),
            ("..\\maps\\wood.png", "Maps/Wood.PNG", true),
        ] {
            assert_eq!(found(name), Some((file.to_owned(), looked)), "{name}");
        }
        for name in ["", "Maps", "gone.png", ".."] {
            assert_eq!(found(name), None, "{name}");
        }
    }
}
