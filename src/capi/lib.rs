//! The sampler of `pmcip-core` for C and C++: `include/pmcip.h`.
//!
//! A film lives in memory the caller lends; nothing is allocated, and memory is freed by whoever lent it, when the film is
//! not used any more. No call panics across the border, unwinds or aborts: each returns a `pmcip_status`.
//!
//! Threads: calls that take the same `pmcip_film` must not overlap. Different films have nothing in common. `pmcip_job`s of
//! an iteration can be planned and delivered by different threads at once, each job by one thread at a time; until the last
//! of them has been delivered, no other call may take their film.
//!
//! The one place of this project with `unsafe`: what C promises about its pointers cannot be checked.

mod border;
mod types;

pub use border::Film;
use border::{lent, lent_mut, place, run};
use core::ffi::{c_char, c_void};
use pmcip_core::predict::{Belief, Prior};
use pmcip_core::sampler::guide::{Feature, Filter};
use pmcip_core::sampler::saved::Saved;
use pmcip_core::sampler::wave::{self, Piece, Wave};
use pmcip_core::sampler::{Job, Jobs, Memory, Sampler, Settings};
pub use types::*;

/// The jobs of an iteration, in memory the caller lends.
pub struct PmcipJobs(Jobs<'static>);

/// A job, in memory the caller lends.
pub struct PmcipJob(Job<'static>);

/// What a status means, in words: a string that is always there.
#[unsafe(no_mangle)]
pub extern "C" fn pmcip_message(status: u32) -> *const c_char {
    let text = match status {
        0 => c"done",
        1 => c"there are no more jobs",
        2 => c"a pointer is NULL or not aligned, or is no film",
        3 => c"memory is too short: ask the matching _size function",
        4 => c"a setting is out of range: sides 1 to 16384, cd_per_unit > 0, gamma 0 to 4, parts 0 to 1, radius to 4096",
        5 => c"an iteration must have 1 to 2^32 - 1 samples: use more iterations for more",
        6 => c"calls in the wrong order: begin, deliver, end; read between iterations",
        7 => c"deliver all samples of the iteration before its end",
        8 => c"the film accumulates for another estimator: set it in pmcip_settings",
        9 => c"labels must not all be 0",
        10 => c"no room for the samples of one pixel: lend longer arrays",
        11 => c"a piece is delivered once, in its iteration, with a radiance for each of its samples",
        12 => c"not a saved film of this version, or damaged",
        13 => c"a fault of the library: please report it, and do not use the film any more",
        _ => c"no such status",
    };
    text.as_ptr()
}

/// Writes the default settings of a film of this size, for a frame of `spp` samples a pixel, `pilot` of them in the first
/// iteration; 0 for both if nothing is known of what follows.
///
/// # Safety
/// `settings` is NULL or points to settings.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pmcip_settings_new(
    width: u32,
    height: u32,
    pilot: u32,
    spp: u32,
    settings: *mut PmcipSettings,
) -> PmcipStatus {
    // SAFETY: the caller's promise.
    run(|| unsafe {
        *place(settings)? = Settings::new(width, height).for_frame(pilot, spp).into();
        Ok(())
    })
}

/// Bytes of memory that a film takes, with labels if `labelled` is not 0; SIZE_MAX if there is no such film.
#[unsafe(no_mangle)]
pub extern "C" fn pmcip_film_size(width: u32, height: u32, labelled: u32) -> usize {
    border::film_size(width, height, labelled != 0)
}

/// Makes an empty film in `memory` of `size` bytes, whatever that holds, and writes where it is to `made`.
///
/// `labels` is NULL, or has an entry for every pixel, row by row from the top: to which island a pixel belongs, 0 to none.
/// They are copied.
///
/// # Safety
/// Pointers are NULL or point to as much as is said; `memory` is not used otherwise while the film is.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pmcip_film_create(
    memory: *mut c_void,
    size: usize,
    settings: *const PmcipSettings,
    labels: *const u16,
    made: *mut *mut Film,
) -> PmcipStatus {
    run(|| {
        // SAFETY: the caller's promise.
        let settings = unsafe { settings.as_ref() }.ok_or(PmcipStatus::Pointer)?.settings()?;
        let pixels = settings.width as usize * settings.height as usize;
        let labels = match labels.is_null() {
            true => None,
            // SAFETY: the caller's promise.
            false => Some(unsafe { lent(labels, pixels) }?),
        };
        let make = |memory: Memory<'static>| match labels {
            None => Sampler::new(settings, memory),
            Some(labels) => Sampler::with_labels(settings, memory, labels),
        };
        let required = (settings.width, settings.height, labels.is_some());
        // SAFETY: the caller's promise.
        unsafe { border::create(memory, size, required, make, made) }
    })
}

/// Number of pixels that get samples: all, or those of a label other than 0. 0 if `film` is none.
///
/// # Safety
/// `film` is NULL or a film.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pmcip_film_pixels(film: *mut Film) -> u64 {
    // SAFETY: the caller's promise.
    unsafe { border::film(film, |sampler| Ok(sampler.pixels() as u64)) }.unwrap_or(0)
}

/// Begins an iteration of `samples` samples over all pixels: plans how many each gets.
///
/// # Safety
/// `film` is NULL or a film.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pmcip_film_begin(film: *mut Film, samples: u64) -> PmcipStatus {
    // SAFETY: the caller's promise.
    run(|| unsafe { border::film(film, |sampler| Ok(sampler.begin(samples)?)) })
}

/// Begins an iteration with what earlier frames tell: one belief a pixel, row by row, of which none stems from this film.
///
/// # Safety
/// Pointers are NULL or point to as much as is said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pmcip_film_begin_beliefs(
    film: *mut Film,
    samples: u64,
    beliefs: *const PmcipBelief,
) -> PmcipStatus {
    // SAFETY: the caller's promise; the two structures have the same fields in C's order.
    run(|| unsafe {
        border::film(film, |sampler| {
            let beliefs = lent(beliefs.cast::<Belief>(), area(sampler))?;
            Ok(sampler.begin_predicted(samples, Prior::Beliefs(beliefs))?)
        })
    })
}

/// Begins an iteration with a kernel of the caller's: how many samples each pixel gets in proportion, row by row; none
/// where it is 0.
///
/// # Safety
/// Pointers are NULL or point to as much as is said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pmcip_film_begin_alpha(
    film: *mut Film,
    samples: u64,
    alpha: *const f32,
) -> PmcipStatus {
    // SAFETY: the caller's promise.
    run(|| unsafe {
        border::film(film, |sampler| {
            let alpha = lent(alpha, area(sampler))?;
            Ok(sampler.begin_predicted(samples, Prior::Alpha(alpha))?)
        })
    })
}

/// Writes samples of the running iteration, from pixel `first` on (0, or the end of a piece), as many as fit into arrays of
/// `room` entries, and says which they are. Nothing changes by it.
///
/// # Safety
/// Pointers are NULL or point to as much as is said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pmcip_film_plan(
    film: *mut Film,
    first: usize,
    room: usize,
    x: *mut f32,
    y: *mut f32,
    index: *mut u32,
    key: *mut u32,
    piece: *mut PmcipPiece,
) -> PmcipStatus {
    // SAFETY: the caller's promise.
    run(|| unsafe {
        let (piece, mut wave) = (place(piece)?, lent_wave(room, x, y, index, key)?);
        border::film(film, |sampler| {
            let Piece { first, end, samples } = sampler.plan(first, &mut wave)?;
            *piece = PmcipPiece { first, end, samples };
            Ok(())
        })
    })
}

/// Takes the radiances of a piece, `samples` times linear RGB in the order of its samples. Pieces may come in any order.
///
/// # Safety
/// Pointers are NULL or point to as much as is said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pmcip_film_deliver(
    film: *mut Film,
    piece: *const PmcipPiece,
    rgb: *const f32,
    samples: usize,
) -> PmcipStatus {
    // SAFETY: the caller's promise.
    run(|| unsafe {
        let (piece, rgb) = (piece.as_ref().ok_or(PmcipStatus::Pointer)?, lent(rgb.cast(), samples)?);
        let piece = Piece { first: piece.first, end: piece.end, samples: piece.samples };
        border::film(film, |sampler| Ok(sampler.deliver(piece, rgb).map(|_| ())?))
    })
}

/// Ends the iteration, when all samples have been delivered. `tally`, if not NULL, gets what there is since the first one.
///
/// # Safety
/// Pointers are NULL or point to as much as is said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pmcip_film_end(film: *mut Film, tally: *mut PmcipTally) -> PmcipStatus {
    // SAFETY: the caller's promise.
    run(|| unsafe {
        border::film(film, |sampler| {
            let all = sampler.end()?;
            if let Some(tally) = tally.as_mut() {
                *tally = all.into();
            }
            Ok(())
        })
    })
}

/// Bytes of memory that `pmcip_jobs` take.
#[unsafe(no_mangle)]
pub extern "C" fn pmcip_jobs_size() -> usize {
    border::size_of_one::<PmcipJobs>()
}

/// Bytes of memory that a `pmcip_job` takes.
#[unsafe(no_mangle)]
pub extern "C" fn pmcip_job_size() -> usize {
    border::size_of_one::<PmcipJob>()
}

/// Divides what is left of the running iteration into jobs, for threads. `memory` has `size` bytes.
///
/// # Safety
/// Pointers are NULL or point to as much as is said. Until the last job has been delivered no other call takes the film.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pmcip_jobs_begin(
    film: *mut Film,
    memory: *mut c_void,
    size: usize,
    jobs: *mut *mut PmcipJobs,
) -> PmcipStatus {
    // SAFETY: the caller's promise.
    run(|| unsafe {
        let sampler = border::take(film)?;
        if sampler.state().running() == 0 {
            return Err(PmcipStatus::Order);
        }
        border::put(memory, size, PmcipJobs(sampler.into_jobs()), jobs)
    })
}

/// Writes the next job into `memory` of `size` bytes; `PMCIP_STATUS_DONE` if there is none. By one thread at a time.
///
/// # Safety
/// Pointers are NULL or point to as much as is said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pmcip_jobs_next(
    jobs: *mut PmcipJobs,
    memory: *mut c_void,
    size: usize,
    job: *mut *mut PmcipJob,
) -> PmcipStatus {
    // SAFETY: the caller's promise.
    run(|| unsafe {
        let next = place(jobs)?.0.next().ok_or(PmcipStatus::Done)?;
        border::put(memory, size, PmcipJob(next), job)
    })
}

/// Writes the next samples of a job, at most `room` of them, and how many to `samples`: 0 at its end.
///
/// # Safety
/// Pointers are NULL or point to as much as is said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pmcip_job_plan(
    job: *mut PmcipJob,
    room: usize,
    x: *mut f32,
    y: *mut f32,
    index: *mut u32,
    key: *mut u32,
    samples: *mut usize,
) -> PmcipStatus {
    // SAFETY: the caller's promise.
    run(|| unsafe {
        let (samples, mut wave) = (place(samples)?, lent_wave(room, x, y, index, key)?);
        if room == 0 {
            return Err(PmcipStatus::Room);
        }
        *samples = place(job)?.0.plan(&mut wave);
        Ok(())
    })
}

/// Takes the radiances of the next `samples` samples that were planned, in the same order.
///
/// # Safety
/// Pointers are NULL or point to as much as is said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pmcip_job_deliver(
    job: *mut PmcipJob,
    rgb: *const f32,
    samples: usize,
) -> PmcipStatus {
    // SAFETY: the caller's promise.
    run(|| unsafe {
        place(job)?.0.deliver(lent(rgb.cast(), samples)?);
        Ok(())
    })
}

/// Writes the points of set `set` (1 or higher) of `samples` samples, coordinates in [0, 1).
///
/// # Safety
/// Pointers are NULL or point to as much as is said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pmcip_points(
    set: u32,
    samples: usize,
    index: *const u32,
    key: *const u32,
    u: *mut f32,
    v: *mut f32,
) -> PmcipStatus {
    // SAFETY: the caller's promise.
    run(|| unsafe {
        let names = (lent(index, samples)?, lent(key, samples)?);
        wave::points(set, names.0, names.1, lent_mut(u, samples)?, lent_mut(v, samples)?);
        Ok(())
    })
}

/// Floats of scratch that the pictures of a film of this size take.
#[unsafe(no_mangle)]
pub extern "C" fn pmcip_scratch_size(width: u32, height: u32) -> usize {
    Sampler::resolve_scratch(width, height).saturating_mul(16)
}

/// Writes the picture: linear RGB, row by row from the top. `scratch` has `floats` entries.
///
/// # Safety
/// Pointers are NULL or point to as much as is said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pmcip_film_resolve(
    film: *mut Film,
    estimator: u32,
    scratch: *mut f32,
    floats: usize,
    rgb: *mut f32,
) -> PmcipStatus {
    // SAFETY: the caller's promise.
    run(|| unsafe {
        let estimator = types::estimator(estimator).ok_or(PmcipStatus::Estimator)?;
        let scratch = lent_mut(scratch.cast(), floats / 16)?;
        border::film(film, |sampler| {
            Ok(sampler.resolve(estimator, scratch, lent_mut(rgb, 3 * area(sampler))?)?)
        })
    })
}

/// Writes any picture of the same size, `guide`, with the energy of the film: linear RGB, row by row.
///
/// # Safety
/// Pointers are NULL or point to as much as is said; `guide` is not `rgb`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pmcip_film_resolve_guided(
    film: *mut Film,
    guide: *const f32,
    scratch: *mut f32,
    floats: usize,
    rgb: *mut f32,
) -> PmcipStatus {
    // SAFETY: the caller's promise.
    run(|| unsafe {
        let scratch = lent_mut(scratch.cast(), floats / 16)?;
        border::film(film, |sampler| {
            let pixels = area(sampler);
            Ok(sampler.resolve_guided(lent(guide.cast(), pixels)?, scratch, lent_mut(rgb.cast(), pixels)?)?)
        })
    })
}

/// Floats of scratch that `pmcip_film_filter` takes.
#[unsafe(no_mangle)]
pub extern "C" fn pmcip_filter_size(width: u32, height: u32, labelled: u32) -> usize {
    match labelled {
        0 => Filter::required(width, height),
        _ => Filter::required_with_labels(width, height),
    }
}

/// Writes the filtered picture, a guide for `pmcip_film_resolve_guided`. `features` is NULL or has one entry a pixel, row by
/// row; `scratch` has `floats` entries. About 4 microseconds a pixel on this thread.
///
/// # Safety
/// Pointers are NULL or point to as much as is said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pmcip_film_filter(
    film: *mut Film,
    features: *const PmcipFeature,
    scratch: *mut f32,
    floats: usize,
    guide: *mut f32,
) -> PmcipStatus {
    // SAFETY: the caller's promise; the two structures have the same fields in C's order.
    run(|| unsafe {
        let scratch = lent_mut(scratch, floats)?;
        border::film(film, |sampler| {
            let pixels = area(sampler);
            let features = match features.is_null() {
                true => &[][..],
                false => lent(features.cast::<Feature>(), pixels)?,
            };
            let mut filter = Filter::new(sampler, features, scratch)?;
            for _ in 0..Filter::PASSES {
                filter.bands().for_each(|mut band| band.filter());
                filter.next();
            }
            Ok(filter.write(lent_mut(guide.cast(), pixels)?)?)
        })
    })
}

/// Writes the variance of every pixel's mean luminance, row by row.
///
/// # Safety
/// Pointers are NULL or point to as much as is said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pmcip_film_variance(film: *mut Film, variance: *mut f32) -> PmcipStatus {
    // SAFETY: the caller's promise.
    run(|| unsafe { border::film(film, |s| Ok(s.variance(lent_mut(variance, area(s))?)?)) })
}

/// Writes how many samples every pixel has, row by row.
///
/// # Safety
/// Pointers are NULL or point to as much as is said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pmcip_film_count(film: *mut Film, count: *mut u32) -> PmcipStatus {
    // SAFETY: the caller's promise.
    run(|| unsafe { border::film(film, |s| Ok(s.count(lent_mut(count, area(s))?)?)) })
}

/// Writes the kernel of the current or last iteration, row by row; it sums to one.
///
/// # Safety
/// Pointers are NULL or point to as much as is said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pmcip_film_alpha(film: *mut Film, alpha: *mut f32) -> PmcipStatus {
    // SAFETY: the caller's promise.
    run(|| unsafe { border::film(film, |s| Ok(s.alpha(lent_mut(alpha, area(s))?)?)) })
}

/// Writes what the film believes of every pixel, row by row, for `pmcip_film_begin_beliefs` of the next frame.
///
/// # Safety
/// Pointers are NULL or point to as much as is said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pmcip_film_beliefs(film: *mut Film, beliefs: *mut PmcipBelief) -> PmcipStatus {
    // SAFETY: the caller's promise; the two structures have the same fields in C's order.
    run(|| unsafe { border::film(film, |s| Ok(s.beliefs(lent_mut(beliefs.cast::<Belief>(), area(s))?)?)) })
}

/// Bytes of the saved film; 0 if `film` is none.
///
/// # Safety
/// `film` is NULL or a film.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pmcip_film_saved_size(film: *mut Film) -> usize {
    // SAFETY: the caller's promise.
    unsafe { border::film(film, |sampler| Ok(sampler.saved_len())) }.unwrap_or(0)
}

/// Writes the film as bytes, exactly as many as `pmcip_film_saved_size` says, the same on every machine.
///
/// # Safety
/// Pointers are NULL or point to as much as is said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pmcip_film_save(film: *mut Film, bytes: *mut u8, size: usize) -> PmcipStatus {
    // SAFETY: the caller's promise.
    run(|| unsafe {
        border::film(film, |sampler| match size == sampler.saved_len() {
            true => Ok(sampler.save(lent_mut(bytes, size)?)?),
            false => Err(PmcipStatus::Memory),
        })
    })
}

/// Makes the film that was saved as `bytes` in `memory` of `size` bytes. With `memory` NULL, says in `needed` how many
/// bytes that takes.
///
/// # Safety
/// Pointers are NULL or point to as much as is said; `memory` is not used otherwise while the film is.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pmcip_film_load(
    bytes: *const u8,
    length: usize,
    memory: *mut c_void,
    size: usize,
    needed: *mut usize,
    made: *mut *mut Film,
) -> PmcipStatus {
    // SAFETY: the caller's promise.
    run(|| unsafe {
        let saved = Saved::new(lent(bytes, length)?)?;
        let settings = saved.state().settings();
        let labelled = saved.state().required() != Sampler::required(settings.width, settings.height);
        let (width, height) = (settings.width, settings.height);
        if let Some(needed) = needed.as_mut() {
            *needed = border::film_size(width, height, labelled);
        }
        if memory.is_null() {
            return Ok(());
        }
        border::create(memory, size, (width, height, labelled), |memory| saved.restore(memory), made)
    })
}

/// Pixels of the picture.
fn area(sampler: &Sampler<'_>) -> usize {
    sampler.settings().width as usize * sampler.settings().height as usize
}

/// Arrays lent for samples.
///
/// # Safety
/// Pointers are NULL or point to `room` entries.
unsafe fn lent_wave<'a>(
    room: usize,
    x: *mut f32,
    y: *mut f32,
    index: *mut u32,
    key: *mut u32,
) -> Result<Wave<'a>, PmcipStatus> {
    // SAFETY: the caller's promise.
    unsafe {
        Ok(Wave {
            x: lent_mut(x, room)?,
            y: lent_mut(y, room)?,
            index: lent_mut(index, room)?,
            key: lent_mut(key, room)?,
        })
    }
}
