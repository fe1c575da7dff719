//! Several patterns fitted at once to all recordings of a rig, each recording with its own noise.

use nalgebra::{DMatrix, DVector};

use super::kalman::{ShaftNoise, Whitener, fit};
use super::residual::Residual;
use super::term::Term;

/// Edges that the noise is fitted on at the most: a part in the middle says as much.
const NOISE_EDGES: usize = 24_000;

/// A stretch with the noise found in it.
pub struct Noisy<'a> {
    /// The residual.
    pub residual: &'a Residual,
    /// Its noise.
    pub noise: ShaftNoise,
    whitener: Whitener,
}

impl<'a> Noisy<'a> {
    /// Finds the noise of what `explained` leaves of a residual.
    #[must_use]
    pub fn of(
        residual: &'a Residual,
        explained: &[f64],
        tick_s: f64,
        start: Option<ShaftNoise>,
    ) -> Self {
        let left: Vec<f64> = residual
            .angles
            .iter()
            .zip(explained)
            .map(|(angle, explained)| angle - explained)
            .collect();
        let count = left.len().min(NOISE_EDGES);
        let from = (left.len() - count) / 2;
        let part = from..from + count;
        let start = start.unwrap_or_else(|| first_guess(residual, tick_s));
        let noise = fit(&residual.readings[part.clone()], &left[part], tick_s, start);
        Self {
            residual,
            noise,
            whitener: Whitener::new(&residual.readings, noise),
        }
    }

    /// What is left of the residual, white.
    #[must_use]
    pub fn white(&self, explained: &[f64]) -> Vec<f64> {
        let mut left: Vec<f64> = self
            .residual
            .angles
            .iter()
            .zip(explained)
            .map(|(angle, explained)| angle - explained)
            .collect();
        self.whitener.whiten(&mut left);
        left
    }
}

/// A thousandth of the speed, forgotten within a radian, and stamps as good as the tick.
fn first_guess(residual: &Residual, tick_s: f64) -> ShaftNoise {
    let speed = residual.mean_speed();
    let wander = 1e-3 * speed;
    ShaftNoise {
        forgets_per_s: speed,
        acceleration: 2.0 * speed * wander * wander,
        drift: 1e-8 * speed * speed * speed,
        stamp_s: 10.0 * tick_s,
    }
}

/// Terms fitted together.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Size of every column, term by term, rad.
    pub sizes: Vec<f64>,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
    /// Fall of the sum of squares that the terms make.
    pub gain: f64,
}

/// Fits terms to all stretches; none where they can't be told apart at all.
#[must_use]
pub fn fit_terms(terms: &[Term], stretches: &[Noisy<'_>], reference: f64) -> Option<Fit> {
    let count = terms.iter().map(Term::count).sum();
    let (mut gram, mut right) = (DMatrix::zeros(count, count), DVector::zeros(count));
    for stretch in stretches {
        let zero = vec![0.0; stretch.residual.angles.len()];
        let white = stretch.white(&zero);
        let columns: Vec<Vec<f64>> = terms
            .iter()
            .flat_map(|term| term.columns(stretch.residual, reference))
            .map(|mut column| {
                stretch.whitener.whiten(&mut column);
                column
            })
            .collect();
        for (i, column) in columns.iter().enumerate() {
            right[i] += dot(column, &white);
            for (j, other) in columns[..=i].iter().enumerate() {
                gram[(i, j)] += dot(column, other);
                gram[(j, i)] = gram[(i, j)];
            }
        }
    }
    let cholesky = gram.cholesky()?;
    let sizes = cholesky.solve(&right);
    Some(Fit {
        gain: sizes.dot(&right),
        sizes: sizes.iter().copied().collect(),
        covariance: cholesky.inverse(),
    })
}

/// What terms of these sizes make of a stretch.
#[must_use]
pub fn explained(terms: &[Term], sizes: &[f64], residual: &Residual, reference: f64) -> Vec<f64> {
    let mut sum = vec![0.0; residual.angles.len()];
    let columns = terms
        .iter()
        .flat_map(|term| term.columns(residual, reference));
    for (column, size) in columns.zip(sizes) {
        for (sum, value) in sum.iter_mut().zip(column) {
            *sum += size * value;
        }
    }
    sum
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Noisy<'_> {
    /// A pattern as it shows in what is white.
    #[must_use]
    pub fn whitened(&self, mut column: Vec<f64>) -> Vec<f64> {
        self.whitener.whiten(&mut column);
        column
    }
}
