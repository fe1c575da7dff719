//! `edge_delay`: rising and falling levels are captured with unequal delays.
//!
//! A comparator, an optocoupler or a filter answers a rising level later, or sooner, than a falling one. What is stamped d late is read
//! w d behind, w being the signed speed:
//! `e = -w (d_rise - d_fall) on rising levels, 0 on falling ones`
//! as only the difference shows; or, where the rises of one channel stay with those of the others,
//! `e = w (d_rise - d_fall) on its falling levels, 0 on all others`. Passed in reverse, a mark at which the level rises makes it fall. At one speed that is a width error;
//! it grows with the speed as no width does. Simulated in `sim/signal.rs`.
//!
//! Source: kinematics, first order in the delay: the shaft goes on by w d until the stamp.

use super::card::DELAY_S;
use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Either way.
const RANGE: [f64; 2] = [-DELAY_S, DELAY_S];
/// Its numbers where each channel has its own.
const OF_CHANNELS: [&str; 3] = [
    "a.rise_less_fall_s",
    "b.rise_less_fall_s",
    "c.rise_less_fall_s",
];

/// Its card.
pub const CARD: Card = Card {
    title: "rise and fall delayed unequally",
    physics: "A comparator, an optocoupler or a filter passes a rising level later than a falling one, or sooner. The shaft turns on \
              meanwhile, so the shift grows with the speed.",
    equation: "e = -w (d_rise - d_fall) on rising levels, 0 on falling ones",
    source: "kinematics, first order in the delay: the shaft goes on by w d until the stamp",
    twin: "edge_delay",
    parameters: &[
        Quantity::new(
            "rise_less_fall_s",
            "s",
            RANGE,
            "d_rise - d_fall, where all channels have the same",
        ),
        Quantity::new(OF_CHANNELS[0], "s", RANGE, "the same of A"),
        Quantity::new(OF_CHANNELS[1], "s", RANGE, "the same of B"),
        Quantity::new(OF_CHANNELS[2], "s", RANGE, "the same of C"),
    ],
    locked_to: &[LockedTo::Angle],
    speed_exponent: Some(1),
    edge_classes: EdgeClasses::RiseAgainstFall,
    look_alikes: &[Mechanism::WidthError, Mechanism::ThresholdDrift],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "Two recordings at speeds a factor of two apart: unequal delays of rise and fall grow with the speed, width errors do not.",
};
