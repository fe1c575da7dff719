//! Any bytes, read as a VCD.
#![no_main]

use libfuzzer_sys::fuzz_target;
use quadcal_fuzz::read;
use quadcal_host::recording::{Format, ListKind};

fuzz_target!(|bytes: &[u8]| read(bytes, Some(Format::Vcd), ListKind::Auto));
