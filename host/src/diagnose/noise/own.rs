//! Rhythms that the twin has: behind a spring the shaft answers a ripple otherwise than the twin's stiff one, at each speed by
//! another factor, so what is left at its order is part of a mode and no rhythm of its own.

use std::f64::consts::TAU;

use super::super::basis::Basis;
use super::super::board::{Board, Column};
use super::super::hypothesis::Hypothesis;
use super::super::run::Recorded;

/// Largest distance of two orders that are one, however short the recording.
const APART: f64 = 0.25;
/// The same in lines of a recording's spectrum.
const LINES: f64 = 1.5;

/// Patterns of all ripples and tones that the twins have, of their own size in every recording.
#[must_use]
pub fn own_columns(board: &Board, rig: &[Recorded]) -> Vec<Column> {
    let Some(twin) = rig.first().map(|one| &one.twin) else {
        return Vec::new();
    };
    let orders = twin
        .ripple
        .iter()
        .map(|one| Basis::TorqueOrder { order: one.order });
    let tones = twin
        .torque_tone
        .iter()
        .map(|one| Basis::TorqueTone { f_hz: one.f_hz });
    let all = orders.chain(tones).flat_map(|basis| board.columns(basis));
    all.flat_map(apart).collect()
}

/// A column for each recording that a column is about.
fn apart(column: Column) -> Vec<Column> {
    let count = column.0.len();
    let parts = column.0.into_iter().enumerate();
    parts
        .filter_map(|(at, part)| {
            part.as_ref()?;
            let mut own = vec![None; count];
            own[at] = part;
            Some(Column(own))
        })
        .collect()
}

/// Whether a rhythm is in some recording where its twin has one.
#[must_use]
pub fn is_own(board: &Board, rig: &[Recorded], hypothesis: &Hypothesis) -> bool {
    let Some(rhythm) = hypothesis.rhythm() else {
        return false;
    };
    let timed = hypothesis.bases.first().is_some_and(|basis| basis.timed());
    let pairs = board.benches.iter().zip(rig);
    pairs.into_iter().any(|(bench, one)| {
        let turning = bench.seen.mean_speed() / TAU;
        let order = if timed { rhythm / turning } else { rhythm };
        let near = (LINES / bench.seen.turns().max(1.0)).min(APART);
        let ripples = one.twin.ripple.iter().map(|ripple| ripple.order);
        let tones = one.twin.torque_tone.iter().map(|tone| tone.f_hz / turning);
        ripples.chain(tones).any(|own| (own - order).abs() < near)
    })
}
