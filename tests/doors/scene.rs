//! A scene with any numbers changed to anything: either refused, or rays end in it, the same together and alone.

use super::bytes::Bytes;
use super::view::{Change, Random, View, probe};
use std::sync::LazyLock;

static SOUND: LazyLock<View> = LazyLock::new(|| View::new(1));

/// A seed of rays, then changes.
pub fn check(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let mut random = Random(bytes.word());
    let mut view = SOUND.clone();
    while !bytes.is_empty() {
        let (target, at, field) = (bytes.byte(), bytes.half(), bytes.byte());
        view.change(Change { target, at, field, bits: bytes.word() });
    }
    if let Some(scene) = view.scene() {
        probe(scene, &mut random);
    }
}

/// None, and one of every kind.
pub fn seeds() -> Vec<Vec<u8>> {
    let change = |target: u8| vec![1, 0, 0, 0, target, 3, 0, 2, 0, 0, 0, 63];
    (0..8).map(change).chain([vec![]]).collect()
}
