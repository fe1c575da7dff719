//! Prints the accuracy table: `cargo run --release -p quadcal-host-tests --bin accuracy -- [--seeds N] [--first SEED]`.
#![forbid(unsafe_code)]
#![allow(clippy::cast_precision_loss)]

use clap::Parser;
use quadcal_host_tests::accuracy::{RunErrors, Scenario, median, run};

/// RMS error of every edge against its true angle, in rad, on 11 turns: median over seeds.
#[derive(Parser)]
struct Options {
    /// Seeds a scenario.
    #[arg(long, default_value_t = 5)]
    seeds: u64,
    /// First seed.
    #[arg(long, default_value_t = 1)]
    first: u64,
}

fn main() {
    let options = Options::parse();
    println!(
        "| scenario | raw | as printed | closed over a turn | quadcal | removed | own standard error | fixed point off f64 | xi, p off |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for scenario in Scenario::ALL {
        let errors: Vec<RunErrors> = (options.first..options.first + options.seeds)
            .map(|seed| run(&scenario.twin(seed)).errors())
            .collect();
        let middle = |pick: &dyn Fn(&RunErrors) -> f64| median(errors.iter().map(pick).collect());
        let removed = middle(&|e| 100.0 * (1.0 - e.ours / e.raw));
        let class = middle(&|e| e.class_error.unwrap_or(f64::NAN));
        println!(
            "| {} | {:.3e} | {:.3e} | {:.3e} | {:.3e} | {} | {:.3e} | {:.2} % | {} |",
            scenario.name(),
            middle(&|e| e.raw),
            middle(&|e| e.printed),
            middle(&|e| e.closed),
            middle(&|e| e.ours),
            if removed.is_finite() {
                format!("{removed:.2} %")
            } else {
                "-".into()
            },
            middle(&|e| e.standard_error),
            middle(&|e| 100.0 * e.from_reference / e.standard_error),
            if class.is_finite() {
                format!("{:.4} %", 100.0 * class)
            } else {
                "-".into()
            },
        );
    }
}
