//! What is not worth a place among the candidates: what the disc explains as well, a trifle of a torque that the twin declares, and a
//! pattern of the disc that does not stay.

use rayon::prelude::*;

use super::basis::Basis;
use super::board::{Board, Model, product};
use super::disc::{Pattern, comes_again};
use super::hypothesis::{Hypothesis, with_disc};
use super::search::{BEYOND, Found};
use super::weigh::{Shelf, Weighed, weigh};
use crate::mechanism::Mechanism;

/// Part of the squares of one of its patterns that several together explain at the least.
const CANCELLED: f64 = 1e-4;
/// Part of a large error of the disc that a linear model may leave over.
const SLIGHT: f64 = 1e-3;

/// The same with what could be of the disc beside each; without those that the disc alone explains as well.
#[must_use]
pub fn beside_disc(
    board: &Board,
    model: &Model,
    shelf: &mut Shelf,
    proposed: Vec<Hypothesis>,
) -> Vec<Hypothesis> {
    let beside: Vec<(usize, Hypothesis)> = proposed
        .into_iter()
        .map(|alone| (alone.bases.len(), with_disc(alone, board)))
        .collect();
    let all: Vec<Hypothesis> = beside.iter().map(|(_, whole)| whole.clone()).collect();
    shelf.fill(board, &all);
    let score = |hypothesis: Hypothesis| {
        let columns = shelf.filled(&hypothesis);
        weigh(board, model, hypothesis, columns).map(|weighed| weighed.score)
    };
    let each = beside.into_par_iter().map(|(own, whole)| {
        let Some(disc) = Hypothesis::by_all(whole.bases[own..].to_vec()) else {
            return Some(whole);
        };
        let disc = score(disc).unwrap_or(0.0).max(0.0);
        let more = score(whole.clone())? - disc;
        (more > BEYOND + SLIGHT * disc).then_some(whole)
    });
    each.collect::<Vec<_>>().into_iter().flatten().collect()
}

/// Whether it is a drift of the level that is over before the recordings have begun: what is then left is a width, of each recording's
/// own.
#[must_use]
pub fn stands(board: &Board, one: &Weighed) -> bool {
    /// Part of its mean by which a drift changes at the least, RMS.
    const CHANGES: f64 = 0.1;
    let Some(&Basis::LevelDrift { from_s, tau_s, .. }) = one.hypothesis.bases.first() else {
        return false;
    };
    board.benches.iter().all(|bench| {
        let times = &bench.seen.times_s;
        let level = |time: &f64| -((from_s - time).min(0.0) / tau_s).exp_m1();
        let levels: Vec<f64> = times.iter().map(level).collect();
        let count = times.len() as f64;
        let mean = levels.iter().sum::<f64>() / count;
        let squares = levels.iter().map(|level| (level - mean).powi(2));
        squares.sum::<f64>() < (CHANGES * mean).powi(2) * count
    })
}

/// Whether it is a small part of a torque that the twin declares: how exactly that is known, and followed, is not this good.
#[must_use]
pub fn trifle(board: &Board, one: &Weighed) -> bool {
    const PART: f64 = 0.04;
    let Some(rhythm) = super::conclude::cycles_a_turn(board, &one.hypothesis) else {
        return false;
    };
    board.benches.iter().any(|bench| {
        let within = 1.0 / bench.seen.turns();
        let near = bench
            .torques
            .iter()
            .filter(|torque| (torque.0 - rhythm).abs() < within);
        near.into_iter().any(|(order, torque)| {
            let speed = bench.seen.mean_speed();
            let swing = match one.hypothesis.bases.first() {
                // As large as the torque that would swing the shaft as far.
                Some(Basis::Round { .. } | Basis::Lagged { .. }) => {
                    bench.law.inertia * (order * speed).powi(2)
                }
                Some(Basis::TorqueOrder { .. } | Basis::TorqueTone { .. }) => 1.0,
                _ => return false,
            };
            let squares = one.gain.sizes.iter().map(|size| size * size);
            squares.sum::<f64>().sqrt() * swing < PART * torque
        })
    })
}

/// Whether it is a disc that no rig has: what is far off the axis is none, but follows a motion that has another cause.
#[must_use]
pub fn beyond_rigs(one: &Weighed) -> bool {
    let mechanism = one.hypothesis.mechanism;
    let size = match (mechanism, one.hypothesis.bases.first()) {
        (Mechanism::Eccentricity | Mechanism::DiscTilt, _) => Some("amplitude_rad"),
        (Mechanism::Bearing, Some(Basis::Lagged { .. } | Basis::Round { .. })) => {
            Some("runout_rad")
        }
        _ => None,
    };
    let together = one.hypothesis.bases.len() > 1;
    let gain = &one.gain;
    let no_rigs = |name| mechanism.card().implausible([(name, gain.sizes.norm())]);
    // Patterns that all but cancel explain by what their laws leave out.
    let largest = one.columns.iter().zip(gain.sizes.iter());
    let largest = largest.map(|(column, size)| size * size * product(column, column));
    size.and_then(no_rigs).is_some()
        || together && gain.squares < CANCELLED * largest.fold(0.0, f64::max)
}

/// The first finding that beside the others has become a disc which no rig has.
#[must_use]
pub fn no_disc(found: &[Found], model: &Model, nuisances: usize) -> Option<usize> {
    let mut at = nuisances;
    found.iter().position(|one| {
        let sizes = model.sizes.rows(at, one.columns.len());
        at += one.columns.len();
        let mechanism = one.hypothesis.mechanism;
        let size = [("amplitude_rad", sizes.norm())];
        matches!(mechanism, Mechanism::Eccentricity | Mechanism::DiscTilt)
            && mechanism.card().implausible(size).is_some()
    })
}

/// Whether a pattern of the disc that is seen in one half hardly comes again in the other: it is none of the disc's.
#[must_use]
pub fn passes(board: &Board, model: &Model, pattern: &Pattern) -> bool {
    const PART: f64 = 0.35;
    let shares = comes_again(board, &model.left, pattern.white_rad);
    !shares.is_empty()
        && shares
            .iter()
            .all(|(share, error)| share + 3.0 * error < PART)
}
