//! What a hypothesis explains, and what it costs.

use std::collections::HashMap;

use rayon::prelude::*;

use super::basis::Basis;
use super::board::{Board, Column, Gain, Model};
use super::hypothesis::Hypothesis;
use super::search::Found;

/// Columns that were made before, as long as the noise stays the same.
#[derive(Clone, Debug, Default)]
pub struct Shelf {
    columns: HashMap<String, Vec<Column>>,
}

impl Shelf {
    /// Makes what some hypotheses' columns lack, all at once.
    pub fn fill(&mut self, board: &Board, hypotheses: &[Hypothesis]) {
        let mut lacks: Vec<(String, Basis)> = Vec::new();
        for basis in hypotheses.iter().flat_map(|one| &one.bases) {
            let name = name(*basis);
            if !self.columns.contains_key(&name) && !lacks.iter().any(|(other, _)| *other == name) {
                lacks.push((name, *basis));
            }
        }
        let made = lacks.into_par_iter();
        let made = made.map(|(name, basis)| (name, kept(board, basis)));
        self.columns.extend(made.collect::<Vec<_>>());
    }

    /// A hypothesis' columns, which were made before.
    #[must_use]
    pub fn filled(&self, hypothesis: &Hypothesis) -> Vec<Column> {
        let each = hypothesis.bases.iter();
        each.flat_map(|basis| self.columns.get(&name(*basis)).cloned().unwrap_or_default())
            .collect()
    }

    /// A hypothesis' columns.
    pub fn columns(&mut self, board: &Board, hypothesis: &Hypothesis) -> Vec<Column> {
        hypothesis
            .bases
            .iter()
            .flat_map(|basis| self.of(board, *basis))
            .collect()
    }

    fn of(&mut self, board: &Board, basis: Basis) -> Vec<Column> {
        let made = self.columns.entry(name(basis));
        made.or_insert_with(|| kept(board, basis)).clone()
    }
}

/// A pattern's columns, which are weighed again and again.
fn kept(board: &Board, basis: Basis) -> Vec<Column> {
    let columns = board.columns(basis).into_iter();
    columns.map(Column::kept).collect()
}

/// What tells a pattern from all others.
fn name(basis: Basis) -> String {
    format!("{basis:?}")
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
    /// What they would do.
    pub gain: Gain,
}

impl From<Weighed> for Found {
    fn from(weighed: Weighed) -> Self {
        Self {
            hypothesis: weighed.hypothesis,
            columns: weighed.columns,
            score: weighed.score,
            rivals: Vec::new(),
        }
    }
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
        gain,
    })
}
