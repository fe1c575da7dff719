//! QEMU killed while it commits: `cargo run --release -p quadcal-host-tests --bin power-cut -- [--kills N] [--others N] [--commanded N]`.
#![forbid(unsafe_code)]

use clap::Parser;
use quadcal_host_tests::power_cut::{self, Act, Command};

/// Kills QEMU at random moments of commit, roll back and erase; after each, the old or the new table must count, whole.
#[derive(Parser)]
struct Options {
    /// Number of kills during commits.
    #[arg(long, default_value_t = 200)]
    kills: u32,
    /// Number of kills during each of roll back and erase.
    #[arg(long, default_value_t = 50)]
    others: u32,
    /// Number of kills during each of commit, roll back and erase by command, over the port.
    #[arg(long, default_value_t = 67)]
    commanded: u32,
    /// Decides the moments.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn main() -> anyhow::Result<()> {
    let options = Options::parse();
    println!("{}", power_cut::run(options.kills, options.seed)?);
    for act in [Act::RollBack, Act::Erase] {
        println!("{}", power_cut::act(act, options.others, options.seed)?);
    }
    for command in Command::ALL {
        println!(
            "{}",
            power_cut::commanded(command, options.commanded, options.seed)?
        );
    }
    Ok(())
}
