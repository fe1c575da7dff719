//! Columns of a pattern in recordings that there are, which are known, and in one more, which was simulated.

use crate::diagnose::basis::Basis;
use crate::diagnose::board::{Board, Column};
use crate::diagnose::hypothesis::Hypothesis;

/// A mechanism with its columns in the recordings that there are.
#[derive(Clone, Debug)]
pub struct Known {
    /// It.
    pub hypothesis: Hypothesis,
    /// Its columns there.
    pub columns: Vec<Column>,
}

impl Known {
    /// Of a hypothesis in the recordings that there are.
    #[must_use]
    pub fn of(hypothesis: Hypothesis, board: &Board) -> Self {
        let columns = hypothesis.columns(board).into_iter();
        Self {
            columns: columns.map(Column::kept).collect(),
            hypothesis,
        }
    }

    /// Its columns in all recordings of a board, whose last one is new.
    #[must_use]
    pub fn extended(&self, board: &Board) -> Vec<Column> {
        let count = board.benches.len() - 1;
        let mut at = 0;
        let each = self.hypothesis.bases.iter().flat_map(|basis| {
            let own = own(*basis, board.tied);
            let columns = basis.count() * if own { count } else { 1 };
            let known = self.columns.get(at..at + columns).unwrap_or_default();
            at += columns;
            let new = last(board).columns(*basis);
            if own {
                beside(known, new, count)
            } else {
                let pairs = known.iter().cloned().zip(new);
                pairs
                    .map(|(mut known, new)| {
                        known.0.extend(new.0);
                        known
                    })
                    .collect()
            }
        });
        each.map(Column::kept).collect()
    }
}

/// What is nobody's finding in all recordings of a board, whose last one is new.
#[must_use]
pub fn nuisances(known: &[Column], board: &Board) -> Vec<Column> {
    beside(known, last(board).nuisances(), board.benches.len() - 1)
}

/// Columns of so many recordings that there are, and columns of the new one's own.
fn beside(known: &[Column], new: Vec<Column>, count: usize) -> Vec<Column> {
    let padded = known.iter().cloned().map(|mut column| {
        column.0.push(None);
        column
    });
    let own = new.into_iter().map(|column| {
        let mut all = vec![None; count];
        all.extend(column.0);
        Column(all)
    });
    padded.chain(own).collect()
}

/// The new recording alone.
fn last(board: &Board) -> Board {
    Board {
        benches: board.benches.last().cloned().into_iter().collect(),
        tied: board.tied,
        clear: std::sync::OnceLock::new(),
        products: board.products.clone(),
    }
}

/// Whether each of several recordings has a size of its own, as in [`Board::raw_columns`].
const fn own(basis: Basis, tied: bool) -> bool {
    basis.timed() || (basis.placed() && !tied)
}
