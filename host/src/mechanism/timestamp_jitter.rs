//! `timestamp_jitter`: the capture's own time noise.
//!
//! Every stamp is off by a random time of its own, of standard deviation s, the tick's rounding included:
//! `e = -w tau, tau white with variance s^2`
//! so its angle grows with the speed. It moves no edge in the mean, so it is no pattern: `diagnose/noise/levels.rs` fits its level
//! to the spread of what is left, beside torque noise, and `diagnose/noise/jitter.rs` tells it from latency, which is skewed.
//! Simulated in `sim/capture.rs`.
//!
//! Source: white noise of the stamp, rounding of variance tick^2 / 12 (B. Widrow, I. Kollar, Quantization Noise, 2008), and
//! kinematics, first order in the time.

use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Its card.
pub const CARD: Card = Card {
    title: "time noise of the capture",
    physics: "Every stamp is off by a random time of its own: noise of the comparator, of the clock, of its rounding to ticks. It spreads \
              edges and moves none in the mean.",
    equation: "e = -w tau, tau white with variance s^2",
    source: "white noise of the stamp, rounding of variance tick^2 / 12 (B. Widrow, I. Kollar, Quantization Noise, 2008), and \
             kinematics, first order in the time",
    twin: "timer.jitter_s",
    parameters: &[Quantity::new(
        "jitter_s",
        "s",
        [0.0, 1e-2],
        "s, RMS, with what the twin declares",
    )],
    locked_to: &[LockedTo::Nothing],
    speed_exponent: Some(1),
    edge_classes: EdgeClasses::Alike,
    look_alikes: &[Mechanism::CaptureLatency],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "A longer recording: late captures are skewed or come at a task's rate, jitter is symmetric and white. Another speed \
                   tells both from noise of the angle.",
};
