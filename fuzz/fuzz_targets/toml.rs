//! A scene file of any bytes.

#![no_main]

use libfuzzer_sys::fuzz_target;
use mutant::Place;
use std::sync::LazyLock;

#[allow(dead_code, reason = "shared with other targets")]
#[path = "../../tests/mutant/mod.rs"]
mod mutant;

static PLACE: LazyLock<Place> = LazyLock::new(Place::new);

fuzz_target!(|bytes: &[u8]| PLACE.load_toml(bytes));
