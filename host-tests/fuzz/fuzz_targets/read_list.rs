//! Any bytes, read as a list of times, of intervals, and of whichever it looks like.
#![no_main]

use libfuzzer_sys::fuzz_target;
use quadcal_fuzz::read;
use quadcal_host::recording::{Format, ListKind};

fuzz_target!(|bytes: &[u8]| {
    for kind in [ListKind::Auto, ListKind::Intervals, ListKind::Times] {
        read(bytes, Some(Format::List), kind);
    }
});
