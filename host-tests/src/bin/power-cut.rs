//! QEMU killed while it commits: `cargo run --release -p quadcal-host-tests --bin power-cut -- [--kills N] [--seed N]`.
#![forbid(unsafe_code)]

use clap::Parser;
use quadcal_host_tests::power_cut;

/// Kills QEMU at random moments of a commit; after each, the old or the new table must count, whole.
#[derive(Parser)]
struct Options {
    /// Number of kills.
    #[arg(long, default_value_t = 200)]
    kills: u32,
    /// Decides the moments.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn main() -> anyhow::Result<()> {
    let options = Options::parse();
    println!("{}", power_cut::run(options.kills, options.seed)?);
    Ok(())
}
