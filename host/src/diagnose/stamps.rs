//! Stamps noisier than the twin declares: white jitter, or a one-sided latency, which is skewed. Or less noisy than it declares.

use std::collections::BTreeMap;

use super::filter::Noise;
use super::model::{Board, Fit};
use super::noise::{self, Free};
use super::{agreement, bench};
use crate::diagnose::diagnosis::{Evidence, Finding, Parameter, Place, RunnerUp};
use crate::mechanism::Mechanism;
use crate::report::si;

/// Twice the logarithm of a likelihood ratio from which on stamps are worse than declared.
const SURE: f64 = 25.0;
/// Share of the variance that edges before foretell, up to which stamps are judged, and how many times as much they have to differ by.
const LEFT: f64 = 0.03;
const MORE: f64 = 4.0;
/// Square of an innovation cubed, of normal noise.
const CUBED: f64 = 15.0;

/// Jitter or latency on top of what all twins declare, or less of what they do; none where one says nothing of its noise.
#[must_use]
pub fn find(board: &Board, fit: &Fit) -> Option<Finding> {
    let says = |bench: &bench::Bench| bench.twin.noise.is_some() || bench.twin.timer.jitter_s > 0.0;
    // Where something is left, or noise has levels, its size says nothing of the stamps.
    let level = |bench: &bench::Bench| bench.weights.iter().all(|weight| *weight == 1.0);
    let judged = board.pattern.is_none() && board.benches.iter().all(level);
    if !judged || !board.benches.iter().all(says) {
        return None;
    }
    // A latency is told by its tails, which are of the noise here.
    let plain = board.in_plain_noise();
    // How the torque pushes between edges bears on what is left for the stamps: what is said holds either way.
    let held = plain.in_held_noise();
    let mut each: Vec<(Board, Fit, f64)> = held
        .into_iter()
        .chain([plain])
        .map(|board| board.at_its_noise(&fit.model))
        .collect();
    each.sort_by(|a, b| a.2.total_cmp(&b.2));
    let found: Option<Vec<Finding>> = each
        .iter()
        .map(|(board, fit, _)| told(board, fit))
        .collect();
    found?.into_iter().next()
}

/// The same in the noise of a board.
fn told(board: &Board, fit: &Fit) -> Option<Finding> {
    let left = if agreement::is_white(board, fit) {
        0.0
    } else {
        agreement::correlated(board, &agreement::rests(board, fit))
    };
    if left > LEFT {
        return None;
    }
    let first = board.benches.first()?;
    let tick2 = first.record.tick_s.powi(2) / 12.0;
    let late = first
        .twin
        .capture_latency
        .and_then(|latency| latency.mean_s)
        .unwrap_or(0.0);
    let declared2 = tick2 + first.twin.timer.jitter_s.powi(2) + late * late;
    let rest = board.rest(&fit.model);
    let rests = bench::rests(&board.benches, &rest);
    let fitted = |stamp_s: f64, stamp: bool| {
        let start = Noise {
            stamp_s,
            ..board.noise
        };
        noise::fit(
            &rests,
            tick2.sqrt(),
            start,
            Free {
                torque: true,
                drift: false,
                stamp,
                ..board.free
            },
        )
    };
    let (_, given) = fitted(declared2.sqrt(), false);
    let (best, free) = fitted(board.noise.stamp_s, true);
    let gain = given - free;
    if gain < SURE {
        return None;
    }
    let added2 = best.stamp_s * best.stamp_s - declared2;
    // What is left may be as much of it.
    if added2.abs() < MORE * left * declared2 {
        return None;
    }
    // Curvature of the likelihood over the stamp's logarithm.
    let cost = |factor: f64| {
        noise::fit(
            &rests,
            0.0,
            Noise {
                stamp_s: best.stamp_s * factor,
                ..best
            },
            Free {
                torque: false,
                drift: false,
                stamp: false,
                ..board.free
            },
        )
        .1
    };
    let by: f64 = 0.02;
    let curve = (cost(1.0 + by) + cost(1.0 - by) - 2.0 * cost(1.0)) / (by * by);
    let relative = if curve > 0.0 {
        (2.0 / curve).sqrt()
    } else {
        0.1
    };
    let evidence = |runner_up| Evidence {
        delta_bic: gain - (board.edges() as f64).ln(),
        p_value: (-0.5 * gain).exp(),
        held_out_rms_ratio: None,
        runner_up,
    };
    if added2 < 0.0 {
        // The larger part of what is declared is what there is less of.
        let jitter2 = first.twin.timer.jitter_s.powi(2);
        let of_latency = late * late > jitter2;
        let (mechanism, path, name, declared, other2) = if of_latency {
            (
                Mechanism::CaptureLatency,
                "capture_latency.mean_s",
                "mean_s",
                late,
                jitter2,
            )
        } else {
            (
                Mechanism::TimestampJitter,
                "timer.jitter_s",
                "jitter_s",
                jitter2.sqrt(),
                late * late,
            )
        };
        let value2 = (best.stamp_s.powi(2) - tick2 - other2).max(0.0);
        let by2 = 2.0 * 1.96 * relative * best.stamp_s.powi(2);
        let ends = [value2 - by2, value2 + by2].map(|end| end.max(0.0).sqrt());
        let text = format!(
            "{path}: {} declared, {} measured, {} to {}",
            si(declared, "s"),
            si(value2.sqrt(), "s"),
            si(ends[0], "s"),
            si(ends[1], "s")
        );
        let parameter = Parameter {
            value: value2.sqrt(),
            unit: "s".to_owned(),
            ci95: Some(ends),
        };
        return Some(Finding {
            mechanism,
            text,
            confidence: 1.0 - (-0.5 * gain).exp(),
            parameters: BTreeMap::from([(name.to_owned(), parameter)]),
            place: Place {
                speed_exponent: Some(1.0),
                ..Place::default()
            },
            evidence: evidence(None),
            look_alikes: Vec::new(),
            next_recording: None,
        });
    }
    // Late captures are behind: their cube has a sign.
    let (mut sum, mut square) = (0.0, 0.0);
    let mut from = 0;
    for bench in &board.benches {
        for at in 0..bench.record.len() {
            let size = (bench.course.speed[at] * bench.scales[at] * added2.sqrt()).powi(3);
            sum -= size * fit.left[from + at].powi(3);
            square += size * size;
        }
        from += bench.record.len();
    }
    // In deviations: what is seen, and what a latency of this size would show.
    let (seen, expected) = (sum / (CUBED * square).sqrt(), 2.0 * (square / CUBED).sqrt());
    let late = seen > 0.5 * expected;
    let apart = (2.0 * seen - expected).abs() * expected;
    let (mechanism, other) = if late {
        (Mechanism::CaptureLatency, Mechanism::TimestampJitter)
    } else {
        (Mechanism::TimestampJitter, Mechanism::CaptureLatency)
    };
    let (name, value) = if late {
        ("mean_s", added2.sqrt())
    } else {
        (
            "jitter_s",
            (best.stamp_s.powi(2) - tick2).max(added2).sqrt(),
        )
    };
    let error = relative * best.stamp_s * best.stamp_s / value;
    let text = if late {
        format!(
            "every capture late by an exponential latency of mean {}: skewed, not only spread",
            si(value, "s")
        )
    } else {
        format!(
            "stamps spread by {} RMS, {} more than declared",
            si(value, "s"),
            si(added2.sqrt(), "s")
        )
    };
    let parameter = Parameter {
        value,
        unit: "s".to_owned(),
        ci95: Some([value - 1.96 * error, value + 1.96 * error]),
    };
    Some(Finding {
        mechanism,
        text,
        confidence: 1.0 / (1.0 + (-0.5 * apart).exp()),
        parameters: BTreeMap::from([(name.to_owned(), parameter)]),
        place: Place {
            speed_exponent: Some(1.0),
            ..Place::default()
        },
        evidence: evidence(Some(RunnerUp {
            mechanism: other,
            delta_bic: apart,
        })),
        look_alikes: if apart < 6.0 { vec![other] } else { Vec::new() },
        next_recording: None,
    })
}
