//! From C's pointers to Rust's references, and back.

use crate::PmcipStatus;
use core::ffi::c_void;
use core::mem::{align_of, size_of};
use core::slice;
use pmcip_core::sampler::state::State;
use pmcip_core::sampler::{self, Memory, Required, Sampler};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// A film in memory that the caller lends.
pub struct Film {
    /// [`MAGIC`], so that what is no film is noticed, as a rule.
    magic: u64,
    state: State,
    required: Required,
    floats: *mut f32,
    words: *mut u32,
}

const MAGIC: u64 = 0x706d_6369_7020_6669;
/// Alignment of everything that is put into lent memory: a cache line.
const ALIGNMENT: usize = 64;

/// Runs what a call does. Nothing unwinds into C.
pub(crate) fn run(work: impl FnOnce() -> Result<(), PmcipStatus>) -> PmcipStatus {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(())) => PmcipStatus::Ok,
        Ok(Err(status)) => status,
        Err(_) => PmcipStatus::Fault,
    }
}

/// What C points to, to be read.
///
/// # Safety
/// `from` is NULL or points to `length` entries that nobody changes meanwhile.
pub(crate) unsafe fn lent<'a, T>(from: *const T, length: usize) -> Result<&'a [T], PmcipStatus> {
    if length == 0 {
        return Ok(&[]);
    }
    if from.is_null() || !from.is_aligned() {
        return Err(PmcipStatus::Pointer);
    }
    // SAFETY: not NULL, aligned, and as long as the caller says.
    Ok(unsafe { slice::from_raw_parts(from, length) })
}

/// What C points to, to be written.
///
/// # Safety
/// `to` is NULL or points to `length` entries that nobody else uses meanwhile.
pub(crate) unsafe fn lent_mut<'a, T>(to: *mut T, length: usize) -> Result<&'a mut [T], PmcipStatus> {
    if length == 0 {
        return Ok(&mut []);
    }
    if to.is_null() || !to.is_aligned() {
        return Err(PmcipStatus::Pointer);
    }
    // SAFETY: not NULL, aligned, and as long as the caller says.
    Ok(unsafe { slice::from_raw_parts_mut(to, length) })
}

/// One thing that C points to.
///
/// # Safety
/// `to` is NULL or points to a `T` that nobody else uses meanwhile.
pub(crate) unsafe fn place<'a, T>(to: *mut T) -> Result<&'a mut T, PmcipStatus> {
    if !to.is_aligned() {
        return Err(PmcipStatus::Pointer);
    }
    // SAFETY: aligned; the caller's promise.
    unsafe { to.as_mut() }.ok_or(PmcipStatus::Pointer)
}

/// Bytes from which an aligned `T` can be cut, wherever they begin.
pub(crate) fn size_of_one<T>() -> usize {
    const { assert!(align_of::<T>() <= ALIGNMENT) };
    size_of::<T>() + ALIGNMENT
}

/// Puts a value into lent memory and says where it is.
///
/// # Safety
/// `memory` is NULL or points to `size` bytes, `made` is NULL or points to a pointer.
pub(crate) unsafe fn put<T>(
    memory: *mut c_void,
    size: usize,
    value: T,
    made: *mut *mut T,
) -> Result<(), PmcipStatus> {
    // SAFETY: the caller's promise.
    let made = unsafe { place(made) }?;
    if memory.is_null() {
        return Err(PmcipStatus::Pointer);
    }
    if size < size_of_one::<T>() {
        return Err(PmcipStatus::Memory);
    }
    let offset = memory.align_offset(ALIGNMENT);
    // SAFETY: the offset is below ALIGNMENT, and there is room for that and a `T`.
    let to = unsafe { memory.byte_add(offset) }.cast::<T>();
    // SAFETY: aligned, and within the lent bytes.
    unsafe { to.write(value) };
    *made = to;
    Ok(())
}

/// Bytes of memory that a film takes.
pub(crate) fn film_size(width: u32, height: u32, labelled: bool) -> usize {
    let Required { floats, words } = required(width, height, labelled);
    floats.saturating_add(words).saturating_mul(4).saturating_add(size_of_one::<Film>())
}

fn required(width: u32, height: u32, labelled: bool) -> Required {
    match labelled {
        true => Sampler::required_with_labels(width, height),
        false => Sampler::required(width, height),
    }
}

/// Makes a film in lent memory: its head, then floats, then words.
///
/// # Safety
/// `memory` is NULL or points to `size` bytes that belong to the film from now on, `made` is NULL or points to a pointer.
pub(crate) unsafe fn create(
    memory: *mut c_void,
    size: usize,
    (width, height, labelled): (u32, u32, bool),
    make: impl FnOnce(Memory<'static>) -> Result<Sampler<'static>, sampler::Error>,
    made: *mut *mut Film,
) -> Result<(), PmcipStatus> {
    if memory.is_null() || made.is_null() {
        return Err(PmcipStatus::Pointer);
    }
    if size < film_size(width, height, labelled) {
        return Err(PmcipStatus::Memory);
    }
    let required = required(width, height, labelled);
    let offset = memory.align_offset(ALIGNMENT) + size_of::<Film>();
    // SAFETY: head, floats and words fit into what `film_size` says; both are aligned to four bytes, as the head's size is.
    let (floats, words) = unsafe {
        let floats = memory.byte_add(offset).cast::<f32>();
        (floats, floats.add(required.floats).cast::<u32>())
    };
    // SAFETY: within the lent bytes; afterwards they are initialised.
    unsafe {
        floats.write_bytes(0, required.floats);
        words.write_bytes(0, required.words);
    }
    // SAFETY: the caller has lent them to the film alone.
    let lent = unsafe {
        Memory {
            floats: slice::from_raw_parts_mut(floats, required.floats),
            words: slice::from_raw_parts_mut(words, required.words),
        }
    };
    let state = make(lent)?.state();
    // SAFETY: the caller's promise.
    unsafe { put(memory, size, Film { magic: MAGIC, state, required, floats, words }, made) }
}

/// The sampler of a film.
///
/// # Safety
/// `film` is NULL or a film, of which nobody else makes use while the sampler lives.
pub(crate) unsafe fn take(film: *mut Film) -> Result<Sampler<'static>, PmcipStatus> {
    // SAFETY: the caller's promise.
    let film = unsafe { place(film) }?;
    if film.magic != MAGIC {
        return Err(PmcipStatus::Pointer);
    }
    // SAFETY: `create` has made both of memory that was lent to the film alone.
    let memory = unsafe {
        Memory {
            floats: slice::from_raw_parts_mut(film.floats, film.required.floats),
            words: slice::from_raw_parts_mut(film.words, film.required.words),
        }
    };
    Ok(Sampler::resume(film.state, memory)?)
}

/// Does something with the sampler of a film.
///
/// # Safety
/// As [`take`].
pub(crate) unsafe fn film<T>(
    film: *mut Film,
    work: impl FnOnce(&mut Sampler<'static>) -> Result<T, PmcipStatus>,
) -> Result<T, PmcipStatus> {
    // SAFETY: the caller's promise.
    let mut sampler = unsafe { take(film) }?;
    let done = work(&mut sampler);
    // SAFETY: `take` has checked it.
    unsafe { (*film).state = sampler.state() };
    done
}
