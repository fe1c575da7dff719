//! What happens once, looked for anew beside all that was found since.
//!
//! A load that was found under a tone has its ends where a wave of that made them, and a level that drifts under another its beginning:
//! once the other is known they are a little off, and what they then leave would be taken for more of the kind.

use std::mem::discriminant;

use super::basis::Basis;
use super::board::{Board, Column};
use super::hypothesis::Hypothesis;
use super::least_squares::squares;
use super::refine::refined;
use super::search::{BEYOND, Found, columns};
use super::weigh::weigh;

/// Part of what one more of the kind would explain that those there have to explain more, looked for anew.
const PART: f64 = 0.3;

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
        if !alike(&all[at].hypothesis, &more.hypothesis) {
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

/// Whether both happen once, in the same way.
fn alike(one: &Hypothesis, other: &Hypothesis) -> bool {
    match (one.bases.as_slice(), other.bases.as_slice()) {
        ([one @ (Basis::Load { .. } | Basis::LevelDrift { .. })], [other]) => {
            discriminant(one) == discriminant(other)
        }
        _ => false,
    }
}
