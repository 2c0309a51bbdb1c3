//! A frame that is not finished, on disk: what a run that ends too early can go on from.
//!
//! The file's first line is JSON: the attributes that the finished frame will have, by which it is known again. The rest is the
//! film, as [`Saved`](pmcip_core::sampler::saved::Saved) reads it; 44 bytes a pixel. It appears whole or not at all, as all files.

use super::memory::zeros;
use super::render::difference;
use crate::error::Error;
use crate::picture::output;
use pmcip_core::sampler::Sampler;
use std::collections::BTreeMap;
use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Most bytes of the first line.
const LONGEST_LINE: usize = 1 << 20;

/// Where the checkpoint of the frame in the file `exr` is: `name.exr` becomes `name.film`.
pub fn path(exr: &Path) -> PathBuf {
    exr.with_extension("film")
}

/// Writes the checkpoints of a frame.
#[derive(Debug)]
pub struct Keeper<'a> {
    path: PathBuf,
    attributes: &'a BTreeMap<String, String>,
    every: Option<Duration>,
    last: Instant,
}

impl<'a> Keeper<'a> {
    /// A keeper of the frame with these attributes; it writes after an iteration if `every` so many seconds have passed since
    /// it wrote last, and when the frame is interrupted.
    pub fn new(exr: &Path, attributes: &'a BTreeMap<String, String>, every: Option<f32>) -> Self {
        let every = every.map(|seconds| Duration::try_from_secs_f32(seconds).unwrap_or(Duration::MAX));
        Keeper { path: path(exr), attributes, every, last: Instant::now() }
    }

    /// Is shown the film as [`Run::go_on`](super::render::Run::go_on) is.
    ///
    /// # Errors
    /// [`Error::Write`], and [`Error::Work`] if memory is lacking.
    pub fn look(&mut self, film: &Sampler<'_>) -> Result<(), Error> {
        let is_due = self.every.is_some_and(|every| self.last.elapsed() >= every);
        if !film.is_running() && !is_due {
            return Ok(());
        }
        let mut bytes = zeros(film.saved_len())?;
        film.save(&mut bytes).map_err(Error::work)?;
        // Plain data with string keys: it cannot fail to become JSON.
        let line = serde_json::to_string(self.attributes).unwrap_or_default();
        output::write(&self.path, |file| {
            writeln!(file, "{line}")?;
            file.write_all(&bytes)
        })?;
        self.last = Instant::now();
        Ok(())
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// Removes the checkpoint of a frame that is complete.
pub fn remove(exr: &Path) {
    // There may be none, and it does no harm where it stays.
    let _ = fs::remove_file(path(exr));
}

/// The film of a frame with `wanted` attributes, as bytes, if there is a checkpoint of it.
///
/// # Errors
/// [`Error::Read`] if the checkpoint cannot be read, is none, or is of another frame.
pub fn read(path: &Path, wanted: &BTreeMap<String, String>) -> Result<Option<Vec<u8>>, Error> {
    let bytes = match fs::read(path) {
        Ok(bytes) => bytes,
        Err(reason) if reason.kind() == ErrorKind::NotFound => return Ok(None),
        Err(reason) => return Err(Error::read(path, output::plain(&reason))),
    };
    let (found, film) = split(&bytes).ok_or_else(|| Error::read(path, "it is no checkpoint"))?;
    match difference(&found, wanted) {
        None => Ok(Some(film.to_vec())),
        Some(why) => {
            Err(Error::read(path, format!("it is of another frame: {why}; remove it to begin anew")))
        }
    }
}

/// Attributes and film of a checkpoint's bytes.
fn split(bytes: &[u8]) -> Option<(BTreeMap<String, String>, &[u8])> {
    let end = bytes.iter().take(LONGEST_LINE).position(|byte| *byte == b'\n')?;
    Some((serde_json::from_slice(&bytes[..end]).ok()?, &bytes[end + 1..]))
}
