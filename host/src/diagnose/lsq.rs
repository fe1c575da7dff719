//! Least squares on whitened rows: sizes, their covariance, and what a further regressor would explain.

use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;

/// Whitened regressors of a model and the residual beside it.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Sizes, one a column.
    pub sizes: Vec<f64>,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
    /// Sum of the squares left.
    pub rss: f64,
    /// What is left, row by row.
    pub left: Vec<f64>,
}

/// Share of a column that has to be its own, beside the others, as a square, for what it explains to say anything: half of the digits of a
/// number.
pub const OWN: f64 = 1e-7;

/// Rounds of re-linearisation at the most, which bound the time.
pub const ROUNDS: usize = 8;

/// Part of its standard error by which a number may still move.
const SETTLED: f64 = 0.05;

/// Whether a number of a variance that would move by so much may as well stay.
pub fn is_settled(by: f64, variance: f64) -> bool {
    by.abs() <= SETTLED * variance.max(0.0).sqrt()
}

/// So many parts of a step of Gauss and Newton that are tried until one helps.
pub fn shares(count: usize) -> impl Iterator<Item = f64> {
    std::iter::successors(Some(1.0), |share| Some(0.3 * share)).take(count)
}

/// Fits columns to a row of numbers. A column that is none of its own beside those before it gets the size 0 and no variance.
pub fn solve<C: AsRef<[f64]>>(columns: &[C], target: &[f64]) -> Solution {
    let columns: Vec<&[f64]> = columns.iter().map(AsRef::as_ref).collect();
    let count = columns.len();
    let pairs = (0..count).flat_map(|a| (a..count).map(move |b| (a, b)));
    let pairs: Vec<(usize, usize)> = pairs.collect();
    let products = pairs.par_iter().map(|&(a, b)| dot(columns[a], columns[b]));
    let products: Vec<f64> = products.collect();
    let mut gram = DMatrix::zeros(count, count);
    for (&(a, b), product) in pairs.iter().zip(products) {
        gram[(a, b)] = product;
        gram[(b, a)] = product;
    }
    let right = columns.iter().map(|column| dot(column, target));
    let (sizes, covariance) = normal(&gram, &DVector::from_iterator(count, right));
    let mut left = target.to_vec();
    for (column, size) in columns.iter().zip(&sizes) {
        if *size != 0.0 {
            add(&mut left, -size, column);
        }
    }
    Solution {
        sizes: sizes.as_slice().to_vec(),
        covariance,
        rss: dot(&left, &left),
        left,
    }
}

/// Solves normal equations: sizes, and their covariance.
pub fn normal(gram: &DMatrix<f64>, right: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
    let count = gram.nrows();
    let norms = gram.diagonal().map(f64::sqrt);
    let unit = DMatrix::from_fn(count, count, |a, b| match norms[a] * norms[b] {
        0.0 => 0.0,
        both => gram[(a, b)] / both,
    });
    let used = independent(&unit);
    let mut sizes = DVector::zeros(count);
    let mut covariance = DMatrix::zeros(count, count);
    if let Some(cholesky) = Cholesky::new(unit.select_rows(&used).select_columns(&used)) {
        let of = used.iter().map(|&at| right[at] / norms[at]);
        let solved = cholesky.solve(&DVector::from_iterator(used.len(), of));
        let inverse = cholesky.inverse();
        for (a, &at) in used.iter().enumerate() {
            sizes[at] = solved[a] / norms[at];
            for (b, &other) in used.iter().enumerate() {
                covariance[(at, other)] = inverse[(a, b)] / (norms[at] * norms[other]);
            }
        }
    }
    (sizes, covariance)
}

/// Columns that are of their own beside those before them, going by their products: pivots of a Cholesky decomposition.
fn independent(gram: &DMatrix<f64>) -> Vec<usize> {
    let count = gram.nrows();
    let mut rows: Vec<Vec<f64>> = Vec::new();
    let mut used: Vec<usize> = Vec::new();
    for at in 0..count {
        let mut row = Vec::with_capacity(used.len());
        let mut own = gram[(at, at)];
        for (k, &other) in used.iter().enumerate() {
            let before: f64 = row.iter().zip(&rows[k]).map(|(a, b)| a * b).sum();
            let value = (gram[(at, other)] - before) / rows[k][k];
            own -= value * value;
            row.push(value);
        }
        if own > OWN {
            row.push(own.sqrt());
            rows.push(row);
            used.push(at);
        }
    }
    used
}

/// An orthonormal basis of columns, to take them off others.
#[derive(Clone, Debug, Default)]
pub struct Basis {
    columns: Vec<Vec<f64>>,
}

impl Basis {
    /// Of columns.
    pub fn of<C: AsRef<[f64]>>(columns: &[C]) -> Self {
        let mut basis = Self::default();
        let each = columns.iter();
        each.for_each(|column| basis.add(column.as_ref().to_vec()));
        basis
    }

    /// Adds one, unless it is nothing of its own.
    pub fn add(&mut self, mut column: Vec<f64>) {
        let whole = dot(&column, &column);
        self.clear(&mut column);
        self.clear(&mut column);
        self.take(column, OWN * whole);
    }

    /// Adds one that is clear of the others and has more than so much of its own.
    fn take(&mut self, mut column: Vec<f64>, least: f64) -> Option<&[f64]> {
        let own = dot(&column, &column);
        let scale = own.sqrt().recip();
        column.iter_mut().for_each(|value| *value *= scale);
        (own > least).then(|| self.columns.push(column))?;
        self.columns.last().map(Vec::as_slice)
    }

    /// Takes what is of the basis off a column.
    pub fn clear(&self, column: &mut [f64]) {
        for one in &self.columns {
            add(column, -dot(one, column), one);
        }
    }

    /// What of a column is not of the basis.
    pub fn beside(&self, column: &[f64]) -> Vec<f64> {
        let mut column = column.to_vec();
        self.clear(&mut column);
        column
    }

    /// By how much the sum of squares falls with more columns beside the basis; `target` is clear of it.
    pub fn gain<C: AsRef<[f64]>>(&self, columns: &[C], target: &[f64]) -> f64 {
        let mut beside = Self::default();
        let mut gain = 0.0;
        for column in columns {
            let mut column = column.as_ref().to_vec();
            let whole = dot(&column, &column);
            self.clear(&mut column);
            beside.clear(&mut column);
            let own = beside.take(column, OWN * whole);
            gain += own.map_or(0.0, |own| dot(own, target).powi(2));
        }
        gain
    }
}

/// Adds so much of a row to another one.
#[inline]
pub fn add(into: &mut [f64], by: f64, row: &[f64]) {
    let each = into.iter_mut().zip(row);
    each.for_each(|(into, of)| *into += by * of);
}

/// The least and the greatest of some values; of none, what any is below and above.
pub fn ends(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    values.fold(none, |(least, most), value| {
        (least.min(value), most.max(value))
    })
}

/// Sum of products.
#[inline]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    // Eight sums, so that they do not wait for each other.
    let both = a.len().min(b.len());
    let ((a, ends), (b, others)) = (a[..both].as_chunks::<8>(), b[..both].as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += a * b;
        }
    }
    let ends = ends.iter().zip(others).map(|(a, b)| a * b);
    sums.iter().sum::<f64>() + ends.sum::<f64>()
}
