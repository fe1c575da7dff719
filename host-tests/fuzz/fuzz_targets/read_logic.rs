//! Any bytes, read as a logic analyser's CSV.
#![no_main]

use libfuzzer_sys::fuzz_target;
use quadcal_fuzz::read;
use quadcal_host::recording::{Format, ListKind};

fuzz_target!(|bytes: &[u8]| read(bytes, Some(Format::Logic), ListKind::Auto));
