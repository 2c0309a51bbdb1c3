//! A file of any bytes as a picture of `error` or `guide --with`.

#![no_main]

use libfuzzer_sys::fuzz_target;

#[allow(dead_code, reason = "shared with other targets")]
#[path = "../../tests/doors/mod.rs"]
mod doors;

fuzz_target!(|data: &[u8]| doors::picture::check(data));
