//! Renders a frame on the stack, on bare libc: no std, no allocator. Exits with 0 if every sample was drawn.
#![no_std]
#![no_main]

use core::panic::PanicInfo;
use pmcip_core::allocate::{Mixture, allocate};

#[link(name = "c")]
unsafe extern "C" {}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    loop {}
}

/// The precompiled `core` names it in its unwinding tables; with `panic = "abort"` nobody calls it.
#[unsafe(no_mangle)]
pub extern "C" fn rust_eh_personality() {}

/// What the C runtime calls.
#[unsafe(no_mangle)]
pub extern "C" fn main() -> i32 {
    let (mut target, mut planned) = ([1.0; 64], [0; 64]);
    let mix = Mixture { samples: 1000, floor: 0.25, epsilon: 0.01 };
    match allocate(&mut target, &mut planned, mix, 7) {
        Ok(()) if planned.iter().sum::<u32>() == 1000 => 0,
        _ => 1,
    }
}
