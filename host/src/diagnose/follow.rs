//! What was searched for, one finding after another, moved to where everything found together explains most.

use super::basis::Basis;
use super::board::Board;
use super::estimate::slopes_of;
use super::hypothesis::Hypothesis;
use super::least_squares::squares;
use super::refine::steps;
use super::search::Searched;

/// First steps of a search that a number may still move by.
const FAR: f64 = 2.0;
/// Times that all of them are moved.
const TIMES: usize = 4;
/// Standard errors that are no move any more.
const NEAR: f64 = 0.05;

/// Moves everything that was searched for by steps of Gauss and Newton, all of it and all sizes at once.
pub fn together(board: &Board, searched: &mut Searched) {
    for _ in 0..TIMES {
        if again(board, searched).is_none_or(|far| far < NEAR) {
            break;
        }
    }
}

/// One step, as long as it explains more; by how many standard errors, none where it does not.
fn again(board: &Board, searched: &mut Searched) -> Option<f64> {
    let slopes = slopes_of(board, searched);
    let first = searched.model.columns.len();
    let all = searched.model.columns.iter().chain(slopes.iter().flatten());
    let model = board.fit(all.cloned().collect())?;
    let mut at = first;
    let mut far = 0.0_f64;
    let mut moves = Vec::new();
    for (found, slopes) in searched.found.iter().zip(&slopes) {
        let own = at..at + slopes.len();
        at = own.end;
        // When a push begins and ends is no matter of slopes.
        let still = matches!(found.hypothesis.bases[..], [Basis::Load { .. }]);
        let moved = own.map(|i| {
            let by = if still { 0.0 } else { model.sizes[i] };
            far = far.max(by.abs() / model.covariance[(i, i)].sqrt());
            by
        });
        moves.push(moved.collect::<Vec<f64>>());
    }
    let before = squares(&searched.model);
    for share in [1.0, 0.3] {
        let part: Vec<Vec<f64>> = moves
            .iter()
            .map(|each| each.iter().map(|by| share * by).collect())
            .collect();
        let mut next = searched.clone();
        follow(board, &mut next, &part)?;
        if squares(&next.model) < before {
            *searched = next;
            return Some(far);
        }
    }
    None
}

/// Moves what was searched for, and fits the sizes there.
pub fn follow(board: &Board, searched: &mut Searched, by: &[Vec<f64>]) -> Option<()> {
    for (found, by) in searched.found.iter_mut().zip(by) {
        let hypothesis = moved(board, &found.hypothesis, by);
        let columns = hypothesis.columns(board);
        if columns.len() == found.columns.len() {
            found.hypothesis = hypothesis;
            found.columns = columns;
        }
    }
    let nuisances = searched.model.columns[..searched.nuisances].iter();
    let own = searched.found.iter().flat_map(|found| &found.columns);
    searched.model = board.fit(nuisances.chain(own).cloned().collect())?;
    Some(())
}

/// A hypothesis with what was searched for moved, no further than a search would.
#[must_use]
pub fn moved(board: &Board, hypothesis: &Hypothesis, by: &[f64]) -> Hypothesis {
    let mut moved = hypothesis.clone();
    let steps = steps(board, hypothesis);
    for ((change, step), by) in steps.iter().zip(by) {
        let by = by.clamp(-FAR * step, FAR * step);
        moved.bases.iter_mut().for_each(|basis| change(basis, by));
    }
    moved
}
