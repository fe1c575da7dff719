//! What everything that was found makes of the angles.

use super::board::{Board, Column};
use super::column::product;
use super::search::{Found, Searched};

impl Searched {
    /// What everything found makes of the angles of each recording, rad.
    #[must_use]
    pub fn explained(&self, board: &Board) -> Vec<Vec<f64>> {
        let mut sums: Vec<Vec<f64>> = board
            .benches
            .iter()
            .map(|b| vec![0.0; b.seen.len()])
            .collect();
        // White, what is explained is what is not left; the noise needs it as angles, and those come from the patterns anew.
        for (bases, sizes) in self.sized(board) {
            for (columns, size) in bases.iter().zip(sizes) {
                for (sum, part) in sums.iter_mut().zip(&columns.0) {
                    if let Some(part) = part {
                        for (sum, value) in sum.iter_mut().zip(part) {
                            *sum += size * value;
                        }
                    }
                }
            }
        }
        sums
    }

    /// Columns as angles, not white, with their sizes.
    fn sized(&self, board: &Board) -> Vec<(Vec<Column>, Vec<f64>)> {
        let mut at = self.nuisances;
        let mut all = vec![(
            board.raw_nuisances(),
            self.model.sizes.as_slice()[..self.nuisances].to_vec(),
        )];
        for found in &self.found {
            let sizes = self.model.sizes.as_slice()[at..at + found.columns.len()].to_vec();
            at += found.columns.len();
            let raw = shown(board, found);
            if raw.len() == sizes.len() {
                all.push((raw, sizes));
            }
        }
        all
    }
}

/// A finding's columns as angles, without those that did not show beside what was found before.
fn shown(board: &Board, found: &Found) -> Vec<Column> {
    /// What the same column has in common at the least, were it made in other surroundings.
    const SAME: f64 = 0.99;
    let raw = found.hypothesis.raw_columns(board);
    if raw.len() == found.columns.len() {
        return raw;
    }
    let white = found.hypothesis.columns(board);
    let mut own = found.columns.iter().peekable();
    let each = raw
        .into_iter()
        .zip(&white)
        .filter(|(_, white)| own.next_if(|own| alike(own, white) > SAME).is_some());
    each.map(|(raw, _)| raw).collect()
}

/// Cosine of the angle between two columns.
fn alike(a: &Column, b: &Column) -> f64 {
    let square = |column: &Column| product(column, column);
    product(a, b) / (square(a) * square(b)).sqrt()
}
