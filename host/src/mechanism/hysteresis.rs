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
use super::{Card, EdgeClasses, Handling, LockedTo, Mechanism, Quantity};
use crate::diagnose::basis::Basis;
use crate::diagnose::board::Board;
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::mended::Mended;
use crate::diagnose::named::Numbers;
use crate::diagnose::play;
use crate::twin::Hysteresis;

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
    handling: Handling {
        makes: |basis| matches!(basis, Basis::Direction),
        columns: |_, seen, _| vec![play::column(seen)],
        proposed,
        values: |_| vec![("angle_rad".to_owned(), Numbers::size(0))],
        text: |_| "forward against reverse, all edges alike".to_owned(),
        mends,
        ..Handling::NONE
    },
};

/// Where any recording goes both ways.
fn proposed(board: &Board) -> Vec<Hypothesis> {
    if board.benches.iter().any(|bench| bench.seen.reverses()) {
        vec![Hypothesis::by(Basis::Direction)]
    } else {
        Vec::new()
    }
}

fn mends(mended: &mut Mended, _: Basis, sizes: &[f64]) {
    let old = mended.twin.hysteresis.map_or(0.0, |h| h.angle_rad);
    mended.twin.hysteresis = Some(Hysteresis {
        angle_rad: (old + sizes[0]).max(0.0),
        channel: None,
    });
}
