//! Memory that may be lacking, and locks.

use super::layers;
use super::settings::{Layer, Settings};
use crate::error::Error;
use pmcip_core::sampler::estimate::Estimator;
use std::sync::{Mutex, MutexGuard, PoisonError};
use sysinfo::{MemoryRefreshKind, RefreshKind, System};

/// Memory, or an error instead of an abort: a film can be larger than the machine.
pub(crate) fn zeros<T: Clone + Default>(length: usize) -> Result<Vec<T>, Error> {
    let mut memory = Vec::new();
    memory.try_reserve_exact(length).map_err(|_| Error::Work("not enough memory for the film".into()))?;
    memory.resize(length, T::default());
    Ok(memory)
}

/// Bytes that a frame takes at most at once, without the scene and the files' buffers.
fn needed(settings: &Settings) -> u64 {
    /// The film, a frame's planes, what one more of them takes, and what filtering takes, a pixel.
    const FILM: u64 = 44;
    const FRAME: u64 = 24;
    const PLANE: u64 = 4;
    const FEATURES: u64 = 28;
    const FILTER: u64 = 116;
    let guided = settings.sampler.estimator == Estimator::Guided;
    let planes: usize = settings.layers.iter().map(|layer: Layer| layer.channels().len()).sum();
    let mut pixel = FILM + FRAME + PLANE * planes as u64;
    if guided || layers::need_features(settings.layers) {
        pixel += FEATURES;
    }
    if guided {
        pixel += FILTER;
    }
    settings.pixels().saturating_mul(pixel)
}

/// Bytes of memory that are free, if the system tells.
fn available() -> Option<u64> {
    let memory = RefreshKind::nothing().with_memory(MemoryRefreshKind::everything());
    let system = System::new_with_specifics(memory).ok()?;
    let free = system.available_memory().saturating_add(system.free_swap());
    let allowed = system.cgroup_limits().map_or(u64::MAX, |limits| limits.free_memory);
    Some(free.min(allowed)).filter(|bytes| *bytes > 0)
}

/// Refuses a frame for which there is not enough memory, which systems that promise more than they have would not: they
/// end the program in the middle of its work.
///
/// # Errors
/// [`Error::Work`] that says how much is needed and how much there is.
pub(crate) fn require(settings: &Settings) -> Result<(), Error> {
    let (needed, Some(available)) = (needed(settings), available()) else { return Ok(()) };
    if needed <= available {
        return Ok(());
    }
    let giga = |bytes: u64| format!("{:.1} GB", bytes as f64 / 1e9);
    let (width, height) = (settings.sampler.width, settings.sampler.height);
    Err(Error::Work(format!(
        "not enough memory: {width}×{height} pixels need {}, {} are free",
        giga(needed),
        giga(available)
    )))
}

/// A lock whose data no panic can leave half done.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
