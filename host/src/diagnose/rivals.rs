//! What else could be in a finding's place.

use std::f64::consts::TAU;

use super::basis::{Basis, channels};
use super::board::{Board, Column};
use super::hypothesis::Hypothesis;
use super::refine::refined;
use super::search::{Found, Searched};
use super::weigh::weigh;
use crate::mechanism::Mechanism;

/// By how much less one may explain and still be as likely as not.
pub const ALIKE: f64 = 9.0;

/// Rivals of a finding, each fitted in its place, best first; and its own score there.
#[must_use]
pub fn rivals(board: &Board, searched: &Searched, number: usize) -> (f64, Vec<(Hypothesis, f64)>) {
    let found = &searched.found[number];
    let mut rest: Vec<Column> = searched.model.columns[..searched.nuisances].to_vec();
    for (at, other) in searched.found.iter().enumerate() {
        if at != number {
            rest.extend(other.columns.iter().cloned());
        }
    }
    let Some(without) = board.fit(rest) else {
        return (found.score, Vec::new());
    };
    let score =
        |hypothesis: Hypothesis, columns: Vec<Column>| weigh(board, &without, hypothesis, columns);
    let own =
        score(found.hypothesis.clone(), found.columns.clone()).map_or(found.score, |w| w.score);
    let mut all: Vec<(Hypothesis, f64)> = alternatives(board, found)
        .into_iter()
        .filter_map(|hypothesis| {
            let columns = hypothesis.columns(board);
            let weighed = refined(board, &without, score(hypothesis, columns)?);
            Some((weighed.hypothesis, weighed.score))
        })
        .collect();
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    (own, all)
}

/// Mechanisms whose marks may look like a finding's.
fn alternatives(board: &Board, found: &Found) -> Vec<Hypothesis> {
    let Some(first) = board.benches.first() else {
        return Vec::new();
    };
    let turning = first.seen.mean_speed();
    let channels = channels(first.seen.classes);
    let with = |mechanism, basis| Hypothesis::of(mechanism, basis);
    let each = |mechanism, basis: &dyn Fn(usize) -> Basis, from: usize| Hypothesis {
        mechanism,
        bases: (from..channels).map(basis).collect(),
    };
    let tone = |order: f64| {
        with(
            Mechanism::TorqueTone,
            Basis::TorqueTone {
                f_hz: order * turning / TAU,
            },
        )
    };
    match found.hypothesis.bases.first() {
        Some(&Basis::Round { order }) if order.fract() == 0.0 => {
            vec![with(Mechanism::TorqueRipple, Basis::TorqueOrder { order })]
        }
        Some(&Basis::TorqueOrder { order }) if order.fract() == 0.0 => {
            let geometry = match order {
                1.0 => Mechanism::Eccentricity,
                2.0 => Mechanism::DiscTilt,
                _ => Mechanism::LineError,
            };
            // An edge out of its place keeps its distance in angle, a pushed shaft in time: no one's name hangs on that.
            vec![
                with(geometry, Basis::Round { order }),
                with(geometry, Basis::Lagged { order }),
            ]
        }
        Some(&Basis::Round { order }) => vec![
            with(Mechanism::GearMesh, Basis::TorqueOrder { order }),
            tone(order),
        ],
        Some(&Basis::TorqueOrder { order }) => {
            vec![
                with(Mechanism::Bearing, Basis::Round { order }),
                with(Mechanism::Bearing, Basis::Lagged { order }),
                tone(order),
            ]
        }
        Some(&Basis::TorqueTone { f_hz }) => {
            let order = TAU * f_hz / turning;
            let order = if order.fract() == 0.0 {
                order + 1e-9
            } else {
                order
            };
            vec![
                with(Mechanism::GearMesh, Basis::TorqueOrder { order }),
                with(Mechanism::Bearing, Basis::Round { order }),
            ]
        }
        Some(Basis::Width { .. }) => vec![
            with(Mechanism::EdgeDelay, Basis::RiseLate { channel: None }),
            each(
                Mechanism::EdgeDelay,
                &|c| Basis::RiseLate { channel: Some(c) },
                0,
            ),
        ],
        Some(Basis::RiseLate { .. }) if found.hypothesis.bases.len() <= channels => vec![
            with(Mechanism::WidthError, Basis::Width { channel: None }),
            each(
                Mechanism::WidthError,
                &|c| Basis::Width { channel: Some(c) },
                0,
            ),
        ],
        Some(Basis::Shift { .. }) => vec![each(
            Mechanism::ChannelSkew,
            &|c| Basis::Late { channel: c },
            1,
        )],
        Some(Basis::Late { .. }) if found.hypothesis.bases.len() < channels => vec![each(
            Mechanism::QuadratureError,
            &|c| Basis::Shift { channel: c },
            1,
        )],
        Some(Basis::Coulomb | Basis::Viscous | Basis::Drag) => {
            [Basis::Coulomb, Basis::Viscous, Basis::Drag]
                .map(|basis| with(Mechanism::Friction, basis))
                .into()
        }
        Some(Basis::Load { .. }) => vec![with(Mechanism::SpeedDrift, Basis::Drift)],
        _ => Vec::new(),
    }
}

/// Mechanisms that leave the very same mark: no recording of edges tells them apart.
#[must_use]
pub fn same_mark(found: &Hypothesis) -> &'static [Mechanism] {
    match found.bases.first() {
        Some(Basis::Direction) => &[Mechanism::Hysteresis, Mechanism::Backlash],
        _ => &[],
    }
}
