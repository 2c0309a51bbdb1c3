//! Any film, features, guide and past: filter, blend and picture are finite, and the picture has the energy of the fair samples.

#![no_main]

use libfuzzer_sys::fuzz_target;

#[allow(dead_code, reason = "shared with other targets")]
#[path = "../../tests/doors/mod.rs"]
mod doors;

fuzz_target!(|data: &[u8]| doors::guide::check(data));
