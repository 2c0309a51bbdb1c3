//! What is wrong with the lines of a file: the first of each kind, and how many there are.

use crate::scene::assemble::Assembly;
use crate::scene::error::Error;
use std::path::Path;

/// Lines that cannot be meant as they stand.
#[derive(Debug)]
pub(super) struct Complaints<'a> {
    file: &'a Path,
    strict: bool,
    kinds: Vec<Kind>,
}

#[derive(Debug)]
struct Kind {
    /// What becomes of such lines.
    outcome: &'static str,
    line: usize,
    message: String,
    count: usize,
}

impl<'a> Complaints<'a> {
    /// None so far; with `strict` the first is an error.
    pub fn new(file: &'a Path, strict: bool) -> Self {
        Complaints { file, strict, kinds: Vec::new() }
    }

    /// Notes a line, and what becomes of it, by which kinds are told apart.
    ///
    /// # Errors
    /// The complaint itself where files are taken strictly.
    pub fn note(
        &mut self,
        line: usize,
        outcome: &'static str,
        message: impl FnOnce() -> String,
    ) -> Result<(), Error> {
        if self.strict {
            return Err(Error::at(self.file, line, message()));
        }
        match self.kinds.iter_mut().find(|kind| kind.outcome == outcome) {
            Some(kind) => kind.count += 1,
            None => self.kinds.push(Kind { outcome, line, message: message(), count: 1 }),
        }
        Ok(())
    }

    /// The first, as an error.
    pub fn first(&self) -> Option<Error> {
        self.kinds.first().map(|kind| Error::at(self.file, kind.line, kind.message.clone()))
    }

    /// Passes all on as warnings, one line a kind.
    pub fn warn(self, assembly: &mut Assembly) {
        for Kind { outcome, line, message, count } in self.kinds {
            let like_it = if count > 1 { format!(" ({count} of them)") } else { String::new() };
            assembly.warn(format!("{}:{line}: {message}: {outcome}{like_it}", self.file.display()));
        }
    }
}
