//! `hysteresis`: edges shift with the direction of motion.
//!
//! A comparator with hysteresis, or a head that drags, changes its output only when the signal is past the level by half of the
//! hysteresis, so every mark has a place for either direction:
//! `e = -(h / 2) sign(w)`
//! on all edges alike. Only reversals show it. Play between shaft and disc, [`Mechanism::Backlash`], leaves the very same mark on every
//! edge passed. Simulated in `sim/shift.rs`.
//!
//! Source: two thresholds of a regenerative comparator (O. H. Schmitt, A thermionic trigger, Journal of Scientific Instruments 15,
//! 1938) over the slope of the signal in angle.

use super::card::ERROR_RAD;
use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Its card.
pub const CARD: Card = Card {
    title: "hysteresis of the head",
    physics: "A comparator with hysteresis, or a head that drags, changes its output only when the signal is well past the level: every \
              mark has one place forward and another in reverse.",
    equation: "e = -(h / 2) sign(w)",
    source: "two thresholds of a regenerative comparator (O. H. Schmitt, A thermionic trigger, Journal of Scientific Instruments 15, \
             1938) over the slope of the signal in angle",
    twin: "hysteresis",
    parameters: &[Quantity::new(
        "angle_rad",
        "rad",
        [-ERROR_RAD, ERROR_RAD],
        "h, between a mark's places forward and in reverse, on top of what the twin declares",
    )],
    locked_to: &[LockedTo::Direction],
    speed_exponent: Some(0),
    edge_classes: EdgeClasses::Alike,
    look_alikes: &[Mechanism::Backlash, Mechanism::WidthError],
    same_mark: &[Mechanism::Backlash],
    told_by_rig: &[],
    separated_by: "The same reversals with a constant torque on the disc's side that keeps any play to one flank: backlash goes, hysteresis \
                   of the head stays. It is below half a line, and a channel may have its own.",
};
