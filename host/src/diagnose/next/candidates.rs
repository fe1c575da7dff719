//! Recordings that may tell mechanisms apart: another speed, the other direction, a ramp, a run-down, a longer one.

use std::f64::consts::TAU;

use crate::diagnose::bench::Bench;
use crate::twin::{Drive, Duration, Step, Twin};

/// Edges that a simulated recording has at the most, and turns at the least.
const EDGES_MOST: f64 = 20_000.0;
const TURNS_LEAST: f64 = 8.0;
/// Edges that a longer recording may have.
const LONG_MOST: f64 = 60_000.0;
/// How much more it must show to be worth more effort than another speed.
const EFFORT: f64 = 2.0;

/// A recording that could be made.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// What to do, as in "20 s at 300 r/min".
    pub text: String,
    /// How the rig is driven.
    pub drive: Drive,
    /// For how long.
    pub duration: Duration,
    /// What it takes, another speed being 1.
    pub effort: f64,
}

/// Candidates for a rig that was recorded like this.
#[must_use]
pub fn candidates(twin: &Twin, bench: &Bench) -> Vec<Candidate> {
    let seen = &bench.seen;
    let usual = rounded(seen.mean_speed() * 60.0 / TAU);
    let forward = seen.speeds.iter().filter(|speed| **speed > 0.0).count();
    let way = if 2 * forward < seen.len() { -1.0 } else { 1.0 };
    let both = 10 * forward.min(seen.len() - forward) > seen.len();
    let constant = matches!(twin.drive, Drive::Constant { .. } | Drive::SpeedLoop { .. });
    let mut all = Vec::new();
    let factors: &[f64] = if constant {
        &[0.5, 2.0]
    } else {
        &[1.0, 0.5, 2.0]
    };
    for factor in factors {
        let r_min = rounded(usual * factor);
        let seconds = length(bench, r_min);
        all.push(Candidate {
            text: format!("{seconds} s at {} r/min", way * r_min),
            drive: at_speed(&twin.drive, way * r_min),
            duration: Duration::Seconds(seconds),
            effort: 1.0,
        });
    }
    // One channel does not show a direction.
    if !both && seen.classes >= 4 {
        let seconds = length(bench, usual);
        all.push(Candidate {
            text: format!(
                "{seconds} s in the other direction, at {} r/min",
                -way * usual
            ),
            drive: at_speed(&twin.drive, -way * usual),
            duration: Duration::Seconds(seconds),
            effort: 1.0,
        });
    }
    if matches!(twin.drive, Drive::Constant { .. }) {
        all.extend(changing(twin, bench, usual, way));
    }
    let long = rounded(4.0 * seen.seconds());
    if 4 * seen.len() <= LONG_MOST as usize {
        all.push(Candidate {
            text: format!("one like this and four times as long, {long} s"),
            drive: twin.drive.clone(),
            duration: Duration::Seconds(long),
            effort: EFFORT,
        });
    }
    all
}

/// Recordings in which the speed changes: with nothing that ties two recordings' angles, one that holds many speeds.
fn changing(twin: &Twin, bench: &Bench, usual: f64, way: f64) -> Vec<Candidate> {
    let (low, high) = (rounded(0.5 * usual), rounded(2.0 * usual));
    let seconds = length(bench, rounded(1.25 * usual));
    let ramp = Candidate {
        text: format!(
            "{seconds} s with the speed going evenly from {} to {} r/min",
            way * low,
            way * high
        ),
        drive: Drive::Ramp {
            from_r_min: way * low,
            to_r_min: way * high,
            over_s: seconds,
        },
        duration: Duration::Seconds(seconds),
        effort: EFFORT,
    };
    let half = rounded(0.5 * length(bench, usual));
    let steps = Candidate {
        text: format!(
            "{} s, the first half at {} and the second at {} r/min",
            2.0 * half,
            way * low,
            way * high
        ),
        drive: Drive::Steps(vec![
            Step {
                t_s: 0.0,
                r_min: way * low,
            },
            Step {
                t_s: half,
                r_min: way * high,
            },
        ]),
        duration: Duration::Seconds(2.0 * half),
        effort: EFFORT,
    };
    let mut all = vec![ramp, steps];
    all.extend(run_down(twin, bench, usual, way));
    all
}

/// The drive off, from the usual speed down to a third of it.
fn run_down(twin: &Twin, bench: &Bench, usual: f64, way: f64) -> Option<Candidate> {
    let (shaft, speed) = (&twin.shaft, usual * TAU / 60.0);
    let braking = shaft.viscous_n_m_s * speed + twin.friction_n_m(speed);
    let falls_s = speed * shaft.inertia_kg_m2 / braking;
    let off_s = rounded(3.0 * TAU / speed);
    let seconds = rounded(off_s + 0.7 * falls_s);
    let edges = seconds * 0.7 * speed / TAU * bench.seen.edges as f64;
    let turns = edges / bench.seen.edges as f64;
    (turns > TURNS_LEAST && edges < EDGES_MOST).then(|| Candidate {
        text: format!(
            "{seconds} s of a run-down, drive off after {off_s} s at {} r/min",
            way * usual
        ),
        drive: Drive::RunDown {
            r_min: way * usual,
            off_s,
        },
        duration: Duration::Seconds(seconds),
        effort: EFFORT,
    })
}

/// As long as the recording that there is, unless that is too few turns or more edges than it takes, s.
fn length(bench: &Bench, r_min: f64) -> f64 {
    let turn_s = 60.0 / r_min;
    let least = TURNS_LEAST * turn_s;
    let most = (EDGES_MOST / bench.seen.edges as f64).max(TURNS_LEAST) * turn_s;
    rounded(bench.seen.seconds().clamp(least, most))
}

/// The same kind of drive at another speed.
fn at_speed(drive: &Drive, r_min: f64) -> Drive {
    match drive.clone() {
        Drive::SpeedLoop {
            f_hz,
            bandwidth_hz,
            kp_n_m_s,
            ki_n_m,
            limit_n_m,
            ..
        } => Drive::SpeedLoop {
            r_min,
            f_hz,
            bandwidth_hz,
            kp_n_m_s,
            ki_n_m,
            timeout_s: None,
            limit_n_m,
        },
        _ => Drive::Constant { r_min },
    }
}

/// To two digits, as one would ask for it.
fn rounded(value: f64) -> f64 {
    if value.is_nan() || value <= 0.0 {
        return value;
    }
    // Through text, so that it prints as short as it is.
    format!("{value:.1e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_as_one_would_ask_for_them() {
        for (value, short) in [(598.7, 600.0), (0.012_34, 0.012), (1.26, 1.3), (44.0, 44.0)] {
            assert_eq!(rounded(value), short);
        }
    }
}
