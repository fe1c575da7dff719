//! Generalised least squares: everything that is not known at once, weighed by the noise's own covariance.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use super::pass::Pass;
use super::shaft::Whitener;

/// A problem: recordings of one disc.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The recordings.
    pub passes: Vec<Pass>,
    /// Places a turn that the ideal estimator looks at.
    pub points: usize,
    /// Factor on the variance of the time stamps: with fewer points than edges, points over edges, so that the noise of each order
    /// stays that of all edges.
    pub stamp_share: f64,
    /// Orders of the geometry.
    pub orders: Vec<usize>,
    /// Orders at which there may be locked torque.
    pub ripple: Vec<usize>,
}

/// The ideal estimator of a problem.
pub struct Gls {
    problem: Problem,
    blocks: Vec<Block>,
    scales: DVector<f64>,
    /// Upper triangle R of the whitened, scaled design's QR factors: its normal matrix would lose half of the digits.
    factor: DMatrix<f64>,
}

struct Block {
    whitener: Whitener,
    design: DMatrix<f64>,
}

impl Gls {
    /// Sets it up; none where the recordings can't tell all unknowns apart.
    #[must_use]
    pub fn new(problem: Problem) -> Option<Self> {
        let trends: Vec<usize> = problem
            .passes
            .iter()
            .map(|pass| pass.trends(&[0.0]).len())
            .collect();
        let locked = 2 * (problem.orders.len() + problem.ripple.len());
        let unknowns = locked + trends.iter().sum::<usize>();
        let mut blocks = Vec::new();
        for (at, pass) in problem.passes.iter().enumerate() {
            let own = locked + trends[..at].iter().sum::<usize>();
            blocks.push(Block::new(&problem, pass, unknowns, own));
        }
        let rows = blocks.iter().map(|block| block.design.nrows()).sum();
        let mut design = DMatrix::zeros(rows, unknowns);
        let mut row = 0;
        for block in &blocks {
            let height = block.design.nrows();
            design.rows_mut(row, height).copy_from(&block.design);
            row += height;
        }
        let scales = DVector::from_iterator(unknowns, design.column_iter().map(|c| 1.0 / c.norm()));
        for (mut column, scale) in design.column_iter_mut().zip(scales.iter()) {
            column *= *scale;
        }
        let factor = design.qr().unpack_r();
        // What is left of a column when the others are taken off it: rounding would make something of nothing.
        let told = factor.diagonal().iter().all(|x| x.abs() > 1e-10);
        told.then_some(Self {
            problem,
            blocks,
            scales,
            factor,
        })
    }

    /// Variance of the geometry's mean power that is expected at each order, rad^2: the mean of those of both amplitudes.
    #[must_use]
    pub fn variances(&self) -> Vec<f64> {
        let unknowns = self.scales.len();
        let mut inverse = DMatrix::identity(unknowns, unknowns);
        // The diagonal was looked at when the factors were made.
        self.factor.solve_upper_triangular_mut(&mut inverse);
        (0..self.problem.orders.len())
            .map(|i| {
                let variance = |c: usize| inverse.row(c).norm_squared() * self.scales[c].powi(2);
                f64::midpoint(variance(2 * i), variance(2 * i + 1))
            })
            .collect()
    }

    /// Amplitudes of cos(n theta) and sin(n theta) for every order of the geometry, from the angle deviations of every recording
    /// at the problem's points, rad.
    #[must_use]
    pub fn estimate(&self, deviations: &[Vec<f64>]) -> Vec<[f64; 2]> {
        let mut sums = DVector::zeros(self.scales.len());
        for (block, deviation) in self.blocks.iter().zip(deviations) {
            let mut white = DVector::from_column_slice(deviation);
            block.whitener.whiten(white.as_mut_slice());
            sums += block.design.tr_mul(&white);
        }
        let mut solved = sums.component_mul(&self.scales);
        self.factor.tr_solve_upper_triangular_mut(&mut solved);
        self.factor.solve_upper_triangular_mut(&mut solved);
        solved.component_mul_assign(&self.scales);
        (0..self.problem.orders.len())
            .map(|i| [solved[2 * i], solved[2 * i + 1]])
            .collect()
    }
}

impl Block {
    /// The whitened design of one recording; its own trends stand from column `own` on.
    fn new(problem: &Problem, pass: &Pass, unknowns: usize, own: usize) -> Self {
        let points = problem.points;
        let times = pass.times(points);
        let variance = pass.stamp_s.powi(2) * problem.stamp_share;
        let reading: Vec<f64> = times
            .iter()
            .map(|&time| variance * pass.speed(time).powi(2))
            .collect();
        let whitener = Whitener::new(&pass.shaft, &times, &reading);
        let mut design = DMatrix::zeros(times.len(), unknowns);
        let mut put = |column: usize, values: &mut dyn Iterator<Item = f64>| {
            let mut series = design.column_mut(column);
            series.iter_mut().zip(values).for_each(|(to, x)| *to = x);
            whitener.whiten(series.as_mut_slice());
        };
        let rows = 0..times.len();
        for (i, order) in problem.orders.iter().enumerate() {
            let turned = |row: usize| TAU * (order * row % points) as f64 / points as f64;
            put(2 * i, &mut rows.clone().map(|row| turned(row).cos()));
            put(2 * i + 1, &mut rows.clone().map(|row| turned(row).sin()));
        }
        let first = 2 * problem.orders.len();
        for (i, order) in problem.ripple.iter().enumerate() {
            for (part, series) in pass.ripple(*order, &times).into_iter().enumerate() {
                put(first + 2 * i + part, &mut series.into_iter());
            }
        }
        for (i, trend) in pass.trends(&times).into_iter().enumerate() {
            put(own + i, &mut trend.into_iter());
        }
        Self { whitener, design }
    }
}
