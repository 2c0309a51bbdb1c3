//! Any calls in any order through the border to C, with any arguments that its contract allows: a status comes back, never
//! that of a fault, and nothing beyond what was lent is written.

use super::bytes::{Bytes, Cycle};
use pmcip_capi::*;
use std::ffi::{CStr, c_void};
use std::ptr::{null, null_mut};

/// Pixels of a side are below this.
const SIDE: u32 = 20;
/// Samples above which an iteration is not worth taking.
const MANY: u64 = 1 << 14;
/// What stands behind lent memory.
const GUARD: usize = 16;

/// An array that notices what is written behind its end.
struct Lent<T> {
    values: Vec<T>,
    guard: T,
}

impl<T: Copy + PartialEq + std::fmt::Debug> Lent<T> {
    fn new(length: usize, guard: T) -> Self {
        Lent { values: vec![guard; length + GUARD], guard }
    }

    fn pointer(&mut self) -> *mut T {
        self.values.as_mut_ptr()
    }

    fn inside(&self) -> &[T] {
        let (inside, behind) = self.values.split_at(self.values.len() - GUARD);
        assert_eq!(behind, [self.guard; GUARD], "written behind the end");
        inside
    }
}

/// A film and the memory it is in.
struct Lot {
    film: *mut Film,
    memory: Lent<u8>,
    pixels: usize,
    running: u64,
    piece: PmcipPiece,
}

/// Up to 40 calls on two films.
pub fn check(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let tame = bytes.bit();
    let mut any = bytes.cycle(32, tame);
    let mut lots = [make(&mut bytes), make(&mut bytes)];
    for _ in 0..40 {
        if bytes.is_empty() {
            break;
        }
        let which = bytes.below(2);
        call(&mut bytes, &mut any, &mut lots, which);
        lots.iter().for_each(|lot| _ = lot.memory.inside());
    }
}

fn call(bytes: &mut Bytes, any: &mut Cycle, lots: &mut [Lot; 2], which: usize) {
    let lot = &mut lots[which];
    match bytes.below(12) {
        0 => *lot = make(bytes),
        1 | 2 => begin(bytes, any, lot),
        3 => plan(bytes, lot),
        4 => deliver(bytes, any, lot),
        5 => all_pieces(bytes, any, lot),
        6 => jobs(bytes, any, lot),
        7 => end(bytes, lot),
        8 => planes(bytes, lot),
        9 => pictures(bytes, any, lot),
        10 => {
            let loaded = save_and_load(bytes, lot);
            lots[1 - which] = loaded.unwrap_or_else(|| make(bytes));
        }
        _ => without_film(bytes, any),
    }
}

/// Whether it was done; a fault never is.
fn done(status: PmcipStatus) -> bool {
    assert_ne!(status, PmcipStatus::Fault);
    // SAFETY: a string that is always there.
    assert!(!unsafe { CStr::from_ptr(pmcip_message(status as u32)) }.is_empty());
    status == PmcipStatus::Ok
}

/// A film, or none.
fn make(bytes: &mut Bytes) -> Lot {
    let choice = bytes.byte();
    let [width, height] = [0; 2].map(|_| u32::from(bytes.byte()) % SIDE);
    // SAFETY: a number alone.
    let mut settings: PmcipSettings = unsafe { std::mem::zeroed() };
    let place: *mut PmcipSettings = &mut settings;
    // SAFETY: settings, or NULL.
    let made = unsafe { pmcip_settings_new(width, height, 1, u32::from(choice >> 4), place) };
    assert!(done(made));
    // SAFETY: NULL is allowed.
    assert!(unsafe { pmcip_settings_new(1, 1, 0, 0, null_mut()) } == PmcipStatus::Pointer);
    settings.estimator = u32::from(bytes.byte() % 5);
    if choice & 1 == 1 {
        settings.gamma = bytes.float(true);
        settings.cd_per_unit = bytes.float(false);
        settings.balance_radius = bytes.word();
        (settings.fresh, settings.uniform) = (u32::from(bytes.byte()), u32::from(bytes.byte() / 128));
    }
    let pixels = width as usize * height as usize;
    let labels: Option<Vec<u16>> =
        (choice & 2 == 2).then(|| (0..pixels).map(|i| u16::from(bytes.byte() % 3) + i as u16 % 2).collect());
    let labels = labels.as_deref().map_or(null(), <[u16]>::as_ptr);
    let size = pmcip_film_size(width, height, u32::from(!labels.is_null()));
    let mut lot = Lot {
        film: null_mut(),
        memory: Lent::new(0, 0x5a),
        pixels: 0,
        running: 0,
        piece: PmcipPiece::default(),
    };
    if size == usize::MAX {
        return lot;
    }
    lot.memory = Lent::new(size, 0x5a);
    let size = size.saturating_sub(usize::from(choice >> 2 & 1));
    let memory: *mut c_void = if choice & 8 == 0 { lot.memory.pointer().cast() } else { null_mut() };
    // SAFETY: all is as long as is said.
    if done(unsafe { pmcip_film_create(memory, size, &settings, labels, &mut lot.film) }) {
        lot.pixels = pixels;
        // SAFETY: a film.
        assert!(unsafe { pmcip_film_pixels(lot.film) } <= pixels as u64);
    }
    lot
}

fn begin(bytes: &mut Bytes, any: &mut Cycle, lot: &mut Lot) {
    let kind = bytes.byte();
    let samples =
        if kind & 0xf0 == 0xf0 { bytes.long() } else { u64::from(bytes.byte()) * lot.pixels as u64 / 64 };
    let alpha = any.list(lot.pixels);
    let belief = |_| PmcipBelief { variance: any.one(), light: any.one(), freedom: any.one() };
    let beliefs: Vec<PmcipBelief> = (0..lot.pixels).map(belief).collect();
    // SAFETY: one entry a pixel, or NULL.
    let status = unsafe {
        match kind % 4 {
            0 | 1 => pmcip_film_begin(lot.film, samples),
            2 => pmcip_film_begin_alpha(lot.film, samples, alpha.as_ptr()),
            _ if kind & 4 == 4 => pmcip_film_begin_beliefs(lot.film, samples, null()),
            _ => pmcip_film_begin_beliefs(lot.film, samples, beliefs.as_ptr()),
        }
    };
    if done(status) {
        lot.running = samples;
    }
}

/// Arrays for samples.
struct Arrays {
    floats: [Lent<f32>; 2],
    words: [Lent<u32>; 2],
}

impl Arrays {
    fn new(room: usize) -> Self {
        Arrays { floats: [0; 2].map(|_| Lent::new(room, -7.0)), words: [0; 2].map(|_| Lent::new(room, 77)) }
    }

    fn plan(&mut self, lot: &Lot, first: usize, room: usize, piece: *mut PmcipPiece) -> bool {
        let ([x, y], [index, key]) = (&mut self.floats, &mut self.words);
        // SAFETY: arrays of so many entries.
        let planned = done(unsafe {
            let (x, y, index, key) = (x.pointer(), y.pointer(), index.pointer(), key.pointer());
            pmcip_film_plan(lot.film, first, room, x, y, index, key, piece)
        });
        self.floats.iter().for_each(|array| _ = array.inside());
        self.words.iter().for_each(|array| _ = array.inside());
        planned
    }
}

/// Samples from anywhere.
fn plan(bytes: &mut Bytes, lot: &mut Lot) {
    let (kind, room) = (bytes.byte(), usize::from(bytes.byte()));
    let first = if kind & 1 == 1 { bytes.long() as usize } else { usize::from(bytes.byte()) };
    let mut piece = PmcipPiece::default();
    if Arrays::new(room).plan(lot, first, room, if kind & 2 == 2 { null_mut() } else { &mut piece }) {
        lot.piece = piece;
    }
}

/// A piece that was planned once, or any.
fn deliver(bytes: &mut Bytes, any: &mut Cycle, lot: &mut Lot) {
    let kind = bytes.byte();
    let mut piece = lot.piece;
    if kind & 1 == 1 {
        piece = PmcipPiece { first: bytes.long() as usize, end: bytes.long() as usize, ..piece };
    }
    let samples = if kind & 2 == 2 { usize::from(bytes.byte()) } else { piece.samples };
    let rgb = any.list(3 * samples);
    let pointer: *const PmcipPiece = if kind & 12 == 12 { null() } else { &piece };
    // SAFETY: so many radiances.
    done(unsafe { pmcip_film_deliver(lot.film, pointer, rgb.as_ptr(), samples) });
}

/// All that is left of an iteration, in pieces.
fn all_pieces(bytes: &mut Bytes, any: &mut Cycle, lot: &mut Lot) {
    let room = 64 + usize::from(bytes.byte());
    let (mut arrays, mut first) = (Arrays::new(room), 0);
    while lot.running <= MANY && first < lot.pixels {
        let mut piece = PmcipPiece::default();
        if !arrays.plan(lot, first, room, &mut piece) {
            return;
        }
        assert!(piece.samples <= room && piece.end > first && piece.end <= lot.pixels, "{piece:?}");
        let rgb = any.list(3 * piece.samples);
        // SAFETY: so many radiances.
        assert!(done(unsafe { pmcip_film_deliver(lot.film, &piece, rgb.as_ptr(), piece.samples) }));
        first = piece.end;
    }
}

/// What is left of an iteration by jobs. A film whose jobs were not delivered may not be used any more.
fn jobs(bytes: &mut Bytes, any: &mut Cycle, lot: &mut Lot) {
    let (kind, most) = (bytes.byte(), if lot.running <= MANY { 4096 } else { 64 });
    let (mut jobs, mut job) = (null_mut(), null_mut());
    let (mut some, mut one) = (Lent::new(pmcip_jobs_size(), 0x33u8), Lent::new(pmcip_job_size(), 0x44u8));
    let short = usize::from(kind & 7 == 7);
    // SAFETY: memory of so many bytes; no other call takes the film before these are forgotten.
    if !done(unsafe {
        pmcip_jobs_begin(lot.film, some.pointer().cast(), pmcip_jobs_size() - short, &mut jobs)
    }) {
        return;
    }
    let (room, mut calls, mut left) = (1 + usize::from(kind >> 3), 0, 0);
    loop {
        // SAFETY: the last job is not used any more.
        let next = unsafe { pmcip_jobs_next(jobs, one.pointer().cast(), pmcip_job_size(), &mut job) };
        if next == PmcipStatus::Done || !done(next) {
            break;
        }
        loop {
            let mut samples = 0;
            let mut arrays = Arrays::new(room);
            let ([x, y], [index, key]) = (&mut arrays.floats, &mut arrays.words);
            let (x, y, index, key) = (x.pointer(), y.pointer(), index.pointer(), key.pointer());
            // SAFETY: arrays of so many entries.
            assert!(done(unsafe { pmcip_job_plan(job, room, x, y, index, key, &mut samples) }));
            assert!(samples <= room);
            calls += 1;
            left += samples;
            if samples == 0 || calls > most {
                break;
            }
            // Fewer or more than were planned: the rest comes with the next ones, what is too much is ignored.
            let told = if kind & 1 == 1 { samples } else { bytes.below(2 * room) };
            let rgb = any.list(3 * told);
            // SAFETY: so many radiances.
            assert!(done(unsafe { pmcip_job_deliver(job, rgb.as_ptr(), told) }));
            left -= told.min(left);
        }
        one.inside();
    }
    some.inside();
    if left > 0 || calls > most {
        (lot.film, lot.pixels, lot.running) = (null_mut(), 0, 0);
    }
}

fn end(bytes: &mut Bytes, lot: &mut Lot) {
    let mut tally = PmcipTally::default();
    let pointer: *mut PmcipTally = if bytes.bit() { &mut tally } else { null_mut() };
    // SAFETY: a tally or NULL.
    if done(unsafe { pmcip_film_end(lot.film, pointer) }) {
        assert!(pointer.is_null() || tally.samples + tally.rejected > 0);
        lot.running = 0;
    }
}

/// What a film knows of its pixels.
fn planes(bytes: &mut Bytes, lot: &mut Lot) {
    let (mut floats, mut counts) = (Lent::new(lot.pixels, -3.0f32), Lent::new(lot.pixels, 9u32));
    let mut beliefs = vec![PmcipBelief { variance: 0.0, light: 0.0, freedom: 0.0 }; lot.pixels];
    // SAFETY: one entry a pixel.
    let known = unsafe {
        match bytes.below(5) {
            0 => done(pmcip_film_variance(lot.film, floats.pointer())),
            1 => done(pmcip_film_count(lot.film, counts.pointer())),
            2 => done(pmcip_film_beliefs(lot.film, beliefs.as_mut_ptr())),
            3 => {
                assert!(!done(pmcip_film_alpha(lot.film, null_mut())));
                false
            }
            _ => done(pmcip_film_alpha(lot.film, floats.pointer())),
        }
    };
    counts.inside();
    assert!(floats.inside().iter().all(|v| !known || !v.is_nan()));
}

fn pictures(bytes: &mut Bytes, any: &mut Cycle, lot: &mut Lot) {
    let kind = bytes.byte();
    let [width, height] = [0; 2].map(|_| u32::from(bytes.byte()) % SIDE);
    // For any size: too short, right, or too long.
    let sizes = [pmcip_scratch_size(width, height), pmcip_filter_size(width, height, u32::from(kind & 64))];
    let length = sizes[usize::from(kind >> 7)].min(1 << 16);
    let (mut scratch, mut rgb) = (Lent::new(length, 0.25f32), Lent::new(3 * lot.pixels, 0.0f32));
    let guide = any.list(3 * lot.pixels);
    let feature = |_| PmcipFeature { albedo: any.rgb(), normal: any.rgb(), depth: any.one() };
    let features: Vec<PmcipFeature> = (0..lot.pixels).map(feature).collect();
    let features: *const PmcipFeature = if kind & 32 == 0 { features.as_ptr() } else { null() };
    let (to, room) = (rgb.pointer(), scratch.pointer());
    // SAFETY: as long as is said.
    done(unsafe {
        match kind % 4 {
            0 | 1 => pmcip_film_resolve(lot.film, u32::from(kind >> 2 & 7), room, length, to),
            2 => pmcip_film_resolve_guided(lot.film, guide.as_ptr(), room, length, to),
            _ => pmcip_film_filter(lot.film, features, room, length, to),
        }
    });
    scratch.inside();
    assert!(rgb.inside().iter().all(|v| v.is_finite()));
}

/// A film from the bytes of another, some of them changed or missing.
fn save_and_load(bytes: &mut Bytes, lot: &mut Lot) -> Option<Lot> {
    // SAFETY: a film or NULL.
    let size = unsafe { pmcip_film_saved_size(lot.film) };
    let mut saved = Lent::new(size, 0x11u8);
    let kind = bytes.byte();
    let said = size.saturating_sub(usize::from(kind & 15 == 15));
    // SAFETY: so many bytes.
    if !done(unsafe { pmcip_film_save(lot.film, saved.pointer(), said) }) {
        return None;
    }
    saved.inside();
    if kind & 3 == 3 {
        let at = bytes.word() as usize % size;
        saved.values[at] = bytes.byte();
    }
    let (mut needed, mut film) = (0, null_mut());
    // SAFETY: so many bytes; NULL is allowed.
    if !done(unsafe { pmcip_film_load(saved.pointer(), said, null_mut(), 0, &mut needed, &mut film) }) {
        return None;
    }
    let mut memory = Lent::new(needed, 0x5a);
    let given = needed.saturating_sub(usize::from(kind & 16 == 16));
    // SAFETY: so many bytes.
    let loaded = unsafe {
        pmcip_film_load(saved.pointer(), said, memory.pointer().cast(), given, null_mut(), &mut film)
    };
    done(loaded).then_some(Lot { film, memory, pixels: lot.pixels, running: lot.running, piece: lot.piece })
}

fn without_film(bytes: &mut Bytes, any: &mut Cycle) {
    let samples = usize::from(bytes.byte());
    let words: Vec<u32> = any.list(samples).iter().map(|v| v.to_bits()).collect();
    let (mut u, mut v) = (Lent::new(samples, 2.0f32), Lent::new(samples, 2.0f32));
    // SAFETY: arrays of so many entries.
    let made = unsafe {
        pmcip_points(bytes.word(), samples, words.as_ptr(), words.as_ptr(), u.pointer(), v.pointer())
    };
    assert!(done(made));
    assert!([u, v].iter().all(|array| array.inside().iter().all(|v| (0.0..1.0).contains(v))));
    let (width, height, labelled) = (bytes.word(), bytes.word(), bytes.word());
    pmcip_film_size(width, height, labelled);
    pmcip_scratch_size(width, height);
    pmcip_filter_size(width, height, labelled);
    // SAFETY: a string that is always there.
    assert!(!unsafe { CStr::from_ptr(pmcip_message(bytes.word())) }.is_empty());
}

/// A frame by pieces, one by jobs, one by beliefs with labels, one that is saved in the middle and goes on, and disorder.
pub fn seeds() -> Vec<Vec<u8>> {
    let radiance: Vec<u8> = (0..16i16).flat_map(|i| (i * 93).to_le_bytes()).collect();
    let head = [&[1], &radiance[..]].concat();
    let plain = [0x80, 9, 7, 3];
    let labelled: Vec<u8> = [&[0x82, 5, 5, 3][..], &[1; 25]].concat();
    let (begin, pieces, jobs, end) = ([0, 1, 0, 255], [0, 5, 99], [0, 6, 0x29], [0, 7, 1]);
    let picture = |kind: u8| [0, 9, kind, 19, 19];
    let plane = |which: u8| [0, 8, which];
    let seed = |calls: &[&[u8]]| [&head[..], &plain, &plain, &calls.concat()].concat();
    vec![
        seed(&[
            &begin,
            &pieces,
            &end,
            &begin,
            &pieces,
            &end,
            &picture(0x0c),
            &picture(2),
            &picture(0xe3),
            &plane(2),
        ]),
        seed(&[
            &begin,
            &jobs,
            &end,
            &[0, 1, 3, 90],
            &jobs,
            &end,
            &picture(0),
            &plane(0),
            &plane(1),
            &plane(4),
        ]),
        [&head[..], &labelled, &labelled, &[begin.to_vec(), pieces.to_vec(), end.to_vec()].concat()].concat(),
        seed(&[
            &begin,
            &[0, 3, 0, 80, 0],
            &[0, 4, 0],
            &[0, 10, 0],
            &[1, 5, 3],
            &[1, 7, 1],
            &[1, 9, 0, 19, 19],
        ]),
        seed(&[&end, &picture(1), &[0, 4, 1], &[0, 1, 2, 9], &begin, &[0, 6, 0x28], &end, &[0, 11, 30]]),
    ]
}
