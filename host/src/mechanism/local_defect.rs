//! `local_defect`: dirt, a scratch, a missing or a merged line.
//!
//! A few edges about one angle of the disc are out of line, and more so the nearer they are:
//! `e(k) = E exp(-d(k)^2 / (2 s^2)), d the way from the edge to the defect`
//! often of one channel or one kind of edge only. Place and width are searched for, by kind of edge; the size is linear. Simulated in
//! `sim/defect.rs`.
//!
//! Source: a smooth bump with one place, width and size, chosen for this tool; a part of eps(k) in eq. (1) of Yin, Guo et al.,
//! doi 10.19650/j.cnki.cjsi.J2210801.

use std::f64::consts::{PI, TAU};

use super::card::ERROR_RAD;
use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Its card.
pub const CARD: Card = Card {
    title: "defect at one place of the disc",
    physics: "Dirt, a scratch, a missing line or one that has merged with the next puts the edges about one angle of the disc out of \
              line, often those of one channel or of one kind only.",
    equation: "e(k) = E exp(-d(k)^2 / (2 s^2)), d the way from the edge to the defect",
    source: "a smooth bump with one place, width and size, chosen for this tool; a part of eps(k) in eq. (1) of Yin, Guo et al., \
             doi 10.19650/j.cnki.cjsi.J2210801",
    twin: "local_defect",
    parameters: &[
        Quantity::new("angle_rad", "rad", [0.0, TAU], "place on the disc"),
        Quantity::new("width_rad", "rad", [1e-7, PI], "s, sigma of the bump"),
        Quantity::new(
            "error_rad",
            "rad",
            [-ERROR_RAD, ERROR_RAD],
            "E, error at the peak",
        ),
    ],
    locked_to: &[LockedTo::OneAngle],
    speed_exponent: Some(0),
    edge_classes: EdgeClasses::OftenOne,
    look_alikes: &[
        Mechanism::LineError,
        Mechanism::LostEdges,
        Mechanism::ExtraEdges,
    ],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "A longer recording, ten turns or more: a defect stays at its angle every turn, lost or extra edges do not come back.",
};
