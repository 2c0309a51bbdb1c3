//! Any radiances in any film: every picture is finite, and `balanced` has the energy of `difference`.

#![no_main]

use libfuzzer_sys::fuzz_target;

#[allow(dead_code, reason = "shared with other targets")]
#[path = "../../tests/doors/mod.rs"]
mod doors;

fuzz_target!(|data: &[u8]| doors::estimate::check(data));
