//! A scene with any numbers changed to anything: either refused, or rays end in it, the same together and alone.

#![no_main]

use libfuzzer_sys::fuzz_target;

#[allow(dead_code, reason = "shared with other targets")]
#[path = "../../tests/doors/mod.rs"]
mod doors;

fuzz_target!(|data: &[u8]| doors::scene::check(data));
