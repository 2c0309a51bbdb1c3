//! Any beliefs, motion, matches and regions, and a film that starts from them.

#![no_main]

use libfuzzer_sys::fuzz_target;

#[allow(dead_code, reason = "shared with other targets")]
#[path = "../../tests/doors/mod.rs"]
mod doors;

fuzz_target!(|data: &[u8]| doors::predict::check(data));
