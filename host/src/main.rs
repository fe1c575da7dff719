//! The `quadcal` command.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    quadcal_host::cli::run()
}
