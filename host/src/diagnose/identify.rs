//! Which of the twins' numbers these recordings can determine: singular values of the whitened regressors.
//!
//! Each number's column is what a change of the number by all of its value does, in deviations of the noise, beside what nobody knows of
//! any rig. A column that is short shows nothing. Of the others, each scaled to unit length, a direction with a small singular value is a
//! combination that changes next to nothing: its numbers are known by their other combinations alone (D. A. Belsley, E. Kuh, R. E. Welsch,
//! Regression Diagnostics, 1980, ch. 3).

use nalgebra::DMatrix;

use super::correct::Slopes;
use super::lsq::{Basis, add, dot};
use super::model::{Board, Fit};

/// Deviations that a whole number has to show.
const SHOWS: f64 = 3.0;
/// Square of a singular value below which its direction is not determined: two columns of correlation 1 - 1e-4 have it.
const FLAT: f64 = 1e-4;
/// Part of the greatest share of a direction that a number has to have to be of its group, and by which shares differ that are not alike.
const PART: f64 = 0.3;

/// What the twins declare and these recordings do not determine beside a fit, in words: one entry a number or a group of numbers. Of a
/// group that only shows together a fit has one number at the most, as the others then have no column of their own.
pub fn open(board: &Board, slopes: &[Slopes], fit: &Fit) -> Vec<String> {
    use rayon::prelude::*;
    let basis = fit.basis();
    let mut words = Vec::new();
    // What of its columns is its own: each value by its declared size.
    let columns: Vec<Vec<f64>> = slopes
        .par_iter()
        .map(|slopes| along(&slopes.white(board), &slopes.declared, &basis))
        .collect();
    let mut shown: Vec<usize> = Vec::new();
    for (at, column) in columns.iter().enumerate() {
        if dot(column, column).sqrt() < SHOWS {
            words.push(format!("{}: does not show here", slopes[at].knob.path()));
        } else {
            shown.push(at);
        }
    }
    let count = shown.len();
    if count == 0 {
        return words;
    }
    let size = |at: usize| dot(&columns[at], &columns[at]).sqrt();
    let gram = DMatrix::from_fn(count, count, |a, b| {
        let (a, b) = (shown[a], shown[b]);
        dot(&columns[a], &columns[b]) / (size(a) * size(b))
    });
    let decomposed = gram.symmetric_eigen();
    for (direction, square) in decomposed
        .eigenvectors
        .column_iter()
        .zip(decomposed.eigenvalues.iter())
    {
        if *square > FLAT {
            continue;
        }
        let most = direction.amax();
        let group = (0..count).filter(|at| direction[*at].abs() > PART * most);
        let group: Vec<usize> = group.collect();
        // The direction is of columns of unit length: in factors each share is over its column's length.
        let factors = group.iter().map(|at| direction[*at] / size(shown[*at]));
        let known = known_by(&factors.collect::<Vec<f64>>());
        let names = group.iter().map(|at| slopes[shown[*at]].knob.path());
        let names: Vec<String> = names.map(ToString::to_string).collect();
        words.push(match &names[..] {
            [others @ .., last] if !others.is_empty() => {
                format!("{} and {last}: {known}", others.join(", "))
            }
            _ => format!("{}: {known}", names.concat()),
        });
    }
    words
}

/// What a change of a knob by all of its value does beside a basis.
fn along(white: &[Vec<f64>], values: &[f64], basis: &Basis) -> Vec<f64> {
    let mut sum = vec![0.0; white.first().map_or(0, Vec::len)];
    for (column, value) in white.iter().zip(values) {
        add(&mut sum, *value, column);
    }
    basis.clear(&mut sum);
    sum
}

/// What of a group shows: along its flat direction all change by the same factor, or one by the inverse of the other's.
fn known_by(factors: &[f64]) -> &'static str {
    let most = factors.iter().fold(0.0, |most: f64, by| most.max(by.abs()));
    let alike = factors.iter().all(|by| by.abs() > (1.0 - PART) * most);
    let same_sign = factors.iter().all(|by| by * factors[0] > 0.0);
    match (alike, same_sign, factors.len()) {
        (true, true, 2) => "only their ratio shows",
        (true, true, _) => "only their ratios show",
        (true, false, 2) => "only their product shows",
        _ => "only combinations of them show",
    }
}
