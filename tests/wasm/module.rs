//! What a WebAssembly module with a sampler in it exports.
#![no_std]

mod film;

use core::panic::PanicInfo;

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    core::arch::wasm32::unreachable()
}

/// [`film::digest`]; 0 if the core refused something.
#[unsafe(no_mangle)]
pub extern "C" fn digest() -> u64 {
    film::digest().unwrap_or(0)
}
