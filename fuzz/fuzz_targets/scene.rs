//! A scene with any numbers changed to anything: either refused, or rays end in it, the same together and alone.

#![no_main]

use arbitrary::Arbitrary;
use libfuzzer_sys::fuzz_target;
use std::sync::LazyLock;
use view::{Change, Random, View, probe};

#[path = "../../tests/view/mod.rs"]
mod view;

#[derive(Arbitrary, Debug)]
struct Input {
    seed: u32,
    changes: Vec<(u8, u16, u8, u32)>,
}

static SOUND: LazyLock<View> = LazyLock::new(|| View::new(1));

fuzz_target!(|input: Input| {
    let mut view = SOUND.clone();
    for (target, at, field, bits) in input.changes {
        view.change(Change { target, at, field, bits });
    }
    if let Some(scene) = view.scene() {
        probe(scene, &mut Random(input.seed));
    }
});
