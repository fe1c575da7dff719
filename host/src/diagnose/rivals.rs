//! What else could be in a finding's place.

use rayon::prelude::*;

use super::basis::{Basis, channels};
use super::board::{Board, Column, Model};
use super::class_parts::KINDS;
use super::disc;
use super::hypothesis::Hypothesis;
use super::refine::refined;
use super::search::{Found, Searched};
use super::sift::beyond_rigs;
use super::weigh::weigh;
use crate::mechanism::{Mechanism, Setting};

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
    // A pattern that was learned beside the one finding took up what another in its place lacks or has too much, so each is weighed
    // with what more of a pattern explains then.
    let learned = searched.pattern.is_some() && KINDS.contains(&found.hypothesis.mechanism);
    let score = |hypothesis: Hypothesis, columns: Vec<Column>| {
        let mut weighed = weigh(board, &without, hypothesis, columns)?;
        if learned {
            let beside = without.columns.iter().chain(&weighed.columns);
            let with = board.fit(beside.cloned().collect())?;
            weighed.score += disc::score(board, &with, true).map_or(0.0, |more| more.max(0.0));
        }
        Some(weighed)
    };
    let own =
        score(found.hypothesis.clone(), found.columns.clone()).map_or(found.score, |w| w.score);
    let mut all: Vec<(Hypothesis, f64)> = alternatives(board, &without, found)
        .into_par_iter()
        .filter_map(|hypothesis| {
            let columns = hypothesis.columns(board);
            let weighed = refined(board, &without, score(hypothesis, columns)?);
            (!beyond_rigs(&weighed)).then_some((weighed.hypothesis, weighed.score))
        })
        .filter(|(hypothesis, _)| !nearly_whole(board, hypothesis))
        .collect();
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    (own, all)
}

/// What the look-alikes of a finding would make of its mark, and what else its own mechanism would.
fn alternatives(board: &Board, without: &Model, found: &Found) -> Vec<Hypothesis> {
    let Some(first) = board.benches.first() else {
        return Vec::new();
    };
    let setting = Setting {
        channels: channels(first.seen.classes),
        speed_rad_s: board.benches[shown_best(board, without, found)]
            .seen
            .mean_speed(),
    };
    let own = found.hypothesis.mechanism;
    std::iter::once(&own)
        .chain(own.look_alikes())
        .flat_map(|other| (other.card().handling.instead_of)(&found.hypothesis, setting))
        .collect()
}

/// Whether its order is said to be off a whole number, and the recordings are too short to say so.
fn nearly_whole(board: &Board, hypothesis: &Hypothesis) -> bool {
    const PART: f64 = 0.5;
    let turns = board.benches.iter().map(|bench| bench.seen.turns());
    let within = PART / turns.fold(1.0, f64::max);
    match hypothesis.bases.first() {
        Some(Basis::Lagged { order } | Basis::TorqueOrder { order }) => {
            order.fract() != 0.0 && (order - order.round()).abs() < within
        }
        _ => false,
    }
}

/// The recording in which a finding makes most of what a model without it leaves: what has a frequency there has an order by the speed
/// of that one.
fn shown_best(board: &Board, without: &Model, found: &Found) -> usize {
    let Some(gain) = board.gain(without, &found.columns) else {
        return 0;
    };
    let power = |bench: usize| {
        let mut sum = vec![0.0; board.benches[bench].seen.len()];
        for (column, size) in found.columns.iter().zip(gain.sizes.iter()) {
            for (sum, value) in sum.iter_mut().zip(column.0[bench].iter().flatten()) {
                *sum += size * value;
            }
        }
        sum.iter().map(|value| value * value).sum::<f64>()
    };
    let best = (0..board.benches.len()).max_by(|a, b| power(*a).total_cmp(&power(*b)));
    best.unwrap_or(0)
}

/// Mechanisms that leave the very same mark: no recording of edges tells them apart.
#[must_use]
pub fn same_mark(found: &Hypothesis) -> &'static [Mechanism] {
    found.mechanism.card().same_mark
}
