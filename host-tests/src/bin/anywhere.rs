//! Prints how well the core calibrates at any speed, beside the bound: `cargo run --release -p quadcal-host-tests --bin anywhere`.
#![forbid(unsafe_code)]
#![allow(clippy::cast_precision_loss)]

use anyhow::{Context, Result, ensure};
use clap::Parser;
use quadcal_host_tests::accuracy::{distance, rms};
use quadcal_host_tests::anywhere::{
    ByOrder, Disturbance, Disturbed, GivenGains, Judged, Rig, RunDown, Scenario, Share, Verdicts,
};
use quadcal_host_tests::bound::{LockedTorque, bound, usual_points};

/// RMS error over all edges and seeds, rad; order 1 alone is most of it, so a few dozen seeds are needed for two digits.
#[derive(Parser)]
struct Options {
    /// Lines of the disc.
    #[arg(long, default_value_t = 2500)]
    lines: u32,
    /// Seeds a row.
    #[arg(long, default_value_t = 200)]
    seeds: u64,
    /// First seed.
    #[arg(long, default_value_t = 1)]
    first: u64,
    /// Rows to print, by a part of their names.
    #[arg(long)]
    only: Option<String>,
    /// Fail where a row misses its target.
    #[arg(long)]
    check: bool,
}

impl Options {
    /// Whether the row of a name is to be printed.
    fn asks_for(&self, name: &str) -> bool {
        self.only.as_ref().is_none_or(|part| name.contains(part))
    }
}

/// A row: how the rig is driven, what is said of a loop, and what is to be reached.
struct Row {
    name: &'static str,
    scenario: Scenario,
    /// Gains of a seed.
    gains: fn(u64) -> GivenGains,
    /// Share of the RMS to be removed, and times the bound that may be left.
    removed: Option<f64>,
    over_bound: Option<f64>,
}

fn exact(_: u64) -> GivenGains {
    GivenGains::EXACT
}

/// Gains off by up to 10 % either way, drawn from the seed.
fn ten_percent(seed: u64) -> GivenGains {
    let part = |salt: u64| {
        let mixed = (seed ^ salt).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40;
        0.2 * mixed as f64 / f64::from(1 << 24) - 0.1
    };
    GivenGains {
        kp: 1.0 + part(0x5bd1),
        ki: 1.0 + part(0x27d4_0000),
        within: 0.1,
    }
}

const ROWS: [Row; 6] = [
    row(
        "15 and 600 r/min, cogging",
        Scenario::TwoSpeeds,
        exact,
        Some(0.99),
        Some(1.15),
    ),
    row(
        "ramp 15 to 1500 r/min, cogging",
        Scenario::Ramp,
        exact,
        Some(0.98),
        Some(1.3),
    ),
    row("15 r/min", Scenario::OneSpeed, exact, None, Some(1.15)),
    row(
        "15 r/min, cogging",
        Scenario::OneSpeedCogging,
        exact,
        None,
        Some(1.15),
    ),
    row(
        "speed loop, gains exact",
        Scenario::SpeedLoop,
        exact,
        Some(0.97),
        None,
    ),
    row(
        "speed loop, gains within 10 %",
        Scenario::SpeedLoop,
        ten_percent,
        Some(0.90),
        None,
    ),
];

const fn row(
    name: &'static str,
    scenario: Scenario,
    gains: fn(u64) -> GivenGains,
    removed: Option<f64>,
    over_bound: Option<f64>,
) -> Row {
    Row {
        name,
        scenario,
        gains,
        removed,
        over_bound,
    }
}

fn main() -> Result<()> {
    let options = Options::parse();
    println!(
        "| scenario | raw | quadcal | removed (target) | bound | over bound (target) | own standard error | within 95 % | \
         worst order, after over before |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for row in &ROWS {
        // The loop needs edges more often than coarse discs give them.
        let coarse = options.lines < 2500 && row.scenario == Scenario::SpeedLoop;
        if !coarse && options.asks_for(row.name) {
            print(row, &options)?;
        }
    }
    println!();
    println!(
        "| disturbed | raw | quadcal | removed | undisturbed | own standard error | within 95 % | turns taken, a run | rejected: \
         broken, irregular, change of speed, disagrees | rejected of those hit by a load step | of those after these | of all others |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|");
    for by in Disturbance::ALL {
        if options.asks_for(by.name()) {
            print_disturbed(by, &options)?;
        }
    }
    println!();
    println!(
        "| run-down | raw | polynomial | quadcal | bound | over bound | own standard error | within 95 % | false torques, of runs |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for of in RunDown::ALL {
        if options.asks_for(of.name()) {
            print_run_down(of, &options)?;
        }
    }
    Ok(())
}

fn print_run_down(of: RunDown, options: &Options) -> Result<()> {
    let (mut judged, mut bounds, mut peers) = (Vec::new(), Vec::new(), Vec::new());
    let mut false_torques = 0;
    for seed in options.first..options.first + options.seeds {
        let run = of.run(seed)?;
        let calibration = of.calibrate(&run).with_context(|| format!("seed {seed}"))?;
        judged.push(Judged::of(&calibration, &run));
        bounds.push(of.bound(&run));
        peers.push(distance(&of.polynomial(&run), &run.truth));
        let known = of.torque_orders();
        let torques = calibration.solution.torque_orders();
        false_torques += torques.iter().filter(|t| !known.contains(&t.order)).count();
    }
    let over = |pick: fn(&Judged) -> f64| rms(&judged.iter().map(pick).collect::<Vec<_>>());
    let (raw, left, bound) = (over(|run| run.raw), over(|run| run.left), rms(&bounds));
    let covered = judged.iter().map(|run| run.covered).sum::<f64>() / judged.len() as f64;
    println!(
        "| {} | {raw:.2e} | {:.2e} | **{left:.2e}** | {bound:.2e} | {:.2} | {:.2e} | {:.1} % | {false_torques} of {} |",
        of.name(),
        rms(&peers),
        left / bound,
        over(|run| run.standard_error),
        100.0 * covered,
        options.seeds,
    );
    Ok(())
}

fn print_disturbed(by: Disturbance, options: &Options) -> Result<()> {
    let disturbed = Disturbed {
        by,
        lines: options.lines,
    };
    let rig = disturbed.rig();
    let (mut judged, mut undisturbed) = (Vec::new(), Vec::new());
    let (mut taken, mut reasons) = (0, [0; 4]);
    let mut verdicts = Verdicts::default();
    for seed in options.first..options.first + options.seeds {
        let run = rig.run(seed)?;
        let calibration = rig.calibrate(&run, seed, GivenGains::EXACT)?;
        undisturbed.push(Judged::of(&calibration, &run).left);
        let run = disturbed.run(seed)?;
        let calibration = disturbed
            .calibrate(&run, seed)
            .with_context(|| format!("seed {seed}"))?;
        let totals = &calibration.totals;
        taken += totals.turns;
        let of_run = [
            totals.broken,
            totals.irregular,
            totals.speed_change,
            totals.disagrees,
        ];
        for (sum, count) in reasons.iter_mut().zip(of_run) {
            *sum += count;
        }
        verdicts.add(&calibration, &disturbed.hit(&run, seed));
        judged.push(Judged::of(&calibration, &run));
    }
    let over = |pick: fn(&Judged) -> f64| rms(&judged.iter().map(pick).collect::<Vec<_>>());
    let (raw, left) = (over(|run| run.raw), over(|run| run.left));
    let covered = judged.iter().map(|run| run.covered).sum::<f64>() / judged.len() as f64;
    let runs = options.seeds as f64;
    let share = |share: Share| format!("{} of {}", share.rejected, share.turns);
    println!(
        "| {} | {raw:.2e} | **{left:.2e}** | {:.2} % | {:.2e} | {:.2e} | {:.1} % | {:.1} | {} | {} | {} | {} |",
        by.name(),
        100.0 * (1.0 - left / raw),
        rms(&undisturbed),
        over(|run| run.standard_error),
        100.0 * covered,
        f64::from(taken) / runs,
        reasons.map(|count| count.to_string()).join(", "),
        share(verdicts.hit),
        share(verdicts.after),
        share(verdicts.spared),
    );
    Ok(())
}

fn print(row: &Row, options: &Options) -> Result<()> {
    let rig = Rig {
        scenario: row.scenario,
        lines: options.lines,
    };
    let torque = match row.scenario {
        Scenario::OneSpeed => LockedTorque::None,
        Scenario::TwoSpeeds | Scenario::SpeedLoop => LockedTorque::Every,
        Scenario::Ramp | Scenario::OneSpeedCogging => LockedTorque::Cogging,
    };
    let ideal = bound(rig, torque, usual_points(row.scenario));
    let mut judged = Vec::new();
    let mut bounds = Vec::new();
    let mut by_order = ByOrder::default();
    for seed in options.first..options.first + options.seeds {
        let run = rig.run(seed)?;
        let calibration = rig
            .calibrate(&run, seed, (row.gains)(seed))
            .with_context(|| format!("seed {seed}"))?;
        bounds.push(ideal.rms_left_alone(&run.truth));
        by_order.add(&calibration, &run);
        judged.push(Judged::of(&calibration, &run));
    }
    let worst = by_order.worst().context("no seeds")?;
    let over = |pick: fn(&Judged) -> f64| rms(&judged.iter().map(pick).collect::<Vec<_>>());
    let (raw, left, bound) = (over(|run| run.raw), over(|run| run.left), rms(&bounds));
    let removed = 1.0 - left / raw;
    let covered = judged.iter().map(|run| run.covered).sum::<f64>() / judged.len() as f64;
    let target = |target: Option<f64>, text: fn(f64) -> String| target.map_or("-".into(), text);
    println!(
        "| {} | {raw:.2e} | **{left:.2e}** | {:.2} % ({}) | {bound:.2e} | {:.2} ({}) | {:.2e} | {:.1} % | {:.2} (order {}) |",
        row.name,
        100.0 * removed,
        target(row.removed, |share| format!("{:.0} %", 100.0 * share)),
        left / bound,
        target(row.over_bound, |times| format!("{times}")),
        over(|run| run.standard_error),
        100.0 * covered,
        worst.ratio,
        worst.order,
    );
    if options.check {
        ensure!(
            row.removed.is_none_or(|least| removed >= least),
            "{}: removed {removed}",
            row.name
        );
        ensure!(
            row.over_bound.is_none_or(|most| left <= most * bound),
            "{}: {left} over {bound}",
            row.name
        );
    }
    Ok(())
}
