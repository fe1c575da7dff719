//! What mended twins leave of the sizes of findings.

use super::board::Board;
use super::estimate::Estimate;
use super::search::Searched;

/// What is left of each finding's sizes against mended twins.
#[must_use]
pub fn rests(board: &Board, chosen: &Searched) -> Option<Vec<Vec<f64>>> {
    let mut columns = board.nuisances();
    let mut at = columns.len();
    let mut ranges = Vec::new();
    for found in &chosen.found {
        let own = found.hypothesis.columns(board);
        // One that does not show was left out of the fit.
        let own = if own.len() == found.columns.len() {
            own
        } else {
            found.columns.clone()
        };
        ranges.push(at..at + own.len());
        at += own.len();
        columns.extend(own);
    }
    let model = board.fit(columns)?;
    let sizes = model.sizes.as_slice();
    Some(
        ranges
            .into_iter()
            .map(|range| sizes[range].to_vec())
            .collect(),
    )
}

/// Largest rest in standard errors.
#[must_use]
pub fn far(numbers: &[Estimate], rests: &[Vec<f64>]) -> f64 {
    let each = numbers.iter().zip(rests).flat_map(|(number, rest)| {
        let rest = rest.iter().enumerate();
        rest.map(|(i, rest)| rest.abs() / number.covariance[(i, i)].sqrt())
            .collect::<Vec<_>>()
    });
    each.fold(0.0, f64::max)
}
