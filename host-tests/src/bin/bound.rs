//! Prints how good any estimate can be: `cargo run --release -p quadcal-host-tests --bin bound`.
#![forbid(unsafe_code)]

use clap::Parser;
use quadcal_host_tests::anywhere::{Rig, Scenario};
use quadcal_host_tests::bound::{LockedTorque, bound, usual_points};

/// The bound on the RMS error over all edges, rad, and on single orders, for every rig and every assumption on locked torque.
#[derive(Parser)]
struct Options {
    /// Points a turn to solve on; the bound must not depend on it.
    #[arg(long)]
    points: Option<usize>,
}

fn main() {
    let options = Options::parse();
    let shown = [1, 2, 5, 10, 30, 100];
    let heads = shown.map(|order| format!("order {order}"));
    println!(
        "| scenario | lines | locked torque at | RMS | {} |",
        heads.join(" | ")
    );
    println!("|---|---|---|---|{}", "---|".repeat(shown.len()));
    for lines in [2500, 360, 60] {
        for scenario in Scenario::ALL {
            if scenario == Scenario::SpeedLoop && lines < 2500 {
                continue;
            }
            for torque in assumptions(scenario) {
                let points = options.points.unwrap_or(usual_points(scenario));
                let bound = bound(Rig { scenario, lines }, *torque, points);
                let single = shown.map(|order| format!("{:.2e}", bound.orders[order - 1]));
                println!(
                    "| {} | {lines} | {torque:?} | {:.3e} | {} |",
                    scenario.name(),
                    bound.rms(),
                    single.join(" | ")
                );
            }
        }
    }
}

/// One speed can't tell geometry from torque, so there it makes no sense to assume torque at every order.
const fn assumptions(scenario: Scenario) -> &'static [LockedTorque] {
    const ALL: &[LockedTorque] = &[
        LockedTorque::None,
        LockedTorque::Cogging,
        LockedTorque::Every,
    ];
    match scenario {
        Scenario::OneSpeed => ALL.split_at(1).0,
        Scenario::OneSpeedCogging => ALL.split_at(2).0,
        Scenario::TwoSpeeds | Scenario::Ramp | Scenario::SpeedLoop => ALL,
    }
}
