//! Least squares over recordings whose steady pushes nobody knows.

use nalgebra::{DMatrix, DVector};

/// Parts of a recording whose scatter is looked at.
const PARTS: usize = 10;

/// Rows of one recording, white.
pub struct Rows<const N: usize> {
    /// What is looked for.
    pub columns: [Vec<f64>; N],
    /// A constant push and one that grows, of this recording alone.
    pub steady: [Vec<f64>; 2],
    /// What they have to explain.
    pub left: Vec<f64>,
}

/// Sizes of the columns.
pub struct Solved<const N: usize> {
    /// The sizes.
    pub sizes: [f64; N],
    /// Standard errors.
    pub errors: [f64; N],
    /// Sum of squares that stays.
    pub squares: f64,
}

/// Sizes of the columns over all recordings, steady pushes free; none where columns are alike.
#[must_use]
pub fn solved<const N: usize>(rows: Vec<Rows<N>>) -> Option<Solved<N>> {
    let mut parts = Vec::new();
    let mut squares = 0.0;
    for Rows {
        mut columns,
        steady: [level, slope],
        mut left,
    } in rows
    {
        let level = unit(level);
        let mut slope = slope;
        without(&mut slope, &level);
        let slope = unit(slope);
        for row in columns.iter_mut().chain([&mut left]) {
            without(row, &level);
            without(row, &slope);
        }
        squares += dot(&left, &left);
        let length = left.len().div_ceil(PARTS).max(1);
        for from in (0..left.len()).step_by(length) {
            let part = from..(from + length).min(left.len());
            let gram = DMatrix::from_fn(N, N, |i, j| {
                dot(&columns[i][part.clone()], &columns[j][part.clone()])
            });
            let right = DVector::from_fn(N, |i, _| {
                dot(&columns[i][part.clone()], &left[part.clone()])
            });
            parts.push((gram, right));
        }
    }
    let zero = (DMatrix::zeros(N, N), DVector::zeros(N));
    let (gram, right) = parts.iter().fold(zero, |(gram, right), part| {
        (gram + &part.0, right + &part.1)
    });
    let inverse = gram.try_inverse()?;
    let sizes = &inverse * &right;
    squares -= right.dot(&sizes);
    // Between parts the sizes may scatter more than the noise says: a sample at the very time of an edge goes either way.
    let mut scatter = DMatrix::zeros(N, N);
    for (gram, right) in &parts {
        let off = right - gram * &sizes;
        scatter += &off * off.transpose();
    }
    let count = parts.len() as f64;
    let between = &inverse * scatter * &inverse * (count / (count - 2.0));
    Some(Solved {
        sizes: std::array::from_fn(|i| sizes[i]),
        errors: std::array::from_fn(|i| inverse[(i, i)].max(between[(i, i)]).sqrt()),
        squares,
    })
}

/// Product of two rows.
#[must_use]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Takes the share of a row of length one off another.
pub fn without(row: &mut [f64], unit: &[f64]) {
    let share = dot(row, unit);
    row.iter_mut()
        .zip(unit)
        .for_each(|(value, unit)| *value -= share * unit);
}

/// A row with length one; one of zeros stays.
#[must_use]
pub fn unit(mut row: Vec<f64>) -> Vec<f64> {
    let size = dot(&row, &row).sqrt();
    if size > 0.0 {
        row.iter_mut().for_each(|value| *value /= size);
    }
    row
}
