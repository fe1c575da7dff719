//! `channel_skew`: the channels are captured with unequal delays.
//!
//! Filters, cables or comparators of the channels differ, so all edges of one come d later than those of A:
//! `e = -w d on both edges of channel B, 0 on those of A`
//! with w the signed speed. At one speed that is a quadrature error; it grows with the speed as no quadrature error does. Simulated
//! in `sim/signal.rs`.
//!
//! Source: kinematics, first order in the delay: the shaft goes on by w d until the stamp.

use super::card::DELAY_S;
use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Either way.
const RANGE: [f64; 2] = [-DELAY_S, DELAY_S];
/// Its numbers by channel.
const OF_CHANNELS: [&str; 3] = ["a_less_a_s", "b_less_a_s", "c_less_a_s"];

/// Its card.
pub const CARD: Card = Card {
    title: "channels delayed unequally",
    physics: "Filters, cables or comparators of the channels differ, so all edges of one come later than those of A. The shaft turns \
              on meanwhile, so the shift grows with the speed.",
    equation: "e = -w d on both edges of channel B, 0 on those of A",
    source: "kinematics, first order in the delay: the shaft goes on by w d until the stamp",
    twin: "channel_skew",
    parameters: &[
        Quantity::new(OF_CHANNELS[1], "s", RANGE, "d of B, against A"),
        Quantity::new(OF_CHANNELS[2], "s", RANGE, "d of C, against A"),
    ],
    locked_to: &[LockedTo::Angle],
    speed_exponent: Some(1),
    edge_classes: EdgeClasses::ChannelAgainstChannel,
    look_alikes: &[Mechanism::QuadratureError],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "Two recordings at speeds a factor of two apart: unequal delays of the channels grow with the speed, a quadrature error \
                   does not.",
};
