//! Errors of a disc that have names of their own: an axis off the centre, a tilt, one place that is out of line.
//!
//! Several of them at once look like a disc of which every edge has an error, as each leaves the others as much again. What they explain
//! together, and what a pattern explains of the rest, is held against what a pattern explains of all (Schwarz's criterion of the whole).
//! A place must do better than orders of the disc one by one, of which a smooth pattern has a few.

use super::basis::Basis;
use super::board::{Board, Column, Model};
use super::disc::{far_orders, pattern, score, score_of_orders};
use super::hypothesis::Hypothesis;
use super::least_squares::squares;
use super::refine::{WIDEST_RAD, refined};
use super::scan::defects;
use super::search::{BEYOND, Found};
use super::weigh::{Weighed, weigh};

/// Part of a large pattern that a place must explain beyond it, as a linear model leaves a little over.
const SLIGHT: f64 = 0.01;

/// Named parts of the disc on top of a model, where they and a pattern of the rest explain more than a pattern of the `whole` does, and
/// than the one `place` that may be found instead and a pattern of its rest.
#[must_use]
pub fn disc_parts(
    board: &Board,
    model: &Model,
    whole: Option<f64>,
    place: Option<&Found>,
) -> Option<Vec<Found>> {
    let instead = place.map_or(0.0, |one| {
        one.score + rest_of(board, model, one).unwrap_or(0.0)
    });
    let beats = whole.unwrap_or(0.0).max(instead);
    let mut parts = waves(board, model);
    if let Some(place) = place_beside(board, model, &parts) {
        parts.push(place);
    }
    let mut total = total(board, model, &parts)?;
    // What the others do without is none of them.
    while let Some((at, without)) = least(board, model, &parts) {
        if without < total - BEYOND {
            break;
        }
        parts.remove(at);
        total = without;
    }
    let alone = matches!(parts.as_slice(), [one] if is_place(one));
    if !parts.iter().any(is_place) && !only_waves(board, model) {
        return None;
    }
    if parts.is_empty() || alone || total < beats + BEYOND {
        return None;
    }
    Some(parts.into_iter().map(Found::from).collect())
}

/// An axis off the centre and a tilt, as far as they show.
fn waves(board: &Board, model: &Model) -> Vec<Weighed> {
    let lines = board.benches.first().map_or(1, |bench| {
        (bench.seen.edges / bench.seen.classes.max(1)) as usize
    });
    // What all edges of a class have has names of its own.
    let orders = [1_usize, 2]
        .into_iter()
        .filter(|order| order % lines.max(1) != 0);
    orders
        .filter_map(|order| {
            let hypothesis = Hypothesis::by(Basis::Round {
                order: order as f64,
            });
            let columns = hypothesis.columns(board);
            let count = columns.len();
            weigh(board, model, hypothesis, columns).filter(|one| one.columns.len() == count)
        })
        .collect()
}

/// Whether of all orders of the disc's pattern those of an axis off the centre and of a tilt alone stand far out: a disc that errs by
/// many an order has no need of a name for two of them. All are solved together, as edges far out of place mix what orders pull.
fn only_waves(board: &Board, model: &Model) -> bool {
    let far = pattern(board, model, true).and_then(|whole| far_orders(board, &whole));
    far.is_some_and(|far| !far.is_empty() && far.iter().all(|order| *order <= 2))
}

/// The place that explains most of what parts leave, if orders of the disc one by one do not do as well.
fn place_beside(board: &Board, model: &Model, parts: &[Weighed]) -> Option<Weighed> {
    let beside = board.fit(columns(model, parts))?;
    let each = defects(board, &beside).into_iter().filter_map(|one| {
        let columns = one.columns(board);
        weigh(board, &beside, one, columns)
    });
    let best = each.max_by(|a, b| a.score.total_cmp(&b.score))?;
    let place = refined(board, &beside, best);
    let wide = |basis: &Basis| matches!(basis, Basis::Bump { width_rad, .. } if *width_rad > 0.99 * WIDEST_RAD);
    if place.score < BEYOND || place.hypothesis.bases.iter().any(wide) {
        return None;
    }
    let with = board.fit(
        beside
            .columns
            .iter()
            .chain(&place.columns)
            .cloned()
            .collect(),
    )?;
    let before = score_of_orders(board, &beside)?;
    (place.score + score_of_orders(board, &with)? > before + BEYOND + SLIGHT * before.abs())
        .then_some(place)
}

/// What parts explain together beyond their cost, and a pattern of what they leave.
fn total(board: &Board, model: &Model, parts: &[Weighed]) -> Option<f64> {
    let with = board.fit(columns(model, parts))?;
    let numbers = |part: &Weighed| part.columns.len() + part.hypothesis.searched();
    let cost = parts.iter().map(numbers).sum::<usize>() as f64 * (board.edges() as f64).ln();
    let rest = score(board, &with, true).unwrap_or(0.0).max(0.0);
    Some(squares(model) - squares(&with) - cost + rest)
}

/// What a pattern explains of the rest that a finding leaves.
fn rest_of(board: &Board, model: &Model, found: &Found) -> Option<f64> {
    let own = found.columns.iter();
    let with = board.fit(model.columns.iter().chain(own).cloned().collect())?;
    score(board, &with, true).map(|score| score.max(0.0))
}

/// The part without which the rest come to most, and what that is.
fn least(board: &Board, model: &Model, parts: &[Weighed]) -> Option<(usize, f64)> {
    let each = (0..parts.len()).filter_map(|at| {
        let mut others = parts.to_vec();
        others.remove(at);
        Some((at, total(board, model, &others)?))
    });
    each.max_by(|a, b| a.1.total_cmp(&b.1))
}

fn columns(model: &Model, parts: &[Weighed]) -> Vec<Column> {
    let own = parts.iter().flat_map(|part| &part.columns);
    model.columns.iter().chain(own).cloned().collect()
}

fn is_place(part: &Weighed) -> bool {
    matches!(part.hypothesis.bases.first(), Some(Basis::Bump { .. }))
}
