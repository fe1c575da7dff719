//! `eccentricity`: the disc's centre is off the axis it turns about.
//!
//! A head at radius R over a disc whose centre is d off the axis reads, to first order in d / R,
//! `e(theta) = (d / R) sin(theta - theta0)`
//! too much: once a turn, all edges alike, the same angle at any speed. One head can't tell it from a line error of order 1, two
//! opposite heads would cancel it. Simulated in `sim/disc.rs`.
//!
//! Source: plane geometry of a circle about a point off its centre, first order in d / R; A. Ernst, Digital Length and Angle
//! Measurement Technology, 1998.

use super::line_error::{add_order, columns, instead_of, of_rhythm, round_order, text, values};
use super::{Card, EdgeClasses, Handling, LockedTo, Mechanism, Quantity};
use crate::diagnose::basis::Basis;
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::mended::Mended;
use crate::twin::Harmonic;

/// Largest d / R: a tenth of the radius, which no rig passes for centred.
const LARGEST_RAD: f64 = 0.1;

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
            [0.0, LARGEST_RAD],
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
    handling: Handling {
        makes: |basis| round_order(basis).is_some_and(own),
        proposed: |_| vec![Hypothesis::by(Basis::Round { order: 1.0 })],
        columns,
        of_rhythm: |rhythm| of_rhythm(rhythm, own),
        instead_of: |found, setting| instead_of(found, setting, own),
        values,
        text,
        mends: |mended, _, sizes| {
            if listed(mended) {
                add_order(mended, 1.0, sizes);
            } else {
                let old = mended.twin.errors.eccentricity;
                mended.twin.errors.eccentricity = Some(sum(old, sizes));
            }
        },
        ..Handling::NONE
    },
};

fn own(order: f64) -> bool {
    order == 1.0
}

/// Whether the twin lists its disc edge by edge, so that nothing else may be declared of it.
pub(super) fn listed(mended: &Mended) -> bool {
    let errors = &mended.twin.errors;
    errors.csv.is_some() || !errors.list_rad.is_empty() || !mended.errors_rad.is_empty()
}

/// What a twin declares of an order, with cos and sin added: amplitude sin(order theta - phase).
pub(super) fn sum(old: Option<Harmonic>, sizes: &[f64]) -> Harmonic {
    let (s, c) = old.map_or((0.0, 0.0), |h| {
        (
            h.amplitude_rad * h.phase_rad.cos(),
            -h.amplitude_rad * h.phase_rad.sin(),
        )
    });
    let (s, c) = (s + sizes[1], c + sizes[0]);
    Harmonic {
        amplitude_rad: s.hypot(c),
        phase_rad: (-c).atan2(s),
    }
}
