//! What has a place in time or a rhythm, looked for anew beside all that was found since.
//!
//! A load that was found under a tone has its ends where a wave of that made them, a level that drifts under another its beginning, and
//! a tone under a load is a little off its frequency: once the other is known, what they leave would be taken for more of the kind.

use std::mem::discriminant;

use super::basis::Basis;
use super::board::{Bench, Board, Column};
use super::hypothesis::Hypothesis;
use super::least_squares::squares;
use super::refine::refined;
use super::search::{BEYOND, Found, columns};
use super::weigh::weigh;

/// Part of what one more of the kind would explain that those there have to explain more, looked for anew.
const PART: f64 = 0.3;
/// Periods by which two rhythms get apart over a recording that are hardly told apart.
const NEAR: f64 = 2.0;

/// The findings with those like one more, which explains so much, looked for anew; none where that does not help.
#[must_use]
pub fn anew(
    board: &Board,
    nuisances: &[Column],
    found: &[Found],
    more: &Found,
) -> Option<Vec<Found>> {
    let mut all = found.to_vec();
    for at in 0..all.len() {
        if !alike(board, &all[at].hypothesis, &more.hypothesis) {
            continue;
        }
        let mut others = all.clone();
        let old = others.remove(at);
        let beside = board.fit(columns(nuisances, &others))?;
        let own = old.hypothesis.columns(board);
        let weighed = weigh(board, &beside, old.hypothesis, own)?;
        all[at] = Found {
            rivals: old.rivals,
            ..refined(board, &beside, weighed).into()
        };
    }
    let left = |found: &[Found]| Some(squares(&board.fit(columns(nuisances, found))?));
    (left(found)? - left(&all)? > BEYOND.max(PART * more.score)).then_some(all)
}

/// Whether both happen once, in the same way, or are of rhythms that are hardly told apart.
fn alike(board: &Board, one: &Hypothesis, other: &Hypothesis) -> bool {
    let (&[first], &[second]) = (one.bases.as_slice(), other.bases.as_slice()) else {
        return false;
    };
    let longest = |value: fn(&Bench) -> f64| board.benches.iter().map(value).fold(0.0, f64::max);
    let near = |apart: f64, longest: f64| apart.abs() * longest < NEAR;
    discriminant(&first) == discriminant(&second)
        && match (first, second) {
            (Basis::Load { .. } | Basis::LevelDrift { .. }, _) => true,
            (Basis::TorqueTone { f_hz }, Basis::TorqueTone { f_hz: other })
            | (Basis::LevelTone { f_hz, .. }, Basis::LevelTone { f_hz: other, .. }) => {
                near(f_hz - other, longest(|bench| bench.seen.seconds()))
            }
            (Basis::TorqueOrder { order }, Basis::TorqueOrder { order: other }) => {
                near(order - other, longest(|bench| bench.seen.turns()))
            }
            _ => false,
        }
}
