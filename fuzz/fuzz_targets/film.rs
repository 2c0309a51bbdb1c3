//! A saved film with any words changed to anything: refused, or a film that can be read, merged and gone on with.

#![no_main]

use arbitrary::Arbitrary;
use libfuzzer_sys::fuzz_target;
use std::sync::LazyLock;

#[path = "../../tests/films/mod.rs"]
mod films;

#[derive(Arbitrary, Debug)]
struct Input {
    film: u8,
    other: u8,
    changes: Vec<(u16, u32)>,
}

static SOUND: LazyLock<Vec<Vec<u8>>> = LazyLock::new(films::sound);

fuzz_target!(|input: Input| {
    let [film, other] = [input.film, input.other].map(|i| &SOUND[usize::from(i) % SOUND.len()]);
    films::probe(film, other, &input.changes);
});
