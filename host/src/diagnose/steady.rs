//! Whether what was found is the same from beginning to end, as a mechanism's mark is.
//!
//! Each finding is fitted once more to every part of the recordings; how much better the parts fit with sizes of their own says how
//! little one size explains them. Physics of another kind that only resembles a mechanism is told by this.

use nalgebra::{DMatrix, DVector};

use super::board::{Board, Column, Model, PARTS};

/// How steady a finding is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steadiness {
    /// Fall of the sum of squares with sizes of each part's own, above what that is by chance.
    pub squares: f64,
    /// Numbers that it took.
    pub numbers: f64,
}

impl Steadiness {
    /// Whether one size does not do: a good part of what the finding explains, and no accident.
    #[must_use]
    pub fn changes(self, explained: f64) -> bool {
        let chance = 6.0 * (2.0 * self.numbers).sqrt() + 20.0;
        self.squares > chance && self.squares > 0.12 * explained
    }
}

/// How steady some of a model's columns are.
#[must_use]
pub fn steadiness(board: &Board, model: &Model, columns: &[Column]) -> Steadiness {
    let (mut squares, mut numbers) = (0.0, 0.0);
    for (at, bench) in board.benches.iter().enumerate() {
        for part in 0..PARTS {
            let range = bench.part(part);
            let parts: Vec<&[f64]> = columns
                .iter()
                .filter_map(|column| column.0[at].as_ref().map(|c| &c[range.clone()]))
                .collect();
            if parts.is_empty() {
                continue;
            }
            let left = &model.left[at][range.clone()];
            let count = parts.len();
            let gram = DMatrix::from_fn(count, count, |i, j| product(parts[i], parts[j]));
            let right = DVector::from_fn(count, |i, _| product(parts[i], left));
            let scale = gram.diagonal().max();
            if let Some(solved) = (gram + DMatrix::identity(count, count) * (1e-9 * scale))
                .cholesky()
                .map(|c| c.solve(&right))
                && solved.iter().all(|x| x.is_finite())
            {
                squares += solved.dot(&right);
                numbers += count as f64;
            }
        }
    }
    let fitted = columns.len() as f64;
    let numbers = (numbers - fitted).max(1.0);
    Steadiness {
        squares: squares - numbers,
        numbers,
    }
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
