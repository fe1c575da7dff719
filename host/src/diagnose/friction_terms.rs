//! Which terms of friction a run-down lacks, decided all at once.
//!
//! Along one run-down dry friction, viscous friction and drag are much alike, and what two of them make looks like the third with a
//! little of Stribeck's beside: found one after another, the first takes what belongs to others. They are few, so every choice of them
//! is weighed beside what else was found.

use super::basis::Basis;
use super::board::{Board, Column, Model};
use super::hypothesis::Hypothesis;
use super::rivals::ALIKE;
use super::search::{BEYOND, Found, columns};
use super::weigh::{Shelf, weigh};
use crate::mechanism::Mechanism;

/// Mechanisms that a slow change of the course may have been taken for, while the terms were not all known.
const SLOW: f64 = 0.1;

/// The findings with another choice of terms in place of theirs, where that explains more; none where theirs is as good.
#[must_use]
pub fn other_terms(
    board: &Board,
    nuisances: &[Column],
    found: &[Found],
    shelf: &mut Shelf,
) -> Option<Vec<Found>> {
    let is_term = |one: &Found| one.hypothesis.mechanism == Mechanism::Friction;
    if !found.iter().any(is_term) {
        return None;
    }
    let may_go = |one: &Found| is_term(one) || is_slow(&one.hypothesis);
    let (present, others): (Vec<Found>, Vec<Found>) = found.iter().cloned().partition(may_go);
    let beside = board.fit(columns(nuisances, &others))?;
    let own: Vec<Hypothesis> = present.iter().map(|one| one.hypothesis.clone()).collect();
    let mut best = (worth(board, &beside, &own, shelf)? + ALIKE, None);
    for choice in choices(board) {
        match worth(board, &beside, &choice, shelf) {
            Some(worth) if worth > best.0 => best = (worth, Some(choice)),
            _ => {}
        }
    }
    let choice = best.1?;
    let mut all = others;
    for (at, one) in choice.iter().enumerate() {
        let rest = choice.iter().enumerate().filter(|(other, _)| *other != at);
        let rest: Vec<Column> = rest
            .flat_map(|(_, one)| shelf.columns(board, one))
            .collect();
        let without = board.fit(beside.columns.iter().cloned().chain(rest).collect())?;
        let columns = shelf.columns(board, one);
        all.push(weigh(board, &without, one.clone(), columns)?.into());
    }
    Some(all)
}

/// A rhythm of which a recording has a small part of a turn or a few turns: what is left of a course that brakes otherwise.
fn is_slow(hypothesis: &Hypothesis) -> bool {
    matches!(hypothesis.bases.as_slice(), [Basis::TorqueOrder { order }] if *order < SLOW)
}

/// Every choice of terms, with one of Stribeck's speeds or none.
fn choices(board: &Board) -> Vec<Vec<Hypothesis>> {
    let all = (Mechanism::Friction.card().handling.proposed)(board);
    let stribeck = |one: &Hypothesis| matches!(one.bases.first(), Some(Basis::Stribeck { .. }));
    let (speeds, terms): (Vec<Hypothesis>, Vec<Hypothesis>) = all.into_iter().partition(stribeck);
    let mut choices: Vec<Vec<Hypothesis>> = vec![Vec::new()];
    for term in terms {
        let with: Vec<Vec<Hypothesis>> = choices
            .iter()
            .map(|choice| [choice.as_slice(), std::slice::from_ref(&term)].concat())
            .collect();
        choices.extend(with);
    }
    let with = |speed: &Hypothesis| -> Vec<Vec<Hypothesis>> {
        let each = choices.iter();
        each.map(|choice| [choice.as_slice(), std::slice::from_ref(speed)].concat())
            .collect()
    };
    let beside: Vec<Vec<Hypothesis>> = speeds.iter().flat_map(with).collect();
    choices.extend(beside);
    choices.retain(|choice| !choice.is_empty());
    choices
}

/// What a choice explains beyond what it takes to be found; none where some of it can't be told from the rest.
fn worth(board: &Board, beside: &Model, choice: &[Hypothesis], shelf: &mut Shelf) -> Option<f64> {
    let columns: Vec<Column> = choice
        .iter()
        .flat_map(|one| shelf.columns(board, one))
        .collect();
    let searched: usize = choice.iter().map(Hypothesis::searched).sum();
    let numbers = (columns.len() + searched) as f64;
    let gain = board.gain(beside, &columns)?;
    Some(gain.squares - numbers * (board.edges() as f64).ln() - BEYOND * choice.len() as f64)
}
