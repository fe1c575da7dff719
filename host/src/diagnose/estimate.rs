//! Numbers of what was found, with their covariance: what is searched for and what sizes it, fitted together.

use nalgebra::{DMatrix, DVector};

use super::board::{Board, Column, Model, PARTS};
use super::disc::put_back;
use super::hypothesis::Hypothesis;
use super::instants::Between;
use super::joined;
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
    /// Numbers that have no such covariance.
    pub between: Between,
}

/// Estimates of everything found, in the same order.
#[must_use]
pub fn estimates(board: &Board, searched: &Searched) -> Vec<Estimate> {
    let mut columns: Vec<Column> = searched.model.columns.clone();
    let mut ranges = Vec::new();
    let mut at = searched.nuisances;
    for (found, slopes) in searched.found.iter().zip(slopes_of(board, searched)) {
        let sizes = searched.model.sizes.as_slice()[at..at + found.columns.len()].to_vec();
        let first = columns.len();
        columns.extend(slopes);
        ranges.push((at, sizes, first, columns.len()));
        at += found.columns.len();
    }
    // Where a searched number can't be told from a size, the sizes alone have to do.
    let mut fitted: Option<Model> = board.fit(columns);
    if let (Some(model), Some(pattern)) = (&mut fitted, &searched.pattern) {
        let there = put_back(board, model, pattern);
        if let Some(covariance) = joined::covariance(board, &model.columns, &there, pattern) {
            model.covariance = covariance;
        }
    }
    let variance = spread(&searched.model).max(1.0);
    let wider = widened(board, fitted.as_ref().unwrap_or(&searched.model));
    ranges
        .into_iter()
        .zip(&searched.found)
        .map(|((at, sizes, first, end), found)| {
            let (model, all): (&Model, Vec<usize>) = match &fitted {
                Some(model) => (model, (at..at + sizes.len()).chain(first..end).collect()),
                None => (&searched.model, (at..at + sizes.len()).collect()),
            };
            let covariance = DMatrix::from_fn(all.len(), all.len(), |i, j| {
                let (i, j) = (all[i], all[j]);
                let wider = (wider[i].max(variance) * wider[j].max(variance)).sqrt();
                wider * model.covariance[(i, j)]
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
                between: Between::default(),
            }
        })
        .collect()
}

/// How the angles change with what was searched for, finding by finding.
#[must_use]
pub fn slopes_of(board: &Board, searched: &Searched) -> Vec<Vec<Column>> {
    let mut at = searched.nuisances;
    let each = searched.found.iter().map(|found| {
        let sizes = &searched.model.sizes.as_slice()[at..at + found.columns.len()];
        at += found.columns.len();
        let steps = steps(board, &found.hypothesis);
        slopes(board, &found.hypothesis, sizes, &steps)
    });
    each.collect()
}

/// How much larger the variance of each number of a model is than noise makes it, by how it scatters from part to part of the
/// recordings: 1 unless it scatters by more than chance. What is left and is no noise moves numbers as well, and the fit alone
/// does not know (the sandwich of H. White, Econometrica 50, 1982, with each part as one observation).
fn widened(board: &Board, model: &Model) -> Vec<f64> {
    /// Standard errors of a variance that chance seldom makes.
    const CHANCE: f64 = 3.5;
    let count = model.columns.len();
    // What each part adds to each number: as it is, and the variance that noise gives it.
    let (mut sum, mut noise, mut noise2) = (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
    for (at, bench) in board.benches.iter().enumerate() {
        for part in 0..PARTS {
            let range = bench.part(part);
            let left = &model.left[at][range.clone()];
            let parts: Vec<Option<&[f64]>> = model
                .columns
                .iter()
                .map(|column| column.0[at].as_ref().map(|c| &c[range.clone()]))
                .collect();
            let product = |i: usize, other: &[f64]| {
                let own = parts[i].iter().flat_map(|own| own.iter());
                own.zip(other).map(|(a, b)| a * b).sum::<f64>()
            };
            let pull = DVector::from_fn(count, |i, _| product(i, left));
            let gram = DMatrix::from_fn(count, count, |i, j| {
                parts[j].map_or(0.0, |other| product(i, other))
            });
            let moved = &model.covariance * pull;
            let expected = &model.covariance * gram * &model.covariance;
            for i in 0..count {
                sum[i] += moved[i] * moved[i];
                noise[i] += expected[(i, i)];
                noise2[i] += expected[(i, i)] * expected[(i, i)];
            }
        }
    }
    (0..count)
        .map(|i| {
            let parts = noise[i] * noise[i] / noise2[i];
            let ratio = sum[i] / noise[i];
            let seldom = 1.0 + CHANCE * (2.0 / parts).sqrt();
            if ratio.is_finite() && ratio > seldom {
                ratio
            } else {
                1.0
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
