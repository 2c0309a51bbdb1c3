//! Being asked to end: by Ctrl-C, by a job scheduler.

use super::common::{Failure, failed};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Whether the program has been asked to end. A second time it ends at once.
pub struct Signals {
    caught: Arc<AtomicBool>,
    signal: Arc<AtomicUsize>,
}

impl Signals {
    /// From now on the first SIGINT or SIGTERM is caught, if the system lets it be.
    pub fn catch() -> Signals {
        let signals = Signals { caught: Arc::default(), signal: Arc::default() };
        for signal in [SIGINT, SIGTERM] {
            // Where it cannot be caught it ends the program, as without this.
            let _ = flag::register_conditional_shutdown(
                signal,
                code(signal as usize).into(),
                signals.caught.clone(),
            )
            .and_then(|_| flag::register_usize(signal, signals.signal.clone(), signal as usize))
            .and_then(|_| flag::register(signal, signals.caught.clone()));
        }
        signals
    }

    /// Set once a signal has been caught.
    pub fn caught(&self) -> &AtomicBool {
        &self.caught
    }

    /// The end of a program that has been asked to end, which left things as `message` says.
    pub fn end(&self, message: String) -> Failure {
        Failure { code: code(self.signal.load(Ordering::Relaxed)), ..failed(message) }
    }
}

/// The exit code by which shells tell of a signal.
fn code(signal: usize) -> u8 {
    128 + signal as u8
}
