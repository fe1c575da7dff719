//! `eccentricity`: the disc's centre is off the axis it turns about.
//!
//! A head at radius R over a disc whose centre is d off the axis reads, to first order in d / R,
//! `e(theta) = (d / R) sin(theta - theta0)`
//! too much: once a turn, all edges alike, the same angle at any speed. One head can't tell it from a line error of order 1, two
//! opposite heads would cancel it. Simulated in `sim/disc.rs`.
//!
//! Source: plane geometry of a circle about a point off its centre, first order in d / R; A. Ernst, Digital Length and Angle
//! Measurement Technology, 1998.

use super::card::RUN_OUT_RAD;
use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Its card.
pub const CARD: Card = Card {
    title: "disc off its centre",
    physics: "The disc's centre is a distance d off the axis that it turns about, so a head at radius R reads too much on one half of \
              the turn and too little on the other.",
    equation: "e(theta) = (d / R) sin(theta - theta0)",
    source: "plane geometry of a circle about a point off its centre, first order in d / R; A. Ernst, Digital Length and Angle \
             Measurement Technology, 1998",
    twin: "errors.eccentricity",
    parameters: &[
        Quantity::new(
            "amplitude_rad",
            "rad",
            [0.0, RUN_OUT_RAD],
            "d / R, at order 1",
        ),
        Quantity::phase("theta0, as in amplitude sin(theta - phase)"),
    ],
    locked_to: &[LockedTo::FirstOrder],
    speed_exponent: Some(0),
    edge_classes: EdgeClasses::Alike,
    look_alikes: &[
        Mechanism::TorqueRipple,
        Mechanism::LineError,
        Mechanism::ClosedLoop,
        Mechanism::Bearing,
    ],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "Two recordings at speeds a factor of two apart, in torque or voltage mode: eccentricity keeps its size in angle, torque \
                   at order 1 (imbalance) falls with the square of the speed.",
};
