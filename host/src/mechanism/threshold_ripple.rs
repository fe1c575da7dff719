//! `threshold_ripple`: pick-up on the comparator's level.
//!
//! Mains or PWM moves the level by dL; the signal, of slope dV/dtheta, then meets it a = dL / (dV/dtheta) later where it rises and
//! earlier where it falls:
//! `e = -+ a sin(2 pi f t + phi): - on rising edges, + on falling ones`
//! Linear in cos and sin; f is searched for in the spectrum of rises against falls. Simulated in `sim/shift.rs`.
//!
//! Source: a threshold crossing moves by the level's change over the signal's slope (P. Horowitz, W. Hill, The Art of Electronics,
//! comparators).

use super::card::{ERROR_RAD, FREQUENCIES_HZ};
use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Its card.
pub const CARD: Card = Card {
    title: "pick-up on the comparator's level",
    physics: "Mains or PWM is picked up by the comparator's level: a level that is higher is met later by a rising signal and earlier by \
              a falling one.",
    equation: "e = -+ a sin(2 pi f t + phi): - on rising edges, + on falling ones",
    source: "a threshold crossing moves by the level's change over the signal's slope (P. Horowitz, W. Hill, The Art of Electronics, \
             comparators)",
    twin: "threshold_ripple",
    parameters: &[
        Quantity::new("f_hz", "Hz", FREQUENCIES_HZ, "f, its frequency"),
        Quantity::new("angle_rad", "rad", [0.0, ERROR_RAD], "a, its amplitude"),
        Quantity::phase("phi, its phase at the recording's time 0"),
    ],
    locked_to: &[LockedTo::Frequency],
    speed_exponent: Some(0),
    edge_classes: EdgeClasses::RiseAgainstFall,
    look_alikes: &[Mechanism::TorqueTone, Mechanism::CaptureLatency],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "A recording at another speed: the frequency stays, and rises and falls move against each other; a torque tone moves \
                   both alike.",
};
