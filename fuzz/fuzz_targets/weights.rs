//! Any radiances, in any settings: the loop never fails, counts are exact, weights and pictures finite.

#![no_main]

use libfuzzer_sys::fuzz_target;

#[allow(dead_code, reason = "shared with other targets")]
#[path = "../../tests/doors/mod.rs"]
mod doors;

fuzz_target!(|data: &[u8]| doors::weights::check(data));
