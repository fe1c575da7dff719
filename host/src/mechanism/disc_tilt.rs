//! `disc_tilt`: the disc is tilted against the axis, or oval.
//!
//! A circle tilted by beta looks like an ellipse from the axis: the angle on it runs ahead and behind twice a turn, as that of a
//! Hooke's joint does, `tan phi = tan theta cos beta`, so that to first order in beta^2
//! `e(theta) = (beta^2 / 4) sin(2 theta - phi)`.
//! An oval disc has the same form with its own size. Simulated in `sim/disc.rs`.
//!
//! Source: angle of a Hooke's joint, second order in beta (J. E. Shigley, J. J. Uicker, Theory of Machines and Mechanisms).

use super::card::RUN_OUT_RAD;
use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Its card.
pub const CARD: Card = Card {
    title: "tilted or oval disc",
    physics: "A disc tilted by beta against the axis, or oval, looks like an ellipse from the axis: its angle runs ahead and behind \
              twice a turn, as that of a Hooke's joint does.",
    equation: "e(theta) = (beta^2 / 4) sin(2 theta - phi)",
    source: "angle of a Hooke's joint, second order in beta (J. E. Shigley, J. J. Uicker, Theory of Machines and Mechanisms)",
    twin: "errors.tilt",
    parameters: &[
        Quantity::new(
            "amplitude_rad",
            "rad",
            [0.0, RUN_OUT_RAD],
            "at order 2, beta^2 / 4 of a tilt",
        ),
        Quantity::phase("phi, as in amplitude sin(2 theta - phase)"),
    ],
    locked_to: &[LockedTo::SecondOrder],
    speed_exponent: Some(0),
    edge_classes: EdgeClasses::Alike,
    look_alikes: &[
        Mechanism::TorqueRipple,
        Mechanism::LineError,
        Mechanism::ClosedLoop,
    ],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "Two recordings at speeds a factor of two apart, in torque or voltage mode: a tilted disc keeps its size in angle, torque \
                   at order 2 falls with the square of the speed.",
};
