//! Gains of a speed loop by least squares over all recordings, and the noise once the loop is taken off.

use nalgebra::{Matrix2, Vector2};
use rayon::prelude::*;

use super::sampled::Sampled;
use super::solve::{Rows, dot, solved};
use crate::diagnose::board::Bench;
use crate::diagnose::kalman::{ShaftNoise, Whitener};
use crate::diagnose::noise_fit::{self, Free};

/// One recording as a loop would explain it.
pub struct Side<'a> {
    /// What its loop would have seen.
    pub sampled: Sampled,
    /// Its residual.
    pub bench: &'a Bench,
    /// Its noise.
    pub noise: ShaftNoise,
}

/// The gains over all recordings.
pub struct Gains {
    /// Proportional and integral gain over the inertia.
    pub sizes: [f64; 2],
    /// Standard errors.
    pub errors: [f64; 2],
    /// -2 log likelihood.
    pub cost: f64,
    /// Edges that it is of.
    pub edges: f64,
}

/// Columns of a side: both gains, then what a shift of the mean speed makes.
fn columns(side: &Side, edges: &[usize], f_hz: f64) -> [Vec<f64>; 4] {
    let spans = side.sampled.spans(edges.to_vec());
    let [kp, ki] = side.sampled.gains(&spans, f_hz);
    let [level, slope] = side.sampled.steady(&spans);
    [kp, ki, level, slope]
}

/// Gains by least squares over all sides, each with its own steady pushes.
#[must_use]
pub fn gains(sides: &[Side], f_hz: f64) -> Option<Gains> {
    let (mut rows, mut scale, mut edges) = (Vec::new(), 0.0, 0.0);
    let each = sides.par_iter().map(|side| {
        let all = side.sampled.edges_for(f_hz, 1);
        let whitener = side.sampled.whitener(&all, side.noise);
        let [kp, ki, level, slope] = columns(side, &all, f_hz).map(|mut column| {
            whitener.whiten(&mut column);
            column
        });
        let mut left = side.sampled.angles_at(&all);
        whitener.whiten(&mut left);
        let row = Rows {
            columns: [kp, ki],
            steady: [level, slope],
            left,
        };
        (row, whitener.log_variance(), all.len() as f64)
    });
    for (row, log_variance, count) in each.collect::<Vec<_>>() {
        scale += log_variance;
        edges += count;
        rows.push(row);
    }
    let solved = solved(rows)?;
    Some(Gains {
        sizes: solved.sizes,
        errors: solved.errors,
        cost: solved.squares + scale,
        edges,
    })
}

/// The noise once the loop is taken off.
#[must_use]
pub fn noise_of(side: &Side, f_hz: f64, sizes: [f64; 2]) -> ShaftNoise {
    let all = side.sampled.edges_for(f_hz, 1);
    let readings = side.sampled.readings(&all);
    let columns = columns(side, &all, f_hz);
    let mut angles = side.sampled.angles_at(&all);
    for (column, size) in columns.iter().zip(sizes) {
        angles
            .iter_mut()
            .zip(column)
            .for_each(|(angle, value)| *angle -= size * value);
    }
    // The steady pushes as the filter sees them.
    let whitener = Whitener::new(&readings, side.noise);
    let mut white = columns.clone();
    white.iter_mut().for_each(|column| whitener.whiten(column));
    let mut left = angles.clone();
    whitener.whiten(&mut left);
    let at = |i: usize, j: usize| dot(&white[2 + i], &white[2 + j]);
    let both = Matrix2::new(at(0, 0), at(0, 1), at(1, 0), at(1, 1));
    let right = Vector2::new(dot(&white[2], &left), dot(&white[3], &left));
    if let Some(steady) = both.try_inverse().map(|inverse| inverse * right) {
        for (column, size) in columns[2..].iter().zip(steady.iter()) {
            angles
                .iter_mut()
                .zip(column)
                .for_each(|(angle, value)| *angle -= size * value);
        }
    }
    noise_fit::fit(
        &readings,
        &angles,
        side.bench.least_stamp_s,
        side.noise,
        Free::Sizes,
    )
}
