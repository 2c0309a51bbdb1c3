//! What is to be said about a file: the first of each kind, and how many there are.

use super::assemble::Assembly;
use std::path::Path;

/// What is to be said about a file.
#[derive(Debug, Default)]
pub(super) struct Notes(Vec<(&'static str, String, usize)>);

impl Notes {
    /// Adds one of a kind, of which only the first says anything.
    pub fn add(&mut self, kind: &'static str, message: impl FnOnce() -> String) {
        match self.0.iter_mut().find(|note| note.0 == kind) {
            Some(note) => note.2 += 1,
            None => self.0.push((kind, message(), 1)),
        }
    }

    /// Passes all on as warnings, one line a kind; `what` there are many of.
    pub fn warn(self, file: &Path, what: &str, assembly: &mut Assembly) {
        for (_, message, count) in self.0 {
            let more = if count > 1 { format!(" ({count} {what})") } else { String::new() };
            assembly.warn(format!("{}: {message}{more}", file.display()));
        }
    }
}
