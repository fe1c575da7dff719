//! `capture_latency`: captures that come late.
//!
//! Where a program, not hardware, takes the stamp, it is late by the interrupt's latency: an exponential time of mean m, one-sided; or
//! a task blocks it, f times a second for a time b, and edges that fall a time x into that are stamped at its end:
//! `e = -w tau, tau exponential with mean m, or b - x while a task is busy`
//! The first is told from jitter by its skewness (`diagnose/stamps.rs`), the second by stamps that come together at the ends of its
//! busy times, fitted by their likelihood (`diagnose/noise/task.rs`) and then left out (`diagnose/held_up.rs`). Simulated in
//! `sim/latency.rs`.
//!
//! Source: third cumulant 2 m^3 of an exponential time, Edgeworth's series (P. McCullagh, Tensor Methods in Statistics, 1987, ch. 5);
//! A. Schuster's periodogram (Terrestrial Magnetism 3, 1898).

use super::card::DELAY_S;
use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Rates that a task is looked for at, Hz.
pub const TASK_HZ: [f64; 2] = [40.0, 11_000.0];

/// Its card.
pub const CARD: Card = Card {
    title: "late captures",
    physics: "Where a program takes the stamp it waits for its interrupt: for a random time that is never negative, or until a task that \
              blocks it is done, at that task's rate.",
    equation: "e = -w tau, tau exponential with mean m, or b - x while a task is busy",
    source: "third cumulant 2 m^3 of an exponential time, Edgeworth's series (P. McCullagh, Tensor Methods in Statistics, 1987, ch. 5); \
             A. Schuster's periodogram (Terrestrial Magnetism 3, 1898)",
    twin: "capture_latency",
    parameters: &[
        Quantity::new("mean_s", "s", [0.0, DELAY_S], "m, mean of a random latency"),
        Quantity::new("task_hz", "Hz", TASK_HZ, "rate of a task"),
        Quantity::new(
            "busy_s",
            "s",
            [0.0, DELAY_S],
            "b, how long it blocks; 0 where there is no task",
        ),
        Quantity::new(
            "phase_s",
            "s",
            [0.0, 1.0 / TASK_HZ[0]],
            "when it first blocks",
        ),
    ],
    locked_to: &[LockedTo::Frequency, LockedTo::Nothing],
    speed_exponent: Some(1),
    edge_classes: EdgeClasses::Alike,
    look_alikes: &[Mechanism::TimestampJitter, Mechanism::ThresholdRipple],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "A recording with the other tasks of the controller off, or with a hardware capture: latency goes, jitter of the clock stays.",
};
