//! Any radiances of a pixel in two films that are merged: mean and variance as two passes in double precision find them.

#![no_main]

use libfuzzer_sys::fuzz_target;

#[allow(dead_code, reason = "shared with other targets")]
#[path = "../../tests/doors/mod.rs"]
mod doors;

fuzz_target!(|data: &[u8]| doors::merge::check(data));
