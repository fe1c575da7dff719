//! What is not worth a place among the candidates: what the disc explains as well, a trifle of a torque that the twin declares, and a
//! pattern of the disc that does not stay.

use super::basis::Basis;
use super::board::{Board, Model};
use super::disc::{Pattern, comes_again};
use super::hypothesis::{Hypothesis, with_disc};
use super::search::BEYOND;
use super::weigh::{Shelf, Weighed, weigh};

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
    let mut score = |hypothesis: Hypothesis| {
        let columns = shelf.columns(board, &hypothesis);
        weigh(board, model, hypothesis, columns).map(|weighed| weighed.score)
    };
    let each = proposed.into_iter().filter_map(|alone| {
        let own = alone.bases.len();
        let whole = with_disc(alone, board);
        let Some(disc) = Hypothesis::by_all(whole.bases[own..].to_vec()) else {
            return Some(whole);
        };
        let disc = score(disc).unwrap_or(0.0).max(0.0);
        let more = score(whole.clone())? - disc;
        (more > BEYOND + SLIGHT * disc).then_some(whole)
    });
    each.collect()
}

/// Whether it is a small part of a torque that the twin declares: how exactly that is known, and followed, is not this good.
#[must_use]
pub fn trifle(board: &Board, model: &Model, one: &Weighed) -> bool {
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
            board.gain(model, &one.columns).is_some_and(|gain| {
                let size = gain
                    .sizes
                    .iter()
                    .map(|size| size * size)
                    .sum::<f64>()
                    .sqrt();
                size * swing < PART * torque
            })
        })
    })
}

/// Whether a pattern of the disc that is seen in one half hardly comes again in the other: it is none of the disc's.
#[must_use]
pub fn passes(board: &Board, model: &Model, pattern: &Pattern) -> bool {
    const PART: f64 = 0.35;
    let shares = comes_again(board, &model.left, pattern.rms_rad);
    !shares.is_empty()
        && shares
            .iter()
            .all(|(share, error)| share + 3.0 * error < PART)
}
