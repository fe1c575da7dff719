//! Which of several hypotheses explains most of what a model leaves.

use super::board::{Board, Model};
use super::hypothesis::Hypothesis;
use super::refine::refined;
use super::search::Found;
use super::sift::{beyond_rigs, stands, trifle};
use super::weigh::{Shelf, Weighed, weigh};
use crate::mechanism::Mechanism;

/// The best hypothesis on top of a model.
#[must_use]
pub fn best(
    board: &Board,
    model: &Model,
    shelf: &mut Shelf,
    proposed: Vec<Hypothesis>,
) -> Option<Found> {
    let mut tried: Vec<Weighed> = proposed
        .into_iter()
        .filter_map(|hypothesis| {
            let columns = shelf.columns(board, &hypothesis);
            weigh(board, model, hypothesis, columns)
        })
        .filter(|one| !trifle(board, model, one) && !stands(board, one))
        .filter(|one| !beyond_rigs(board, model, one))
        .collect();
    tried.sort_by(|a, b| b.score.total_cmp(&a.score));
    let top = tried.first()?.score;
    // Only what may win is worth a closer look: a frequency a little off costs a good part. Of one kind, the best will do.
    let mut closer: Vec<Weighed> = Vec::new();
    let mut kinds: Vec<(Mechanism, i64)> = Vec::new();
    for one in tried {
        let kind = (
            one.hypothesis.mechanism,
            one.hypothesis.rhythm().map_or(0, |r| (8.0 * r) as i64),
        );
        let again = kinds.iter().filter(|k| **k == kind).count();
        if one.score < 0.5 * top || again >= 1 || closer.len() >= 6 {
            continue;
        }
        kinds.push(kind);
        closer.push(refined(board, model, one));
    }
    closer.retain(|one| !stands(board, one));
    closer.sort_by(|a, b| b.score.total_cmp(&a.score));
    let mut closer = closer.into_iter();
    let first = closer.next()?;
    Some(Found {
        hypothesis: first.hypothesis,
        columns: first.columns,
        score: first.score,
        rivals: closer.map(|one| (one.hypothesis, one.score)).collect(),
    })
}
