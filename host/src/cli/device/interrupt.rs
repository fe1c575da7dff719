//! Ctrl-C ends what runs in good order; a second one ends it at once.

use std::process;
use std::sync::atomic::{AtomicBool, Ordering};

static ASKED: AtomicBool = AtomicBool::new(false);

/// Exit code after a second Ctrl-C, as shells have it.
const INTERRUPTED: i32 = 130;

/// Takes Ctrl-C from now on. Where the system does not let it, Ctrl-C ends the process as ever.
pub(super) fn catch() {
    let _ = ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::Relaxed) {
            process::exit(INTERRUPTED);
        }
    });
}

/// Whether the user wants it to end.
pub(super) fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
