//! Patterns fitted to all recordings together, white, by plain least squares.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;

use super::board::{Board, Column, with_rows};

/// Patterns fitted together.
#[derive(Clone, Debug)]
pub struct Model {
    /// The patterns.
    pub columns: Vec<Column>,
    /// Their sizes.
    pub sizes: DVector<f64>,
    /// Covariance of the sizes.
    pub covariance: DMatrix<f64>,
    pub(super) factor: Option<Cholesky<f64, Dyn>>,
    /// Lengths of the columns, which the factor is without.
    norms: Vec<f64>,
    /// What is left, white.
    pub left: Vec<Vec<f64>>,
}

impl Model {
    /// Nothing fitted.
    #[must_use]
    pub fn none(board: &Board) -> Self {
        Self {
            columns: Vec::new(),
            sizes: DVector::zeros(0),
            covariance: DMatrix::zeros(0, 0),
            factor: None,
            norms: Vec::new(),
            left: board.white(),
        }
    }
}

/// What more patterns would do.
#[derive(Clone, Debug)]
pub struct Gain {
    /// Fall of the sum of squares.
    pub squares: f64,
    /// Their sizes.
    pub sizes: DVector<f64>,
}

impl Board {
    /// Fits columns together; none where they can't be told apart.
    #[must_use]
    pub fn fit(&self, columns: Vec<Column>) -> Option<Model> {
        let count = columns.len();
        if count == 0 {
            return Some(Model::none(self));
        }
        let mut left = self.white();
        let (mut gram, mut right) = (DMatrix::zeros(count, count), DVector::zeros(count));
        let products = |i: usize| -> (f64, Vec<f64>) {
            let before = columns[..=i].iter();
            let row = before.map(|column| self.products.of(&columns[i], column));
            (with_rows(&columns[i], &left), row.collect())
        };
        let rows: Vec<(f64, Vec<f64>)> = (0..count).into_par_iter().map(products).collect();
        for (i, (with, row)) in rows.into_iter().enumerate() {
            right[i] = with;
            for (j, product) in row.into_iter().enumerate() {
                gram[(i, j)] = product;
                gram[(j, i)] = product;
            }
        }
        // Sizes of any unit: scaled to one before.
        let norms: Vec<f64> = (0..count).map(|i| gram[(i, i)].sqrt()).collect();
        let scale: Vec<f64> = norms.iter().map(|norm| norm.recip()).collect();
        if scale.iter().any(|scale| !scale.is_finite()) {
            return None;
        }
        for i in 0..count {
            right[i] *= scale[i];
            for j in 0..count {
                gram[(i, j)] *= scale[i] * scale[j];
            }
        }
        let worst = (0..count).map(|i| gram[(i, i)]).fold(0.0, f64::max);
        let factor = gram.cholesky()?;
        let narrow = factor.l_dirty().diagonal().min();
        if narrow * narrow < 1e-9 * worst {
            return None;
        }
        let unit = factor.solve(&right);
        let mut covariance = factor.inverse();
        for i in 0..count {
            for j in 0..count {
                covariance[(i, j)] *= scale[i] * scale[j];
            }
        }
        let sizes = DVector::from_iterator(count, unit.iter().zip(&scale).map(|(u, s)| u * s));
        take_off(&mut left, &columns, &sizes);
        Some(Model {
            columns,
            sizes,
            covariance,
            factor: Some(factor),
            norms,
            left,
        })
    }

    /// Columns with given sizes.
    #[must_use]
    pub fn with_sizes(&self, columns: &[Column], sizes: &DVector<f64>) -> Model {
        let mut left = self.white();
        take_off(&mut left, columns, sizes);
        Model {
            columns: Vec::new(),
            sizes: sizes.clone(),
            covariance: DMatrix::zeros(0, 0),
            factor: None,
            norms: Vec::new(),
            left,
        }
    }

    /// What more columns would explain of what a model leaves.
    #[must_use]
    pub fn gain(&self, model: &Model, more: &[Column]) -> Option<Gain> {
        let (old, new) = (model.columns.len(), more.len());
        let mut gram = DMatrix::zeros(new, new);
        let mut right = DVector::zeros(new);
        let mut across = DMatrix::zeros(old, new);
        for i in 0..new {
            right[i] = with_rows(&more[i], &model.left);
            for j in 0..=i {
                gram[(i, j)] = self.products.of(&more[i], &more[j]);
                gram[(j, i)] = gram[(i, j)];
            }
            for (k, column) in model.columns.iter().enumerate() {
                across[(k, i)] = self.products.of(column, &more[i]);
            }
        }
        let whole: Vec<f64> = (0..new).map(|i| gram[(i, i)]).collect();
        if let Some(factor) = &model.factor {
            for (k, norm) in model.norms.iter().enumerate() {
                for i in 0..new {
                    across[(k, i)] /= norm;
                }
            }
            gram -= across.transpose() * factor.solve(&across);
        }
        // What the model has already can't be sized.
        if (0..new).any(|i| gram[(i, i)].is_nan() || gram[(i, i)] <= 1e-7 * whole[i]) {
            return None;
        }
        let scale: Vec<f64> = (0..new).map(|i| gram[(i, i)].sqrt().recip()).collect();
        for i in 0..new {
            right[i] *= scale[i];
            for j in 0..new {
                gram[(i, j)] *= scale[i] * scale[j];
            }
        }
        let factor = gram.cholesky()?;
        let unit = factor.solve(&right);
        let squares = unit.dot(&right);
        // No more than there is: else the columns are too alike to be told apart.
        let narrow = factor.l_dirty().diagonal().min();
        let most: f64 = model.left.iter().flatten().map(|w| w * w).sum();
        if narrow < 1e-4 || squares > most {
            return None;
        }
        let sizes = DVector::from_iterator(new, unit.iter().zip(&scale).map(|(u, s)| u * s));
        squares.is_finite().then_some(Gain { squares, sizes })
    }
}

/// Takes columns of given sizes off what is left.
fn take_off(left: &mut [Vec<f64>], columns: &[Column], sizes: &DVector<f64>) {
    for (column, size) in columns.iter().zip(sizes.iter()) {
        for (left, part) in left.iter_mut().zip(&column.0) {
            if let Some(part) = part {
                for (left, value) in left.iter_mut().zip(part) {
                    *left -= size * value;
                }
            }
        }
    }
}

/// Sum of squares that a model leaves.
#[must_use]
pub fn squares(model: &Model) -> f64 {
    model.left.iter().flatten().map(|w| w * w).sum()
}
