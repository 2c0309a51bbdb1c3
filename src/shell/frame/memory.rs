//! Memory that may be lacking, and locks.

use crate::error::Error;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Memory, or an error instead of an abort: a film can be larger than the machine.
pub(crate) fn zeros<T: Clone + Default>(length: usize) -> Result<Vec<T>, Error> {
    let mut memory = Vec::new();
    memory.try_reserve_exact(length).map_err(|_| Error::Work("not enough memory for the film".into()))?;
    memory.resize(length, T::default());
    Ok(memory)
}

/// A lock whose data no panic can leave half done.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
