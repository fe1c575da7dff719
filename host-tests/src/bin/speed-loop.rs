//! p
fn main() { quadcal_host_tests::speed_loop::main() }
