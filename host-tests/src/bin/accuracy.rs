//! Prints the accuracy table: `cargo run --release -p quadcal-host-tests --bin accuracy -- [--seeds N] [--first SEED]`.
#![forbid(unsafe_code)]
#![allow(clippy::cast_precision_loss)]

use std::process::ExitCode;

use clap::Parser;
use quadcal_host_tests::accuracy::{RunErrors, Scenario, median, run};

/// RMS error of every edge against its true angle, in rad, on 11 turns: median over seeds.
///
/// Ends with 1 if a target is missed and --check is given.
#[derive(Parser)]
struct Options {
    /// Seeds a scenario.
    #[arg(long, default_value_t = 5)]
    seeds: u64,
    /// First seed.
    #[arg(long, default_value_t = 1)]
    first: u64,
    /// Print the worst run of every scenario too, and fail where a target is missed.
    #[arg(long)]
    check: bool,
}

fn main() -> ExitCode {
    let options = Options::parse();
    let seeds = options.first..options.first + options.seeds;
    println!(
        "| scenario | raw | as printed | closed over a turn | quadcal | removed (target) | own standard error | fixed point off f64 | \
         xi, p off |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut missed = false;
    let mut worst = Vec::new();
    for scenario in Scenario::ALL {
        let errors: Vec<RunErrors> = seeds
            .clone()
            .map(|seed| run(&scenario.twin(seed)).errors())
            .collect();
        let middle = |pick: &dyn Fn(&RunErrors) -> f64| median(errors.iter().map(pick).collect());
        let removed = middle(&|e| 1.0 - e.ours / e.raw);
        let class = middle(&|e| e.class_error.unwrap_or(f64::NAN));
        let target = scenario.target_removed();
        missed |= target.map_or(middle(&|e| e.table) >= 1e-6, |target| removed < target);
        let percent = |value: f64| format!("{:.1} %", 100.0 * value);
        println!(
            "| {} | {:.2e} | {:.2e} | {:.2e} | **{:.2e}** | {} | {:.2e} | {} | {} |",
            scenario.name(),
            middle(&|e| e.raw),
            middle(&|e| e.printed),
            middle(&|e| e.closed),
            middle(&|e| e.ours),
            target.map_or("table < 1e-6".into(), |target| format!(
                "{} ({:.0} %)",
                percent(removed),
                100.0 * target
            )),
            middle(&|e| e.standard_error),
            target.map_or("-".into(), |_| format!(
                "{:.2} %",
                middle(&|e| 100.0 * e.from_reference / e.standard_error)
            )),
            if class.is_finite() {
                format!("{:.3} %", 100.0 * class)
            } else {
                "-".into()
            },
        );
        worst.push((scenario, errors.iter().map(|e| e.ours).fold(0.0, f64::max)));
    }
    if options.check {
        println!();
        for (scenario, ours) in worst {
            println!(
                "worst of {} runs, {}: {ours:.2e} rad",
                options.seeds,
                scenario.name()
            );
        }
    }
    ExitCode::from(u8::from(missed && options.check))
}
