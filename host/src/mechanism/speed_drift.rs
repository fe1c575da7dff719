//! `speed_drift`: the drive's speed changes slowly.
//!
//! A motor warms up, a supply sags: the speed that an open-loop drive asks for grows by a share r of it every second, or settles at a
//! share f more,
//! `w*(t) = w0(t) (1 + r t), or w0(t) (1 + f (1 - exp(-t / tau))) where it settles`
//! and the drive pushes what the shaft needs to follow, J dw/dt and damping times what it asks for on top. Linear in r and f. Simulated
//! in `sim/profile.rs`.
//!
//! Source: first order of a slow change of the drive's speed in time, the first-order lag of a temperature, and Newton's law for the
//! shaft.

use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Its card.
pub const CARD: Card = Card {
    title: "slow change of the drive's speed",
    physics: "A motor warms up, a supply sags: the speed that an open-loop drive asks for changes by a small share of it every second.",
    equation: "w*(t) = w0(t) (1 + r t), or w0(t) (1 + f (1 - exp(-t / tau))) where it settles",
    source: "first order of a slow change of the drive's speed in time, the first-order lag of a temperature, and Newton's law for the \
             shaft",
    twin: "speed_drift",
    parameters: &[
        Quantity::new(
            "fraction_per_s",
            "1/s",
            [-10.0, 10.0],
            "r, change over the speed and second, where it goes on evenly",
        ),
        Quantity::new(
            "fraction",
            "1",
            [-0.9, 0.9],
            "f, change over the speed in the end, where it settles",
        ),
        Quantity::new(
            "tau_s",
            "s",
            [1e-3, 1e7],
            "tau, its time constant, where it settles",
        ),
    ],
    locked_to: &[LockedTo::SlowTime],
    speed_exponent: None,
    edge_classes: EdgeClasses::Alike,
    look_alikes: &[
        Mechanism::Friction,
        Mechanism::LoadStep,
        Mechanism::ThresholdDrift,
    ],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "A recording several times as long at one speed, load disconnected: a drift goes on or settles slowly, a load step comes \
                   at once, a drifting level moves rises against falls.",
};
