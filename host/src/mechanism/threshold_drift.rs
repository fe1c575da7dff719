//! `threshold_drift`: the comparator's level drifts.
//!
//! A lamp ages, a head warms up: level or signal settle slowly, and rises and falls move against each other as with
//! [`Mechanism::ThresholdRipple`],
//! `e = -+ a (1 - exp(-(t - t0) / tau)) from t0 on: - on rising edges, + on falling ones`
//! Linear in a; t0 and tau are searched for, from some starts. Simulated in `sim/shift.rs`.
//!
//! Source: first-order lag of a temperature, and the crossing's shift by the level's change over the signal's slope (P. Horowitz,
//! W. Hill, The Art of Electronics, comparators).

use super::card::{ERROR_RAD, INSTANT_S};
use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Its card.
pub const CARD: Card = Card {
    title: "drift of the comparator's level",
    physics: "A lamp ages or a head warms up: the comparator's level, or the signal under it, settles slowly, and rising and falling \
              edges move against each other.",
    equation: "e = -+ a (1 - exp(-(t - t0) / tau)) from t0 on: - on rising edges, + on falling ones",
    source: "first-order lag of a temperature, and the crossing's shift by the level's change over the signal's slope (P. Horowitz, \
             W. Hill, The Art of Electronics, comparators)",
    twin: "threshold_drift",
    parameters: &[
        Quantity::new(
            "angle_rad",
            "rad",
            [-ERROR_RAD, ERROR_RAD],
            "a, where it settles",
        ),
        Quantity::new("tau_s", "s", [1e-6, 1e7], "its time constant"),
        Quantity::new("from_s", "s", INSTANT_S, "t0, when it begins"),
    ],
    locked_to: &[LockedTo::SlowTime],
    speed_exponent: Some(0),
    edge_classes: EdgeClasses::RiseAgainstFall,
    look_alikes: &[
        Mechanism::WidthError,
        Mechanism::EdgeDelay,
        Mechanism::SpeedDrift,
    ],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "A recording from cold that lasts several times as long, at one speed: a drifting level settles, width errors and delays \
                   are there from the start.",
};
