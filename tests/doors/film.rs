//! A saved film with any words changed to anything: refused, or a film that can be read, merged and gone on with.

use super::bytes::Bytes;
use super::films;
use std::sync::LazyLock;

static SOUND: LazyLock<Vec<Vec<u8>>> = LazyLock::new(films::sound);

/// Which film, which other, then places and what becomes of the words there.
pub fn check(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let [film, other] = [0; 2].map(|_| &SOUND[bytes.below(SOUND.len())]);
    let mut changes = Vec::new();
    while !bytes.is_empty() && changes.len() < 64 {
        changes.push((bytes.half(), bytes.word()));
    }
    films::probe(film, other, &changes);
}

/// Every film as it is, and with a field or a pixel changed.
pub fn seeds() -> Vec<Vec<u8>> {
    let film = |i: u8| vec![vec![i, 1], vec![i, 3, i, 0, 9, 0, 0, 0], vec![i, 2, 200, i, 0, 0, 192, 127]];
    (0..8).flat_map(film).collect()
}
