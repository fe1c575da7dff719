//! `backlash`: a play between shaft and disc.
//!
//! The disc follows the shaft through a gap g: half a gap behind in the direction of motion, and at rest after a reversal until the
//! shaft has crossed the gap:
//! `e = -(g / 2) sign(w) once the gap is crossed; the disc stands before`
//! so edges that are passed lie as with a [`Mechanism::Hysteresis`] of g: both are named where either is found. Simulated in
//! `sim/shift.rs`.
//!
//! Source: dead zone between two inertias, the driven one without inertia (M. Nordin, P.-O. Gutman, Controlling mechanical systems
//! with backlash: a survey, Automatica 38, 2002).

use super::card::ERROR_RAD;
use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Its card.
pub const CARD: Card = Card {
    title: "backlash",
    physics: "A play between shaft and disc: the disc is half a gap behind in the direction of motion, and stands after a reversal until \
              the shaft has crossed the gap.",
    equation: "e = -(g / 2) sign(w) once the gap is crossed; the disc stands before",
    source: "dead zone between two inertias, the driven one without inertia (M. Nordin, P.-O. Gutman, Controlling mechanical systems \
             with backlash: a survey, Automatica 38, 2002)",
    twin: "backlash",
    parameters: &[Quantity::new(
        "gap_rad",
        "rad",
        [0.0, ERROR_RAD],
        "g, width of the play",
    )],
    locked_to: &[LockedTo::Reversals],
    speed_exponent: Some(0),
    edge_classes: EdgeClasses::Alike,
    look_alikes: &[Mechanism::Hysteresis],
    same_mark: &[Mechanism::Hysteresis],
    told_by_rig: &[],
    separated_by: "The same reversals with a constant torque on the disc's side that keeps the play to one flank: backlash goes, hysteresis \
                   of the head stays.",
};
