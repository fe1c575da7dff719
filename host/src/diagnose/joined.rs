//! Findings and a whole pattern of the disc, fitted together.
//!
//! A pattern that was learned first holds a part of every torque and rhythm that the disc can make as well, and a finding that was
//! sized with the pattern held still has the rest of it. Together they minimize |y - C b - D x|^2 + x' x / s^2, b being sizes and x the
//! pattern: x is solved by conjugate gradients, b by Newton's steps with x eliminated (Schur's complement), in which the disc is taken
//! to show alike all round.

use nalgebra::{DMatrix, DVector};

use super::board::{Board, Column, product};
use super::disc::{Pattern, put_back, size, white_of};
use super::disc_shown::Disc;
use super::estimate::slopes_of;
use super::follow::follow;
use super::search::Searched;

/// Newton's steps at the most.
const STEPS: usize = 5;
/// Standard errors that are no step any more.
const NEAR: f64 = 0.1;

/// Fits what was found and the pattern that was taken off together; what was searched for goes along.
pub fn join(board: &mut Board, searched: &mut Searched) {
    let Some(mut pattern) = searched.pattern.take() else {
        return;
    };
    joined(board, searched, &mut pattern);
    searched.pattern = Some(pattern);
}

fn joined(board: &mut Board, searched: &mut Searched, pattern: &mut Pattern) -> Option<()> {
    let first = searched.model.columns.len();
    let mut columns = searched.model.columns.clone();
    let slopes = slopes_of(board, searched);
    let counts: Vec<usize> = slopes.iter().map(Vec::len).collect();
    columns.extend(slopes.into_iter().flatten());
    let mut model = board.fit(columns.clone())?;
    let (beside, prior) = {
        let disc = Disc::of(board)?;
        let there = put_back(board, &model, pattern);
        if let Some(white_rad) = white_of(&disc, &there) {
            pattern.white_rad = white_rad;
        }
        let prior = prior(&disc, &there, pattern);
        (Beside::of(&disc, &columns, &prior)?, prior)
    };
    for _ in 0..STEPS {
        let disc = Disc::of(board)?;
        let kept = disc.weighted(&pattern.errors_rad, &|m| prior[m].recip());
        let pulled = |left: Vec<Vec<f64>>| -> Vec<f64> {
            let pulled = disc.own(&disc.folded(left));
            pulled.iter().zip(&kept).map(|(a, b)| a - b).collect()
        };
        let step = beside.step(&disc, &prior, &pulled(model.left.clone()));
        let mut left = model.left.clone();
        for (column, size) in columns.iter().zip(step.iter()) {
            for (row, part) in left.iter_mut().zip(&column.0) {
                for (value, part) in row.iter_mut().zip(part.iter().flatten()) {
                    *value -= size * part;
                }
            }
        }
        let more = disc.solved(pulled(left), &prior, &|_| true);
        let far = (0..columns.len())
            .map(|i| step[i].abs() / beside.covariance[(i, i)].sqrt())
            .fold(0.0, f64::max);
        for (error, more) in pattern.errors_rad.iter_mut().zip(&more) {
            *error += more;
        }
        board.take_off(&more);
        model = board.fit(columns.clone())?;
        if far < NEAR {
            break;
        }
    }
    (pattern.rms_rad, pattern.standard_error_rad) =
        size(&Disc::of(board)?, &pattern.errors_rad, &prior);
    let mut at = first;
    let each = counts.into_iter().map(|count| {
        at += count;
        model.sizes.as_slice()[at - count..at].to_vec()
    });
    follow(board, searched, &each.collect::<Vec<_>>())
}

/// Covariance of sizes of columns beside a pattern that is not known either; none where the pattern could be all of one of them.
#[must_use]
pub fn covariance(
    board: &Board,
    columns: &[Column],
    left: &[Vec<f64>],
    pattern: &Pattern,
) -> Option<DMatrix<f64>> {
    let disc = Disc::of(board)?;
    let prior = prior(&disc, left, pattern);
    Some(Beside::of(&disc, columns, &prior)?.covariance)
}

/// Variance of each of the pattern's orders, from rows with the pattern in them.
fn prior(disc: &Disc<'_>, there: &[Vec<f64>], pattern: &Pattern) -> Vec<f64> {
    let spectrum = disc.spectrum(disc.own(&disc.folded(there.to_vec())));
    disc.prior(&spectrum, pattern.white_rad * pattern.white_rad)
}

/// Columns beside a pattern.
struct Beside {
    /// How strongly each pulls at every edge.
    pulls: Vec<Vec<f64>>,
    /// Covariance of their sizes, the pattern being unknown.
    covariance: DMatrix<f64>,
}

impl Beside {
    fn of(disc: &Disc<'_>, columns: &[Column], prior: &[f64]) -> Option<Self> {
        let count = columns.len();
        let pulls: Vec<Vec<f64>> = columns
            .iter()
            .map(|column| disc.own(&disc.folded(disc.whole(column))))
            .collect();
        let errors: Vec<Vec<f64>> = pulls.iter().map(|p| known(disc, prior, p)).collect();
        let mut gram = DMatrix::zeros(count, count);
        for i in 0..count {
            for j in 0..=i {
                gram[(i, j)] = product(&columns[i], &columns[j]) - dot(&pulls[i], &errors[j]);
                gram[(j, i)] = gram[(i, j)];
            }
        }
        // Of any unit: scaled to one before.
        let whole: Vec<f64> = columns.iter().map(|c| product(c, c).sqrt()).collect();
        let scaled = DMatrix::from_fn(count, count, |i, j| gram[(i, j)] / (whole[i] * whole[j]));
        let mut covariance = scaled.cholesky()?.inverse();
        for i in 0..count {
            for j in 0..count {
                covariance[(i, j)] /= whole[i] * whole[j];
            }
        }
        let sound = covariance.iter().all(|value| value.is_finite());
        sound.then_some(Self { pulls, covariance })
    }

    /// How far the sizes go where the pattern still pulls.
    fn step(&self, disc: &Disc<'_>, prior: &[f64], pulled: &[f64]) -> DVector<f64> {
        let errors = known(disc, prior, pulled);
        let right = self.pulls.iter().map(|own| -dot(own, &errors));
        &self.covariance * DVector::from_iterator(self.pulls.len(), right)
    }
}

/// Errors that answer a pull, where the disc shows alike all round.
fn known(disc: &Disc<'_>, prior: &[f64], pulled: &[f64]) -> Vec<f64> {
    disc.weighted(pulled, &|m| (disc.clear[m] + prior[m].recip()).recip())
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
