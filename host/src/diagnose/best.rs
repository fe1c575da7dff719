//! The best of what may be missing on top of what was found.

use rayon::prelude::*;

use super::aliases::unaliased;
use super::basis::Basis;
use super::board::{Board, Column, Model};
use super::hypothesis::Hypothesis;
use super::refine::refined;
use super::search::Found;
use super::sift::{beyond_rigs, stands, trifle};
use super::weigh::{Shelf, Weighed, weigh};
use crate::mechanism::Mechanism;

/// The best hypothesis on top of a model.
pub fn best(
    board: &Board,
    model: &Model,
    shelf: &mut Shelf,
    proposed: Vec<Hypothesis>,
) -> Option<Found> {
    shelf.fill(board, &proposed);
    let shelf = &*shelf;
    let mut tried: Vec<Weighed> = proposed
        .into_par_iter()
        .filter_map(|hypothesis| {
            let columns = shelf.filled(&hypothesis);
            weigh(board, model, hypothesis, columns)
        })
        .collect();
    tried.sort_by(|a, b| b.score.total_cmp(&a.score));
    let mut closer = closer(board, model, &tried);
    if closer.is_empty() {
        // A drift that came out as none hides what is there beside it.
        tried.retain(|one| !drifts(one));
        closer = self::closer(board, model, &tried);
    }
    let mut closer = closer.into_iter();
    let first = unaliased(board, model, closer.next()?);
    Some(Found {
        hypothesis: first.hypothesis,
        columns: first.columns.into_iter().map(Column::kept).collect(),
        score: first.score,
        rivals: closer.map(|one| (one.hypothesis, one.score)).collect(),
    })
}

fn drifts(one: &Weighed) -> bool {
    matches!(one.hypothesis.bases.first(), Some(Basis::LevelDrift { .. }))
}

/// Those that may win, refined, best first; those far behind the best are looked at no further.
fn closer(board: &Board, model: &Model, tried: &[Weighed]) -> Vec<Weighed> {
    let may = |one: &Weighed| !trifle(board, one) && !stands(board, one) && !beyond_rigs(one);
    let Some(first) = tried.iter().position(may) else {
        return Vec::new();
    };
    let top = tried[first].score;
    // Only what may win is worth a closer look: a frequency a little off costs a good part. Of one kind, the best will do.
    let mut closer: Vec<Weighed> = Vec::new();
    let mut kinds: Vec<(Mechanism, i64)> = Vec::new();
    for one in &tried[first..] {
        if one.score < 0.5 * top || closer.len() >= 6 {
            break;
        }
        let kind = (
            one.hypothesis.mechanism,
            one.hypothesis.rhythm().map_or(0, |r| (8.0 * r) as i64),
        );
        let again = kinds.iter().filter(|k| **k == kind).count();
        if again >= 1 || !may(one) {
            continue;
        }
        kinds.push(kind);
        closer.push(one.clone());
    }
    let refined = closer.into_par_iter().map(|one| refined(board, model, one));
    let mut closer: Vec<Weighed> = refined.collect();
    closer.retain(|one| !stands(board, one));
    closer.sort_by(|a, b| b.score.total_cmp(&a.score));
    closer
}
