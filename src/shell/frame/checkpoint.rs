//! A frame's film on disk: what a run that ends too early can go on from, and what films rendered apart are merged from.
//!
//! The file's first line is JSON: the attributes that the finished frame will have, by which it is known again. The rest is the
//! film, as [`Saved`](pmcip_core::sampler::saved::Saved) reads it; 44 bytes a pixel. It appears whole or not at all, as all files.

use super::attributes::difference;
use super::memory::zeros;
use crate::error::Error;
use crate::picture::output;
use pmcip_core::sampler::Sampler;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read, Write};
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
    written: bool,
}

impl<'a> Keeper<'a> {
    /// A keeper of the frame with these attributes, which removes what killed runs have left of its file; it writes after an
    /// iteration if `every` so many seconds have passed since it wrote last, and when the frame is interrupted.
    pub fn new(exr: &Path, attributes: &'a BTreeMap<String, String>, every: Option<f32>) -> Self {
        let every = every.map(|seconds| Duration::try_from_secs_f32(seconds).unwrap_or(Duration::MAX));
        let path = path(exr);
        output::sweep(&path);
        Keeper { path, attributes, every, last: Instant::now(), written: false }
    }

    /// Is shown the film after every iteration, and in the middle of one if it is interrupted, as
    /// [`render_while`](super::render::render_while) shows it.
    ///
    /// # Errors
    /// [`Error::Write`], and [`Error::Work`] if memory is lacking.
    pub fn look(&mut self, film: &Sampler<'_>) -> Result<(), Error> {
        let is_due = self.every.is_some_and(|every| self.last.elapsed() >= every);
        if !film.is_running() && !is_due {
            return Ok(());
        }
        write(&self.path, self.attributes, &bytes(film)?)?;
        (self.last, self.written) = (Instant::now(), true);
        Ok(())
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether it has written that.
    pub fn has_written(&self) -> bool {
        self.written
    }
}

/// A film as bytes.
///
/// # Errors
/// [`Error::Work`] if memory is lacking.
pub fn bytes(film: &Sampler<'_>) -> Result<Vec<u8>, Error> {
    let mut bytes = zeros(film.saved_len())?;
    film.save(&mut bytes).map_err(Error::work)?;
    Ok(bytes)
}

/// Writes a film file.
///
/// # Errors
/// [`Error::Write`].
pub fn write(path: &Path, attributes: &BTreeMap<String, String>, film: &[u8]) -> Result<(), Error> {
    // Plain data with string keys: it cannot fail to become JSON.
    let line = serde_json::to_string(attributes).unwrap_or_default();
    output::write(path, |file| {
        writeln!(file, "{line}")?;
        file.write_all(film)
    })
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
    if !path.exists() {
        return Ok(None);
    }
    let (found, film) = open(path)?;
    match difference(&found, wanted) {
        None => Ok(Some(film)),
        Some(why) => {
            Err(Error::read(path, format!("it is of another frame: {why}; remove it to begin anew")))
        }
    }
}

/// Attributes of a film file, of which no more is read.
///
/// # Errors
/// [`Error::Read`] if it cannot be read or is none.
pub fn attributes(path: &Path) -> Result<BTreeMap<String, String>, Error> {
    let mut line = Vec::new();
    let read = File::open(path)
        .and_then(|file| BufReader::new(file.take(LONGEST_LINE as u64)).read_until(b'\n', &mut line));
    read.map_err(|reason| Error::read(path, output::plain(&reason)))?;
    let attributes = line.strip_suffix(b"\n").and_then(|line| serde_json::from_slice(line).ok());
    attributes.ok_or_else(|| Error::read(path, "it is no film file"))
}

/// Attributes and film of a film file.
///
/// # Errors
/// [`Error::Read`] if it cannot be read or is none.
pub fn open(path: &Path) -> Result<(BTreeMap<String, String>, Vec<u8>), Error> {
    let mut bytes = fs::read(path).map_err(|reason| Error::read(path, output::plain(&reason)))?;
    let end = bytes.iter().take(LONGEST_LINE).position(|byte| *byte == b'\n');
    let attributes = end.and_then(|end| serde_json::from_slice(&bytes[..end]).ok());
    let (Some(end), Some(attributes)) = (end, attributes) else {
        return Err(Error::read(path, "it is no film file"));
    };
    bytes.drain(..=end);
    Ok((attributes, bytes))
}
