//! What mended twins leave of the numbers of findings.

use super::basis::Basis;
use super::board::Board;
use super::estimate::Estimate;
use super::follow::moved;
use super::hypothesis::Hypothesis;
use super::refine::{slopes, steps};
use super::search::Searched;

/// What is left of one finding's numbers against mended twins.
#[derive(Clone, Debug)]
pub struct Rest {
    /// Of its sizes.
    sizes: Vec<f64>,
    /// Of what was searched for; empty where that does not go by slopes.
    searched: Vec<f64>,
}

/// What is left of the numbers of what was `chosen` against mended twins.
#[must_use]
pub fn rests(board: &Board, chosen: &Searched, numbers: &[Estimate]) -> Option<Vec<Rest>> {
    let mut columns = board.nuisances();
    let mut ranges = Vec::new();
    for (found, number) in chosen.found.iter().zip(numbers) {
        let own = number.hypothesis.columns(board);
        // One that does not show was left out of the fit.
        let shows = own.len() == found.columns.len();
        let first = columns.len();
        columns.extend(if shows { own } else { found.columns.clone() });
        let sizes = columns.len();
        if shows && goes_by_slopes(&number.hypothesis) {
            let steps = steps(board, &number.hypothesis);
            columns.extend(slopes(board, &number.hypothesis, &number.sizes, &steps));
        }
        ranges.push([first, sizes, columns.len()]);
    }
    let model = board.fit(columns)?;
    let sizes = model.sizes.as_slice();
    let rest = |[first, middle, end]: [usize; 3]| Rest {
        sizes: sizes[first..middle].to_vec(),
        searched: sizes[middle..end].to_vec(),
    };
    Some(ranges.into_iter().map(rest).collect())
}

/// Times have likelihoods of their own (see [`super::instants`]).
fn goes_by_slopes(hypothesis: &Hypothesis) -> bool {
    !matches!(
        hypothesis.bases.first(),
        Some(Basis::Load { .. } | Basis::LevelDrift { .. })
    )
}

/// Largest rest in standard errors.
#[must_use]
pub fn far(numbers: &[Estimate], rests: &[Rest]) -> f64 {
    let each = numbers.iter().zip(rests).flat_map(|(number, rest)| {
        let all = rest.sizes.iter().chain(&rest.searched).enumerate();
        let known = all.take(number.covariance.nrows());
        known
            .map(|(i, rest)| rest.abs() / number.covariance[(i, i)].sqrt())
            .collect::<Vec<_>>()
    });
    each.fold(0.0, f64::max)
}

impl Rest {
    /// Adds it to the numbers that it is of.
    pub fn add_to(self, board: &Board, number: &mut Estimate) {
        for (size, rest) in number.sizes.iter_mut().zip(self.sizes) {
            *size += rest;
        }
        number.hypothesis = moved(board, &number.hypothesis, &self.searched);
    }
}
