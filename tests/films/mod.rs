//! Saved films with words changed to anything, their check sum made right again: each is refused, or it is a film that can be
//! read, merged and gone on with, without a panic, and ends. Shared with the fuzz target `film`.

use pmcip::film::Film;
use pmcip_core::sampler::Settings;
use pmcip_core::sampler::batch::{Batch8, Rgb8};
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::saved::Saved;
use wide::f32x8;

/// Bytes before the words.
const HEADER: usize = 16;
/// Samples above which an iteration is not worth waiting for.
const MANY: u64 = 1 << 16;

fn value(batch: &Batch8) -> Rgb8 {
    let (u, v) = batch.point(1);
    Rgb8 { r: u, g: v, b: u * v * f32x8::splat(9.0) }
}

/// Films to change: of pixels or islands, at rest or in the middle of an iteration.
pub fn sound() -> Vec<Vec<u8>> {
    let mut films = Vec::new();
    for estimator in [Estimator::Balanced, Estimator::Subframe] {
        let settings = Settings { estimator, ..Settings::new(19, 17).for_frame(2, 8) };
        let labels: Vec<u16> = (0..19 * 17).map(|i| (i % 19 / 7) as u16).collect();
        for film in [Film::new(settings), Film::with_labels(settings, &labels)] {
            let mut film = film.expect("there is memory");
            for _ in 0..2 {
                film.begin(700).expect("it is at rest");
                films.push(film.save().expect("there is memory"));
                film.render(&mut { value }).expect("it runs");
                film.end().expect("all is taken");
                films.push(film.save().expect("there is memory"));
            }
        }
    }
    films
}

/// Changes words of a film, by their numbers, and sees what comes of it; says whether it was still a film.
pub fn probe(film: &[u8], other: &[u8], changes: &[(u16, u32)]) -> bool {
    let mut bytes = film.to_vec();
    let (words, _) = bytes[HEADER..].as_chunks_mut::<4>();
    for (at, word) in changes {
        let at = usize::from(*at) % words.len();
        words[at] = word.to_le_bytes();
    }
    let sum = check_sum(&bytes[HEADER..]);
    bytes[12..HEADER].copy_from_slice(&sum.to_le_bytes());
    let Ok(saved) = Saved::new(&bytes) else { return false };
    if saved.state().running() > MANY || saved.state().required().floats > 1 << 16 {
        return true;
    }
    let mut film = Film::load(&bytes).expect("it was checked");
    assert!(film.save().expect("there is memory") == bytes, "it is saved otherwise than it was");
    if saved.state().running() > 0 {
        film.render(&mut { value }).expect("it runs");
        // Less may have been planned than runs, never more.
        film.end().expect("all is taken");
    }
    for estimator in [Estimator::Pooled, Estimator::Subframe, Estimator::Difference, Estimator::Balanced] {
        let _ = film.resolve(estimator);
    }
    let _ = film.merge(other);
    if film.begin(500).is_ok() {
        film.render(&mut { value }).expect("it runs");
        film.end().expect("all is taken");
    }
    true
}

/// As the format has it: FNV-1a over words, both halves.
fn check_sum(bytes: &[u8]) -> u32 {
    let (words, _) = bytes.as_chunks::<4>();
    let sum = words.iter().fold(0xcbf2_9ce4_8422_2325u64, |sum, word| {
        (sum ^ u64::from(u32::from_le_bytes(*word))).wrapping_mul(0x0100_0000_01b3)
    });
    (sum ^ sum >> 32) as u32
}
