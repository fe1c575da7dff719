//! Bits flipped and random bytes: `cargo run --release -p quadcal-host-tests --bin slot-check -- [--tries N] [--edges N]`.
#![forbid(unsafe_code)]

use anyhow::ensure;
use clap::Parser;
use quadcal_host_tests::slot_check::{EDGES, Noise, flips, noise};

/// Checks slots that must not be taken for valid; fails when one is.
#[derive(Parser)]
struct Options {
    /// Slots of random bytes of each kind.
    #[arg(long, default_value_t = 10_000_000)]
    tries: u64,
    /// Edges of the slots of random bytes; else any number up to 10,000.
    #[arg(long)]
    edges: Option<u32>,
    /// Decides the random bytes.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn main() -> anyhow::Result<()> {
    let options = Options::parse();
    let wrong = |error| anyhow::anyhow!("{error:?}");
    let flipped = flips(EDGES, 1).map_err(wrong)?;
    println!("every bit of a slot of {EDGES} edges flipped: {flipped}");
    let mut valid = flipped.valid;
    for (kind, name) in [
        (Noise::All, "random bytes"),
        (Noise::BehindHeader, "random bytes behind a right header"),
    ] {
        let tally = noise(kind, options.tries, options.edges, options.seed).map_err(wrong)?;
        println!("{name}: {tally}");
        valid += tally.valid;
    }
    ensure!(valid == 0, "{valid} damaged slots were taken for valid");
    Ok(())
}
