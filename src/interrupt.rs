//! Ctrl-C: runs stop after the step in work and write what they have.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::failure::exit_code;

static REQUESTED: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// What a run says of itself that was stopped this way.
pub const MESSAGE: &str = "interrupted";

/// Makes Ctrl-C a request instead of the end of the process; a second one is the end. Where the system does not allow that, it
/// stays the end.
pub fn listen() {
    let requested = REQUESTED.get_or_init(Arc::default);
    // In this order: the first signal finds the flag down, and raises it.
    let second =
        flag::register_conditional_shutdown(SIGINT, i32::from(exit_code::INTERRUPTED), Arc::clone(requested));
    if second.is_ok() {
        let _ = flag::register(SIGINT, Arc::clone(requested));
    }
}

/// Makes a termination the same request: for what ends in no other way.
///
/// # Errors
/// Those of the system.
pub fn listen_to_termination() -> io::Result<()> {
    flag::register(SIGTERM, Arc::clone(REQUESTED.get_or_init(Arc::default))).map(|_| ())
}

/// Whether runs should stop.
pub fn requested() -> bool {
    REQUESTED.get().is_some_and(|requested| requested.load(Ordering::Relaxed))
}
