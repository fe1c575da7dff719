//! Any bytes at the port of a device that has just started.
#![no_main]

use libfuzzer_sys::fuzz_target;
use quadcal_host_tests::fuzz_device;

fuzz_target!(|bytes: &[u8]| fuzz_device::once(bytes));
