//! `gear_mesh`: torque at an order that a gear gives.
//!
//! Each tooth that comes into mesh pushes; with z teeth on a wheel that turns i times as fast as the encoder, the order is n = z i, and
//! n / z once for each turn of that wheel, seldom a whole number:
//! `J dw/dt = T sin(n theta + phi), n = z i`
//! The mark is that of a [`Mechanism::TorqueRipple`], but does not repeat each turn. Which ratio gives the order, only the rig's own
//! drawings tell; so [`Mechanism::Bearing`] is named beside it. Simulated in `sim/taylor.rs`.
//!
//! Source: tooth-mesh frequency, teeth times speed of the wheel (R. B. Randall, Vibration-based Condition Monitoring, 2011, ch. 2).

use super::card::ORDERS;
use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Its card.
pub const CARD: Card = Card {
    title: "torque of a gear mesh",
    physics: "Each tooth that comes into mesh pushes the shaft. The order is the teeth of a wheel times its ratio to the encoder, seldom \
              a whole number.",
    equation: "J dw/dt = T sin(n theta + phi), n = z i",
    source: "tooth-mesh frequency, teeth times speed of the wheel (R. B. Randall, Vibration-based Condition Monitoring, 2011, ch. 2)",
    twin: "gear_mesh",
    parameters: &[
        Quantity::new("order", "1", ORDERS, "n, cycles a turn"),
        Quantity::torque("T, its amplitude"),
        Quantity::phase("phi, its phase at angle 0"),
    ],
    locked_to: &[LockedTo::FractionalOrder],
    speed_exponent: Some(-2),
    edge_classes: EdgeClasses::Alike,
    look_alikes: &[
        Mechanism::Bearing,
        Mechanism::TorqueTone,
        Mechanism::TorqueRipple,
    ],
    same_mark: &[],
    told_by_rig: &[Mechanism::Bearing],
    separated_by: "Two recordings at speeds that differ by a tenth or more: the order stays while its frequency moves; the gear's tooth \
                   counts must give this order, or it is a bearing. One more with the gear disconnected shows it gone.",
};
