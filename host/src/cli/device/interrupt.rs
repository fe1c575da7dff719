//! Ctrl-C ends what runs in good order; a second one ends it at once.

use std::process;
use std::sync::atomic::{AtomicBool, Ordering};

static ASKED: AtomicBool = AtomicBool::new(false);

/// Whether a first Ctrl-C is waited for; else it ends the process.
static CAUGHT: AtomicBool = AtomicBool::new(false);

/// Exit code of a process that Ctrl-C has ended, as shells have it.
const INTERRUPTED: i32 = 130;

/// Takes Ctrl-C from now on. Where the system does not let it, Ctrl-C ends the process as ever.
pub(super) fn catch() {
    CAUGHT.store(true, Ordering::Relaxed);
    let _ = ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::Relaxed) || !CAUGHT.load(Ordering::Relaxed) {
            process::exit(INTERRUPTED);
        }
    });
}

/// From now on Ctrl-C ends the process at once: nothing is left to be put in order.
pub(super) fn release() {
    CAUGHT.store(false, Ordering::Relaxed);
}

/// Whether the user wants it to end.
pub(super) fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
