//! What each finding makes of the angles.

use super::basis::Basis;
use super::board::{Board, Column};
use super::search::Searched;

/// What a finding makes of the recording that shows it best.
#[derive(Debug)]
pub struct Mark {
    /// Recording.
    pub bench: usize,
    /// Its first pattern.
    pub basis: Basis,
    /// Angles, rad.
    pub angles: Vec<f64>,
    /// The same, white.
    pub white: Vec<f64>,
    /// What all findings leave, white.
    pub left: Vec<f64>,
}

/// Marks of everything found.
#[must_use]
pub fn marks(board: &Board, chosen: &Searched) -> Vec<Mark> {
    let mut at = chosen.nuisances;
    let each = chosen.found.iter().map(|found| {
        let sizes = &chosen.model.sizes.as_slice()[at..at + found.columns.len()];
        at += found.columns.len();
        let raw = found.hypothesis.raw_columns(board);
        let sum = |columns: &[Column], bench: usize| {
            let mut sum = vec![0.0; board.benches[bench].seen.len()];
            for (column, size) in columns.iter().zip(sizes) {
                for (sum, value) in sum.iter_mut().zip(column.0[bench].iter().flatten()) {
                    *sum += size * value;
                }
            }
            sum
        };
        let power = |bench: usize| {
            sum(&found.columns, bench)
                .iter()
                .map(|w| w * w)
                .sum::<f64>()
        };
        let bench = (0..board.benches.len())
            .max_by(|a, b| power(*a).total_cmp(&power(*b)))
            .unwrap_or(0);
        Mark {
            bench,
            basis: found.hypothesis.bases[0],
            angles: sum(&raw, bench),
            white: sum(&found.columns, bench),
            left: chosen.model.left[bench].clone(),
        }
    });
    each.collect()
}
