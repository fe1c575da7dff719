//! Numbers of what was found, with their covariance: what is searched for and what sizes it, fitted together.

use nalgebra::DMatrix;

use super::board::{Board, Column, Model};
use super::hypothesis::Hypothesis;
use super::refine::{slopes, steps};
use super::search::Searched;

/// One finding's numbers.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// The hypothesis with what is searched for as it fits best.
    pub hypothesis: Hypothesis,
    /// Sizes, column by column.
    pub sizes: Vec<f64>,
    /// How much each searched number is off, and its standard error, in the order of [`steps`].
    pub searched: Vec<f64>,
    /// Covariance of sizes and searched numbers.
    pub covariance: DMatrix<f64>,
}

/// Estimates of everything found, in the same order.
#[must_use]
pub fn estimates(board: &Board, searched: &Searched) -> Vec<Estimate> {
    let mut columns: Vec<Column> = searched.model.columns.clone();
    let mut ranges = Vec::new();
    let mut at = searched.nuisances;
    for found in &searched.found {
        let sizes = searched.model.sizes.as_slice()[at..at + found.columns.len()].to_vec();
        let first = columns.len();
        let steps = steps(board, &found.hypothesis);
        columns.extend(slopes(board, &found.hypothesis, &sizes, &steps));
        ranges.push((at, sizes, first, columns.len()));
        at += found.columns.len();
    }
    // Where a searched number can't be told from a size, the sizes alone have to do.
    let fitted: Option<Model> = board.fit(columns);
    let variance = spread(&searched.model).max(1.0);
    ranges
        .into_iter()
        .zip(&searched.found)
        .map(|((at, sizes, first, end), found)| {
            let (model, all): (&Model, Vec<usize>) = match &fitted {
                Some(model) => (model, (at..at + sizes.len()).chain(first..end).collect()),
                None => (&searched.model, (at..at + sizes.len()).collect()),
            };
            let covariance = DMatrix::from_fn(all.len(), all.len(), |i, j| {
                variance * model.covariance[(all[i], all[j])]
            });
            let off = if fitted.is_some() {
                (first..end).map(|i| model.sizes[i]).collect()
            } else {
                Vec::new()
            };
            Estimate {
                hypothesis: found.hypothesis.clone(),
                sizes,
                searched: off,
                covariance,
            }
        })
        .collect()
}

/// Variance of what is left.
#[must_use]
pub fn spread(model: &Model) -> f64 {
    let (sum, count) = model
        .left
        .iter()
        .flatten()
        .fold((0.0, 0.0), |(sum, count), w| (sum + w * w, count + 1.0));
    sum / f64::max(count, 1.0)
}
