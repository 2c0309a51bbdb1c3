//! A saved film with any words changed to anything: refused, or a film that can be read, merged and gone on with.

#![no_main]

use libfuzzer_sys::fuzz_target;

#[allow(dead_code, reason = "shared with other targets")]
#[path = "../../tests/doors/mod.rs"]
mod doors;

fuzz_target!(|data: &[u8]| doors::film::check(data));
