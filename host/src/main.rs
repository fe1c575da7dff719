//! The `quadcal` command.
#![forbid(unsafe_code)]

fn main() {}
