//! Which errors all edges of a class have, decided all at once.
//!
//! Widths and the quadrature are angles, delays and the skew are times, and one speed turns the ones into the others: found one after
//! another, the first takes what belongs to two of the others, and those then mend what it made of it. Their kinds are few, so every
//! choice of them is weighed beside what else was found.

use super::board::{Board, Column, Model};
use super::hypothesis::Hypothesis;
use super::least_squares::squares;
use super::rivals::ALIKE;
use super::search::{BEYOND, Found, columns};
use super::weigh::{Shelf, weigh};
use crate::mechanism::Mechanism;

/// What all edges of a class have.
const KINDS: [Mechanism; 4] = [
    Mechanism::WidthError,
    Mechanism::QuadratureError,
    Mechanism::EdgeDelay,
    Mechanism::ChannelSkew,
];

/// The findings with another choice of such errors in place of theirs, where that explains more; none where theirs is as good, or where
/// they have fewer than `least`.
#[must_use]
pub fn other_choice(
    board: &Board,
    nuisances: &[Column],
    found: &[Found],
    shelf: &mut Shelf,
    least: usize,
) -> Option<Vec<Found>> {
    let mut ways = KINDS
        .map(|kind| (kind.card().handling.proposed)(board))
        .to_vec();
    // A rhythm that comes once a line is all edges of a class too.
    let rhythms = found
        .iter()
        .filter(|one| once_a_line(board, &one.hypothesis));
    ways.extend(rhythms.map(|one| vec![one.hypothesis.clone()]));
    let own = |one: &Found| ways.iter().flatten().any(|way| *way == one.hypothesis);
    let (here, mut others): (Vec<Found>, Vec<Found>) = found.iter().cloned().partition(own);
    let rhythms = ways.len() > KINDS.len();
    if here.len() < least && !rhythms {
        return None;
    }
    let beside = board.fit(columns(nuisances, &others))?;
    let present: Vec<Hypothesis> = here.into_iter().map(|one| one.hypothesis).collect();
    let all = choices(&ways);
    let variance = variance(board, &beside, &all, shelf)?;
    let mut best = (
        worth(board, &beside, &present, variance, shelf)? + ALIKE,
        None,
    );
    for choice in all {
        match worth(board, &beside, &choice, variance, shelf) {
            Some(worth) if worth > best.0 => best = (worth, Some(choice)),
            _ => {}
        }
    }
    let choice = best.1?;
    for one in &choice {
        let rest = choice.iter().filter(|other| *other != one);
        let rest = rest.flat_map(|other| shelf.columns(board, other));
        let without = board.fit(beside.columns.iter().cloned().chain(rest).collect())?;
        let own = shelf.columns(board, one);
        let weighed = weigh(board, &without, one.clone(), own)?;
        others.push(weighed.into());
    }
    Some(others)
}

fn once_a_line(board: &Board, hypothesis: &Hypothesis) -> bool {
    let order = hypothesis.rhythm().filter(|_| hypothesis.whole());
    board
        .benches
        .first()
        .zip(order)
        .is_some_and(|(bench, order)| {
            let lines = (bench.seen.edges / bench.seen.classes.max(1)) as f64;
            order > 0.0 && order % lines == 0.0
        })
}

/// Variance of what no choice explains: where that is a disc that is not known yet it comes again each turn, and says as much once only.
fn variance(
    board: &Board,
    beside: &Model,
    all: &[Vec<Hypothesis>],
    shelf: &mut Shelf,
) -> Option<f64> {
    let gains = all.iter().filter_map(|choice| {
        let columns: Vec<Column> = choice
            .iter()
            .flat_map(|one| shelf.columns(board, one))
            .collect();
        board.gain(beside, &columns)
    });
    let most = gains.map(|gain| gain.squares).fold(0.0, f64::max);
    let edges = board.edges() as f64;
    let turns = edges / board.benches.first()?.seen.edges as f64;
    let left = (squares(beside) - most) / edges;
    Some(((left - 1.0) * turns).max(1.0))
}

/// What a choice explains beyond what it takes to be found; none where some of it can't be told from the rest.
fn worth(
    board: &Board,
    beside: &Model,
    choice: &[Hypothesis],
    variance: f64,
    shelf: &mut Shelf,
) -> Option<f64> {
    let columns: Vec<Column> = choice
        .iter()
        .flat_map(|one| shelf.columns(board, one))
        .collect();
    let cost = columns.len() as f64 * (board.edges() as f64).ln();
    let gain = board.gain(beside, &columns)?;
    Some(gain.squares / variance - cost - BEYOND * choice.len() as f64)
}

/// Every choice of one or no way of each kind, but the empty one.
fn choices(ways: &[Vec<Hypothesis>]) -> Vec<Vec<Hypothesis>> {
    let mut all: Vec<Vec<Hypothesis>> = vec![Vec::new()];
    for of_kind in ways {
        let more: Vec<Vec<Hypothesis>> = all
            .iter()
            .flat_map(|choice| {
                let with =
                    |way: &Hypothesis| [choice.as_slice(), std::slice::from_ref(way)].concat();
                of_kind.iter().map(with)
            })
            .collect();
        all.extend(more);
    }
    all.remove(0);
    all
}
