//! `torque_tone`: torque at a fixed frequency.
//!
//! An unbalanced machine on the same frame, or a drive's current ripple, pushes and brakes at its own rate, whatever the shaft does:
//! `J dw/dt = T sin(2 pi f t + phi), so e = -T / (J (2 pi f)^2) sin(2 pi f t + phi)`
//! for a shaft that nothing holds: the same angle at any speed, at a frequency that stays. Nothing ties the times of two recordings, so
//! each has a size and a phase of its own. Simulated in `sim/tone.rs`.
//!
//! Source: Newton's law for the shaft, linear about its mean speed.

use super::card::FREQUENCIES_HZ;
use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Its card.
pub const CARD: Card = Card {
    title: "torque at a fixed frequency",
    physics: "An unbalanced machine on the same frame, or a drive's current ripple, pushes and brakes the shaft at a rate of its own, \
              whatever the shaft does.",
    equation: "J dw/dt = T sin(2 pi f t + phi), so e = -T / (J (2 pi f)^2) sin(2 pi f t + phi)",
    source: "Newton's law for the shaft, linear about its mean speed",
    twin: "torque_tone",
    parameters: &[
        Quantity::new("f_hz", "Hz", FREQUENCIES_HZ, "f, its frequency"),
        Quantity::torque("T, its amplitude"),
        Quantity::phase("phi, its phase at the recording's time 0"),
    ],
    locked_to: &[LockedTo::Frequency],
    speed_exponent: Some(0),
    edge_classes: EdgeClasses::Alike,
    look_alikes: &[
        Mechanism::GearMesh,
        Mechanism::Bearing,
        Mechanism::TorqueRipple,
        Mechanism::TorsionalResonance,
        Mechanism::ThresholdRipple,
        Mechanism::StickSlip,
    ],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "A recording at a speed that differs by a tenth or more: the frequency stays, that of an order moves with the speed.",
};
