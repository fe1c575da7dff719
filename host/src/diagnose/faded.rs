//! What was found and is gone once the others are in the twin: a linear model leaves a little of what is large, and that looks like
//! mechanisms of its own, as an eccentric disc does beside every ripple that the twin declares.

use nalgebra::{DMatrix, DVector};

use super::estimate::Estimate;

/// Part of its squares that is left of what fades.
const PART: f64 = 0.25;
/// Squares over sizes of what may as well be nothing: the 95 % interval of one size holds 0.
const NOTHING: f64 = 3.84;

/// Squares of an estimate's sizes over their covariance.
#[must_use]
pub fn squares_of(estimate: &Estimate) -> f64 {
    let count = estimate.sizes.len();
    let covariance = estimate.covariance.view((0, 0), (count, count));
    // Of any unit: scaled to one before.
    let scale: Vec<f64> = (0..count).map(|i| covariance[(i, i)].sqrt()).collect();
    let scaled = DMatrix::from_fn(count, count, |i, j| {
        covariance[(i, j)] / (scale[i] * scale[j])
    });
    let sizes = DVector::from_fn(count, |i, _| estimate.sizes[i] / scale[i]);
    scaled
        .cholesky()
        .map_or(f64::INFINITY, |factor| sizes.dot(&factor.solve(&sizes)))
}

/// Squares of an estimate's sizes where it was found: a place, a time or a rate that is hardly known makes a size no less sure.
fn squares_there(estimate: &Estimate) -> f64 {
    let covariance = &estimate.covariance;
    let count = covariance.nrows();
    let scale: Vec<f64> = (0..count).map(|i| covariance[(i, i)].sqrt()).collect();
    let scaled = DMatrix::from_fn(count, count, |i, j| {
        covariance[(i, j)] / (scale[i] * scale[j])
    });
    let Some(factor) = scaled.cholesky() else {
        return f64::INFINITY;
    };
    let precision = factor.inverse();
    let sizes = estimate.sizes.len();
    let size = |i: usize| estimate.sizes[i] / scale[i];
    let each = (0..sizes).flat_map(|i| (0..sizes).map(move |j| (i, j)));
    each.map(|(i, j)| size(i) * precision[(i, j)] * size(j))
        .sum()
}

/// Estimates of which the mended twin leaves less than their numbers cost, and a small part of what they were; where there are none,
/// the weakest of those that may as well be nothing, as one of two findings at one place is.
#[must_use]
pub fn faded(numbers: &[Estimate], before: &[f64], edges: usize) -> Vec<usize> {
    let squares: Vec<f64> = numbers.iter().map(squares_of).collect();
    let each = numbers.iter().zip(before).zip(&squares).enumerate();
    let faded = each.filter(|(_, ((estimate, before), squares))| {
        let count = estimate.sizes.len() + estimate.searched.len();
        **squares < count as f64 * (edges as f64).ln() && **squares < PART * **before
    });
    let faded: Vec<usize> = faded.map(|(at, _)| at).collect();
    if !faded.is_empty() {
        return faded;
    }
    let share = |at: usize| squares_there(&numbers[at]) / numbers[at].sizes.len() as f64;
    let nothing = (0..numbers.len()).filter(|at| share(*at) < NOTHING);
    let weakest = nothing.min_by(|a, b| share(*a).total_cmp(&share(*b)));
    weakest.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::basis::Basis;
    use crate::diagnose::hypothesis::Hypothesis;
    use crate::diagnose::instants::Between;

    /// Of a ripple whose sizes, of so many standard errors, hang together by half.
    fn ripple(sizes: [f64; 2]) -> Estimate {
        let unit = [1e-6, 3e-3];
        Estimate {
            hypothesis: Hypothesis::by(Basis::TorqueOrder { order: 14.0 }),
            sizes: vec![sizes[0] * unit[0], sizes[1] * unit[1]],
            searched: Vec::new(),
            covariance: DMatrix::from_fn(2, 2, |i, j| {
                unit[i] * unit[j] * if i == j { 1.0 } else { 0.5 }
            }),
            between: Between::default(),
        }
    }

    #[test]
    fn what_a_mended_twin_leaves_little_of_fades_and_what_was_small_before_does_not() {
        assert!((squares_of(&ripple([3.0, 0.0])) - 12.0).abs() < 1e-9);
        let before: Vec<f64> = [[9.0, 0.0], [2.0, 0.0], [60.0, 0.0]]
            .map(|sizes| squares_of(&ripple(sizes)))
            .to_vec();
        let after = [[1.0, 0.5], [3.0, 0.2], [8.0, 0.0]].map(ripple);
        assert_eq!(faded(&after, &before, 20_000), [0]);
    }

    #[test]
    fn of_two_that_may_as_well_be_nothing_the_weaker_fades() {
        let there = [[1.5, 0.9], [1.2, 0.9], [8.0, 0.0]].map(ripple);
        let before: Vec<f64> = there.iter().map(squares_of).collect();
        assert_eq!(faded(&there, &before, 20_000), [1]);
        assert!(faded(&there[2..], &before[2..], 20_000).is_empty());
    }
}
