//! `line_error`: every edge of this disc has a place of its own.
//!
//! Ruling and printing leave each line a little off its grid angle, and the head's field sees some of them at a time. The residual has
//! `e(k) = eps(k), k the edge of the turn`
//! at every speed alike, so it repeats each turn. It is learned edge by edge where the whole pattern shows, and order by order, as
//! `cos(n theta)` and `sin(n theta)`, where only some orders do; orders 1 and 2 are [`Mechanism::Eccentricity`] and
//! [`Mechanism::DiscTilt`]. Simulated in `sim/disc.rs`.
//!
//! Source: Yin, Guo et al., Chinese Journal of Scientific Instrument, doi 10.19650/j.cnki.cjsi.J2210801, eq. (1).

use super::card::ERROR_RAD;
use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Its card.
pub const CARD: Card = Card {
    title: "line position error of the disc",
    physics: "Ruling or printing leaves every line of the disc a little off its place. Each edge keeps its error at every speed, so \
              the pattern repeats each turn.",
    equation: "e(k) = eps(k), k the edge of the turn",
    source: "Yin, Guo et al., Chinese Journal of Scientific Instrument, doi 10.19650/j.cnki.cjsi.J2210801, eq. (1)",
    twin: "errors.csv",
    parameters: &[
        Quantity::new(
            "rms_rad",
            "rad",
            [0.0, ERROR_RAD],
            "RMS over the edges of a turn, where each was learned: `--write-twin` writes them all",
        ),
        Quantity::new(
            "e_00_rad",
            "rad",
            [-ERROR_RAD, ERROR_RAD],
            "of a disc with 16 edges or fewer: error of edge 0, `e_01_rad` of edge 1, and so on",
        ),
        Quantity::new(
            "amplitude_rad",
            "rad",
            [0.0, ERROR_RAD],
            "of the order named, where one order was found by itself",
        ),
        Quantity::phase("its phase, as in amplitude sin(order theta - phase)"),
    ],
    locked_to: &[LockedTo::Angle],
    speed_exponent: Some(0),
    edge_classes: EdgeClasses::Own,
    look_alikes: &[
        Mechanism::LocalDefect,
        Mechanism::TorqueRipple,
        Mechanism::Eccentricity,
        Mechanism::DiscTilt,
        Mechanism::ClosedLoop,
    ],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "Two recordings at speeds a factor of two apart: line errors keep their size in angle, torque ripple falls with the \
                   square of the speed.",
};
