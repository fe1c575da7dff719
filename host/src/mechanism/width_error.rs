//! `width_error`: the falling edges of a channel lie off its rising ones.
//!
//! Slits and bars of unequal width, or a comparator level off the middle of the signal, make high and low times unequal, for all
//! lines alike:
//! `e(k) = xi_c on falling edges of channel c, 0 on rising ones`
//! at every speed. It is linear in xi, so it is fitted as columns of 0 and 1, one for all channels or one each. Simulated in
//! `sim/disc.rs`.
//!
//! Source: Yin, Guo et al., Chinese Journal of Scientific Instrument, doi 10.19650/j.cnki.cjsi.J2210801, eq. (1).

use super::card::ERROR_RAD;
use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Either way.
const RANGE: [f64; 2] = [-ERROR_RAD, ERROR_RAD];
/// Its numbers where each channel has its own.
const OF_CHANNELS: [&str; 3] = ["width_a_rad", "width_b_rad", "width_c_rad"];

/// Its card.
pub const CARD: Card = Card {
    title: "signal width error",
    physics: "Slits and bars of unequal width, or a comparator level off the middle of the signal, put the falling edges of a channel \
              off its rising ones by the same angle at every line.",
    equation: "e(k) = xi_c on falling edges of channel c, 0 on rising ones",
    source: "Yin, Guo et al., Chinese Journal of Scientific Instrument, doi 10.19650/j.cnki.cjsi.J2210801, eq. (1)",
    twin: "errors",
    parameters: &[
        Quantity::new(
            "width_rad",
            "rad",
            RANGE,
            "xi where all channels have the same",
        ),
        Quantity::new(
            OF_CHANNELS[0],
            "rad",
            RANGE,
            "xi of A, its falling edges against its rising ones",
        ),
        Quantity::new(OF_CHANNELS[1], "rad", RANGE, "xi of B"),
        Quantity::new(OF_CHANNELS[2], "rad", RANGE, "xi of C"),
    ],
    locked_to: &[LockedTo::Angle],
    speed_exponent: Some(0),
    edge_classes: EdgeClasses::RiseAgainstFall,
    look_alikes: &[
        Mechanism::EdgeDelay,
        Mechanism::ThresholdDrift,
        Mechanism::Hysteresis,
    ],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "Two recordings at speeds a factor of two apart: a width error keeps its size in angle, unequal delays of rise and \
                   fall grow with the speed.",
};
