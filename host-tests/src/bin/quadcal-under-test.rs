//! The `quadcal` command, built along with these tests so that they can run it.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    quadcal_host::cli::run()
}
