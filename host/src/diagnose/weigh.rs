//! What a hypothesis explains, and what it costs.

use std::collections::HashMap;

use super::basis::Basis;
use super::board::{Board, Column, Model};
use super::hypothesis::Hypothesis;

/// Columns that were made before, as long as the noise stays the same.
#[derive(Clone, Debug, Default)]
pub struct Shelf {
    columns: HashMap<String, Vec<Column>>,
}

impl Shelf {
    /// A hypothesis' columns.
    pub fn columns(&mut self, board: &Board, hypothesis: &Hypothesis) -> Vec<Column> {
        hypothesis
            .bases
            .iter()
            .flat_map(|basis| self.of(board, *basis))
            .collect()
    }

    fn of(&mut self, board: &Board, basis: Basis) -> Vec<Column> {
        let name = format!("{basis:?}");
        let made = self.columns.entry(name);
        made.or_insert_with(|| board.columns(basis)).clone()
    }
}

/// A hypothesis on top of a model.
#[derive(Clone, Debug)]
pub struct Weighed {
    /// It.
    pub hypothesis: Hypothesis,
    /// Its columns.
    pub columns: Vec<Column>,
    /// Fall of the sum of squares less what its numbers cost (Schwarz).
    pub score: f64,
}

/// Weighs a hypothesis; none where it can't be told from what is there.
#[must_use]
pub fn weigh(
    board: &Board,
    model: &Model,
    hypothesis: Hypothesis,
    columns: Vec<Column>,
) -> Option<Weighed> {
    let (shown, gain) = match board.gain(model, &columns) {
        Some(gain) => (columns, gain),
        // A column that does not show here may not keep the others from showing.
        None => {
            let shown: Vec<Column> = columns
                .iter()
                .filter(|column| board.gain(model, std::slice::from_ref(column)).is_some())
                .cloned()
                .collect();
            let gain = board.gain(model, &shown).filter(|_| !shown.is_empty())?;
            (shown, gain)
        }
    };
    let numbers = shown.len() + hypothesis.searched();
    let score = gain.squares - numbers as f64 * (board.edges() as f64).ln();
    Some(Weighed {
        hypothesis,
        columns: shown,
        score,
    })
}
