//! Compares ways to calibrate on the same recordings: `cargo run --release -p quadcal-host-tests --bin peers`.
//!
//! Needs python3 with venv and pip. The time of the Python package grows with the cube of turns times edges: minutes a row.
#![forbid(unsafe_code)]
#![allow(clippy::cast_precision_loss, clippy::cast_possible_truncation)]

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result};
use clap::Parser;
use quadcal_host::calibrate::CalibrateError;
use quadcal_host::sim::Simulation;
use quadcal_host_tests::accuracy::{distance, rms, table_rad};
use quadcal_host_tests::anywhere::{self, GivenGains, Recorded, Rig, Run, Scenario};
use quadcal_host_tests::bound::{LockedTorque, bound, usual_points};
use quadcal_host_tests::peer_bladesight::{Bladesight, PUBLISHED_BETA};
use quadcal_host_tests::{paper, peer_average, peer_polynomial};

/// RMS error over all edges and seeds, rad, by every method, and the bound. Of two recordings a method that takes one is given
/// both in turn, and the better result counts.
#[derive(Parser)]
struct Options {
    /// Discs to try, by their lines.
    #[arg(long, num_args = 1.., default_values_t = [60, 360])]
    lines: Vec<u32>,
    /// Only the scenario of this name; by default, all.
    #[arg(long)]
    scenario: Option<String>,
    /// Seeds a row.
    #[arg(long, default_value_t = 4)]
    seeds: u64,
    /// First seed.
    #[arg(long, default_value_t = 1)]
    first: u64,
    /// Precisions among which the package's best is sought, beside the published one.
    #[arg(long, num_args = 1.., default_values_t = [1e6, 1e8, 1e11, 1e12, 1e13])]
    beta: Vec<f64>,
    /// Edges that the package solves at once: the more the better its result, a single turn being far too little; but its memory
    /// grows with the square, its time up to the cube.
    #[arg(long, default_value_t = 4320)]
    at_once: usize,
    /// Turns of a recording, at most, that the package is given.
    #[arg(long, default_value_t = 11)]
    peer_turns: usize,
    /// Leave the Python package out: many seeds take seconds then.
    #[arg(long)]
    without_package: bool,
    /// Compare times in place of errors: the package on turns of 1440 edges up to this many, one precision.
    #[arg(long, conflicts_with = "without_package")]
    time_turns: Option<usize>,
    /// Folder of the Python environment.
    #[arg(long, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/../target/bladesight"))]
    environment: PathBuf,
}

fn main() -> Result<()> {
    let options = Options::parse();
    let peer = if options.without_package {
        None
    } else {
        std::fs::create_dir_all(&options.environment)?;
        Some(Bladesight::install(&options.environment).context("bladesight")?)
    };
    if let Some(peer) = &peer {
        if let Some(turns) = options.time_turns {
            return compare_times(peer, turns, options.first);
        }
        println!(
            "Of the errors of a disc that turns steadily at 600 r/min without noise, bladesight leaves {:.3} %.\n",
            100.0 * left_without_noise(peer)?
        );
    }
    println!(
        "| scenario | lines | raw | paper, closed | average over turns | polynomial in time | bladesight as published | at its best (beta) | quadcal | \
         bound |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for &lines in &options.lines {
        for scenario in Scenario::ALL {
            let wanted = options.scenario.as_deref();
            // The speed loop needs edges more often than these discs give them.
            if scenario != Scenario::SpeedLoop && wanted.is_none_or(|name| name == scenario.name())
            {
                println!("{}", row(peer.as_ref(), &options, Rig { scenario, lines })?);
            }
        }
    }
    Ok(())
}

/// What the package, with its published precision, leaves of a disc's errors where nothing is in its way, a part of them: so its
/// sections are read the right way round.
fn left_without_noise(peer: &Bladesight) -> Result<f64> {
    let rig = Rig {
        scenario: Scenario::TwoSpeeds,
        lines: 60,
    };
    let mut twin = rig.twins(1).pop().context("a rig has recordings")?;
    twin.noise = None;
    twin.ripple.clear();
    let simulation = Simulation::new(&twin)?;
    let truth = simulation.true_errors();
    let times = anywhere::record(simulation).times;
    let edges = truth.len();
    let found = peer.solve(
        &times[..=3 * edges],
        anywhere::CLOCK_HZ,
        edges,
        3,
        &[PUBLISHED_BETA],
    )?;
    let nothing = vec![0.0; edges];
    Ok(distance(&found[0].error, &truth) / distance(&nothing, &truth))
}

/// Errors of one run, RMS over all edges, rad.
struct Errors {
    raw: f64,
    paper: f64,
    average: f64,
    polynomial: f64,
    /// bladesight with each precision, the published one first.
    peer: Vec<f64>,
    ours: Option<f64>,
    bound: f64,
}

fn row(peer: Option<&Bladesight>, options: &Options, rig: Rig) -> Result<String> {
    let mut betas = vec![PUBLISHED_BETA];
    betas.extend(&options.beta);
    let runs = (options.first..options.first + options.seeds)
        .map(|seed| errors(peer, options, rig, seed, &betas))
        .collect::<Result<Vec<_>>>()?;
    let over = |pick: &dyn Fn(&Errors) -> f64| rms(&runs.iter().map(pick).collect::<Vec<_>>());
    let by_beta = (0..betas.len()).map(|i| (over(&|run| run.peer[i]), betas[i]));
    let (best, beta) = by_beta
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .context("no precision")?;
    let ours = if runs.iter().all(|run| run.ours.is_some()) {
        format!("{:.2e}", over(&|run| run.ours.unwrap_or(f64::NAN)))
    } else {
        "refused".into()
    };
    let of_package = if best.is_finite() {
        format!("{:.2e} | {best:.2e} ({beta:.0e})", over(&|run| run.peer[0]))
    } else {
        "- | -".into()
    };
    Ok(format!(
        "| {} | {} | {:.2e} | {:.2e} | {:.2e} | {:.2e} | {of_package} | {ours} | {:.2e} |",
        rig.scenario.name(),
        rig.lines,
        over(&|run| run.raw),
        over(&|run| run.paper),
        over(&|run| run.average),
        over(&|run| run.polynomial),
        over(&|run| run.bound),
    ))
}

fn errors(
    peer: Option<&Bladesight>,
    options: &Options,
    rig: Rig,
    seed: u64,
    betas: &[f64],
) -> Result<Errors> {
    let run = rig.run(seed)?;
    let edges = run.truth.len();
    let off = |error: &[f64]| distance(error, &run.truth);
    let best = |method: &dyn Fn(&[u64]) -> Vec<f64>| {
        let recordings = run.recordings.iter();
        let errors = recordings.map(|r| off(&method(whole_turns(r, edges))));
        errors.fold(f64::INFINITY, f64::min)
    };
    let mut of_peer = vec![f64::INFINITY; betas.len()];
    let peers = peer
        .iter()
        .flat_map(|peer| run.recordings.iter().map(move |r| (peer, r)));
    for (peer, recorded) in peers {
        let times = whole_turns(recorded, edges);
        // The same turns: elsewhere the first one only sets the speed.
        let turns = options.peer_turns.min((times.len() - 1) / edges - 1);
        let times = &times[times.len() - 1 - turns * edges..];
        let block = (options.at_once / edges).max(1);
        let found = peer.solve(times, anywhere::CLOCK_HZ, edges, block, betas)?;
        for (least, found) in of_peer.iter_mut().zip(found) {
            *least = least.min(off(&found.error));
        }
    }
    Ok(Errors {
        raw: rms(&run.truth),
        paper: best(&|times| {
            let turns = (times.len() - 1) / edges - 1;
            paper::estimate(times, rig.lines as usize, turns, true).error
        }),
        average: best(&|times| peer_average::estimate(&times[edges..], edges)),
        polynomial: best(&|times| peer_polynomial::estimate(times, edges)),
        peer: of_peer,
        ours: quadcal(rig, &run, seed).ok().map(|error| off(&error)),
        bound: bound_of(rig, &run.truth),
    })
}

/// Whole turns and one edge more of a recording, from the first index on.
fn whole_turns(recorded: &Recorded, edges: usize) -> &[u64] {
    let turns = (recorded.times.len() - 1) / edges;
    &recorded.times[..=turns * edges]
}

/// quadcal's errors of every edge, rad, from the recordings of a rig together.
fn quadcal(rig: Rig, run: &Run, seed: u64) -> Result<Vec<f64>, CalibrateError> {
    let calibration = rig.calibrate(run, seed, GivenGains::EXACT)?;
    Ok(table_rad(&calibration.solution))
}

/// What an ideal estimator comes to that does not know at which orders there is torque, but at one speed, where it knows that and
/// leaves these orders alone.
fn bound_of(rig: Rig, truth: &[f64]) -> f64 {
    let torque = match rig.scenario {
        Scenario::OneSpeed => LockedTorque::None,
        Scenario::OneSpeedCogging => LockedTorque::Cogging,
        Scenario::TwoSpeeds | Scenario::Ramp | Scenario::SpeedLoop => LockedTorque::Every,
    };
    bound(rig, torque, usual_points(rig.scenario)).rms_left_alone(truth)
}

fn compare_times(peer: &Bladesight, most: usize, seed: u64) -> Result<()> {
    let lines = 360;
    let edges = 4 * lines as usize;
    let rig = Rig {
        scenario: Scenario::OneSpeed,
        lines,
    };
    let run = rig.run(seed)?;
    println!("| edges solved at once | bladesight | quadcal, 11 turns |");
    println!("|---|---|---|");
    for turns in 1..=most {
        let start = Instant::now();
        quadcal(rig, &run, seed)?;
        let ours = start.elapsed().as_secs_f64();
        let times = &run.recordings[0].times[..=turns * edges];
        let found = peer.solve(times, anywhere::CLOCK_HZ, edges, turns, &[PUBLISHED_BETA])?;
        println!(
            "| {} | {:.1} s | {:.4} s |",
            turns * edges,
            found[0].seconds,
            ours
        );
    }
    Ok(())
}
