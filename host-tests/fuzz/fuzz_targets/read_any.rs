//! Any bytes, in the format they look like.
#![no_main]

use libfuzzer_sys::fuzz_target;
use quadcal_fuzz::read;
use quadcal_host::recording::ListKind;

fuzz_target!(|bytes: &[u8]| read(bytes, None, ListKind::Auto));
