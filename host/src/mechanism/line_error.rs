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
use super::{Card, EdgeClasses, Handling, LockedTo, Mechanism, Quantity, Rhythm, Setting, Shows};
use crate::diagnose::basis::Basis;
use crate::diagnose::classes::round;
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::mended::Mended;
use crate::diagnose::named::{Named, Numbers};
use crate::diagnose::seen::Seen;
use crate::diagnose::shaft::ShaftLaw;

/// Least order that is neither eccentricity nor tilt.
const LEAST_ORDER: f64 = 3.0;

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
    handling: Handling {
        makes: |basis| round_order(basis).is_some_and(own),
        columns,
        of_rhythm: |rhythm| of_rhythm(rhythm, own),
        instead_of: |found, setting| instead_of(found, setting, own),
        values,
        text,
        mends: |mended, basis, sizes| {
            if let Some(order) = round_order(basis) {
                add_order(mended, order, sizes);
            }
        },
        ..Handling::NONE
    },
};

fn own(order: f64) -> bool {
    order.fract() == 0.0 && (order >= LEAST_ORDER || order <= 0.0)
}

/// The order of a pattern that is an error of the disc.
pub(super) fn round_order(basis: Basis) -> Option<f64> {
    match basis {
        Basis::Round { order } | Basis::Lagged { order } => Some(order),
        _ => None,
    }
}

/// An order of the disc: cos and sin of the grid angle, or of the true angle.
pub(super) fn columns(basis: Basis, seen: &Seen, _: &ShaftLaw) -> Vec<Vec<f64>> {
    match basis {
        Basis::Round { order } => round(seen, |at| order * seen.theta(at)),
        Basis::Lagged { order } => round(seen, |at| order * seen.true_theta(at)),
        _ => Vec::new(),
    }
}

/// A whole order that a geometry owns.
pub(super) fn of_rhythm(rhythm: Rhythm, own: fn(f64) -> bool) -> Option<Basis> {
    let order = rhythm.whole().filter(|order| own(*order))?;
    Some(Basis::Round { order })
}

/// What the disc would make of a torque's order. An edge out of its place keeps its distance in angle, a pushed shaft in time: no
/// name hangs on that, so both are tried.
pub(super) fn instead_of(found: &Hypothesis, _: Setting, own: fn(f64) -> bool) -> Vec<Hypothesis> {
    match found.bases.first() {
        Some(&Basis::TorqueOrder { order }) if own(order) => vec![
            Hypothesis::by(Basis::Round { order }),
            Hypothesis::by(Basis::Lagged { order }),
        ],
        _ => Vec::new(),
    }
}

/// Amplitude and phase: amplitude sin(order theta - phase).
pub(super) fn values(_: &Numbers<'_>) -> Named {
    let phase = Numbers::phase(0);
    vec![
        ("amplitude_rad".to_owned(), Numbers::amplitude(0)),
        (
            "phase_rad".to_owned(),
            Box::new(move |row| (-phase(row)).rem_euclid(std::f64::consts::TAU)),
        ),
    ]
}

/// An order of the disc in words.
pub(super) fn text(shows: Shows<'_>) -> String {
    format!(
        "order {}, {}, the same angle at any speed",
        shows.order_in_words(),
        shows.edges
    )
}

/// Adds an order to the errors of each edge.
pub(super) fn add_order(mended: &mut Mended, order: f64, sizes: &[f64]) {
    mended.add_disc(|theta, _, _| {
        let (sin, cos) = (order * theta).sin_cos();
        sizes[0] * cos + sizes[1] * sin
    });
}
