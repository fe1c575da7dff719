//! `timestamp_jitter`: stamps noisier than the twin declares, or late by an exponential latency, which is noisier and skewed.
//!
//! `jitter_s` of a finding is what comes on top of the declared `timer.jitter_s`: the twin that explains the recording has the root
//! of the sum of both squares. `mean_s` of a latency is the root of the same added variance.

use super::super::board::Board;
use super::latency::{Skew, skew};
use super::levels::Levels;
use super::odds::normal_above;
use super::{NoiseFinding, NoiseParameter};
use crate::mechanism::Mechanism;
use crate::report::si;

/// Twice the log likelihood ratio that a finding needs, and its size in standard errors.
const LEAST_GAIN: f64 = 25.0;
const LEAST_DEVIATIONS: f64 = 5.0;

/// Noise of the stamps on top of the declared.
#[must_use]
pub fn find(board: &Board, levels: &Levels) -> Option<NoiseFinding> {
    let variance = levels.added_s2;
    let deviations = variance / levels.added_error_s2;
    let enough = levels.declared && levels.gain() > LEAST_GAIN && deviations > LEAST_DEVIATIONS;
    if !enough {
        return None;
    }
    let skew = skew(board, levels);
    let size = variance.sqrt();
    let error = 0.5 * levels.added_error_s2 / size;
    let apart = apart(&skew, variance);
    let late = apart > 0.0;
    let (mechanism, other, name) = if late {
        (
            Mechanism::CaptureLatency,
            Mechanism::TimestampJitter,
            "mean_s",
        )
    } else {
        (
            Mechanism::TimestampJitter,
            Mechanism::CaptureLatency,
            "jitter_s",
        )
    };
    let declared = board
        .benches
        .first()
        .map_or(0.0, |bench| bench.declared.unwrap_or(bench.noise).stamp_s);
    let text = if late {
        format!(
            "every capture late by an exponential latency of mean {}: skewed, not only spread",
            si(size, "s")
        )
    } else {
        format!(
            "stamps spread by {} RMS on top of the declared {}",
            si(size, "s"),
            si(declared, "s")
        )
    };
    Some(NoiseFinding {
        mechanism,
        parameters: vec![NoiseParameter {
            name,
            value: size,
            standard_error: error,
        }],
        delta_bic: levels.gain() - (board.edges() as f64).ln(),
        p_value: normal_above(levels.gain().sqrt()),
        text,
        frequencies_hz: Vec::new(),
        times_s: Vec::new(),
        edge_classes: Vec::new(),
        runner_up: Some((other, apart.abs())),
        busy: None,
    })
}

/// By how much an exponential latency explains the third cumulant better than jitter, in twice the log likelihood: above 0 it is late.
fn apart(skew: &Skew, variance: f64) -> f64 {
    let expected = 2.0 * variance.powf(1.5);
    let normal = skew.third_s3 / skew.normal_error_s3;
    // Were it late, the third cumulant would scatter as it does, and be somewhere near what the variance says.
    let error = skew
        .error_s3
        .hypot(0.1 * expected)
        .max(skew.normal_error_s3);
    let late = (skew.third_s3 - expected) / error;
    normal * normal - late * late
}
