//! `bearing`: torque or run-out at an order that no declared ratio gives.
//!
//! Rolling elements pass a flaw of the outer ring n = (z / 2) (1 - (d / D) cos alpha) times a turn, z elements of diameter d on a pitch
//! diameter D with contact angle alpha. Slip makes n drift a little off that, so it is searched for. The shaft moves across its axis
//! with it, and an edge with the shaft:
//! `e = r sin(n theta + phi), n not whole`
//! of the same angle at any speed, theta being the shaft's own angle and not that of the grid, whose marks are a little off it; as a torque its mark is that of a [`Mechanism::GearMesh`]. Simulated in `sim/disc.rs`, as a torque
//! in `sim/taylor.rs`.
//!
//! Source: ball pass frequency of the outer ring (R. B. Randall, Vibration-based Condition Monitoring, 2011, ch. 2).

use super::card::{ORDERS, RUN_OUT_RAD};
use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Its card.
pub const CARD: Card = Card {
    title: "bearing or other run-out at a non-integer order",
    physics: "Rolling elements pass a flaw of a ring at an order that slip and their geometry give, not a whole number. The shaft moves \
              across its axis, and the edges with it, or it is pushed.",
    equation: "e = r sin(n theta + phi), n not whole",
    source: "ball pass frequency of the outer ring (R. B. Randall, Vibration-based Condition Monitoring, 2011, ch. 2)",
    twin: "bearing",
    parameters: &[
        Quantity::new("order", "1", ORDERS, "n, cycles a turn"),
        Quantity::new("runout_rad", "rad", [0.0, RUN_OUT_RAD], "r, its amplitude"),
        Quantity::phase("phi, its phase at angle 0"),
    ],
    locked_to: &[LockedTo::FractionalOrder],
    speed_exponent: None,
    edge_classes: EdgeClasses::Alike,
    look_alikes: &[
        Mechanism::GearMesh,
        Mechanism::TorqueTone,
        Mechanism::TorqueRipple,
        Mechanism::Eccentricity,
    ],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "Two recordings at speeds that differ by a factor of two: the order stays; run-out keeps its size in angle, torque falls \
                   with the square of the speed. One more with the gear disconnected rules out a mesh.",
};
