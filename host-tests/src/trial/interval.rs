//! Where the true value lies in an interval of a finding.
//!
//! Generator and twin mean the same by a parameter's name, which `blind/tests/conventions` holds recording against recording. Angles
//! count through all turns, from the turn in which the recording begins; friction is what comes on top of the twin's. What differs is
//! converted here, or not counted:
//!
//! - A delay of all edges alike is no more than an offset of the clock, so a finding has differences: `rise_less_fall_s`,
//!   `b.rise_less_fall_s`, `b_less_a_s`.
//! - `timestamp_jitter`: a twin's `jitter_s` is the whole of it; the generator's comes on top of what the twin has, square on square.
//! - Where a torque is found as a run-out, or the other way round, or as one that goes with time and not with angle, its phase is
//!   that of something else: it does not count.
//! - A play found for a hysteresis, or the other way round, has another name for the same angle.
//! - `stick_slip`: a twin's drive damps beside its spring and the generator's does not, so no number of theirs is the same: none counts.
//! - `line_error`: the RMS of the pattern that was drawn counts, not that of the distribution.
//!
//! Phases count modulo 2 pi, and a negative amplitude is a positive one with its phase turned by pi.

use std::f64::consts::{PI, TAU};

use quadcal_host::diagnose::diagnosis::Finding;
use quadcal_host::mechanism::Mechanism;

use super::truth::{Missing, Truth};

/// Amplitudes of what has a phase.
const AMPLITUDES: [&str; 4] = ["amplitude_rad", "torque_n_m", "runout_rad", "angle_rad"];

/// How far the true value of a parameter is above the middle of its 95 % interval, in halves of the interval: from -1 to 1 where the
/// interval holds it. None where it has no interval, or the truth has no such number.
#[must_use]
pub fn off(truth: &Truth, missing: &Missing, finding: &Finding, name: &str) -> Option<f64> {
    let [low, high] = finding.parameters.get(name)?.ci95?;
    let apart = true_value(truth, missing, finding, name)? - f64::midpoint(low, high);
    let apart = match period(missing, name) {
        Some(period) => apart - period * (apart / period).round(),
        None => apart,
    };
    Some(apart / (0.5 * (high - low)))
}

/// The true value of a finding's parameter, in the finding's terms.
fn true_value(truth: &Truth, missing: &Missing, finding: &Finding, name: &str) -> Option<f64> {
    let number = |name: &str| missing.number(name);
    if name == "phase_rad" && phase_of(missing.id) != phase_of(finding.mechanism) {
        return None;
    }
    match missing.id {
        Mechanism::EdgeDelay => {
            let channel = match name.strip_suffix("rise_less_fall_s")? {
                "" => "a.",
                channel => channel,
            };
            Some(number(&format!("{channel}rise_s"))? - number(&format!("{channel}fall_s"))?)
        }
        Mechanism::ChannelSkew => {
            let (one, other) = name.strip_suffix("_s")?.split_once("_less_")?;
            Some(number(&format!("{one}_s"))? - number(&format!("{other}_s"))?)
        }
        Mechanism::TimestampJitter => match name {
            "jitter_s" => Some(number(name)?.hypot(truth.noise.jitter_s)),
            "added_jitter_s" => number("jitter_s"),
            _ => None,
        },
        Mechanism::Hysteresis | Mechanism::Backlash => match name {
            "angle_rad" | "gap_rad" => number("angle_rad").or_else(|| number("gap_rad")),
            _ => None,
        },
        Mechanism::LineError if name == "rms_rad" => {
            number("pattern_rms_rad").or_else(|| number(name))
        }
        Mechanism::StickSlip => None,
        Mechanism::Friction if name == "stribeck_rad_s" => {
            // Without such friction its scale means nothing.
            number(name).filter(|_| number("stribeck_n_m") != Some(0.0))
        }
        _ => {
            let value = number(name)?;
            Some(match (turned(missing, finding), name) {
                (true, "phase_rad") => value + PI,
                (true, amplitude) if AMPLITUDES.contains(&amplitude) => -value,
                _ => value,
            })
        }
    }
}

/// What the phase of a mechanism is of.
#[derive(PartialEq)]
enum PhaseOf {
    /// A torque, by the angle of the shaft.
    Torque,
    /// A torque, by time.
    Tone,
    /// An angle.
    Mark,
}

fn phase_of(mechanism: Mechanism) -> PhaseOf {
    match mechanism {
        Mechanism::TorqueRipple | Mechanism::GearMesh => PhaseOf::Torque,
        Mechanism::TorqueTone => PhaseOf::Tone,
        _ => PhaseOf::Mark,
    }
}

/// Whether a wave is found with the other sign.
fn turned(missing: &Missing, finding: &Finding) -> bool {
    finding.parameters.contains_key("phase_rad")
        && AMPLITUDES.iter().any(|name| {
            let found = finding.parameters.get(*name);
            let pair = found.zip(missing.number(name));
            pair.is_some_and(|(found, truth)| found.value * truth < 0.0)
        })
}

/// What a parameter counts modulo.
fn period(missing: &Missing, name: &str) -> Option<f64> {
    match (missing.id, name) {
        (_, "phase_rad") | (Mechanism::LocalDefect, "angle_rad") => Some(TAU),
        (Mechanism::CaptureLatency, "phase_s") => missing.number("task_hz").map(f64::recip),
        _ => None,
    }
}
