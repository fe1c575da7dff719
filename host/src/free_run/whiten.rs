//! Least squares on intervals with the encoder's own errors taken out and the noise made white.

use nalgebra::{SMatrix, SVector};

use crate::twin::Gains;

/// Unknowns: two gains, speed at the start, constant push.
pub(super) const UNKNOWNS: usize = 4;
/// Coefficients of the filter that makes residuals white. The differences of time stamps' rounding forget slowly: with a few
/// coefficients they pass for slow motion, which shows least of the gains.
const TAPS: usize = 40;
/// Equations in a row whose residuals may still go together.
const BLOCK: usize = 8 * TAPS;

type Vector = SVector<f64, UNKNOWNS>;
type Matrix = SMatrix<f64, UNKNOWNS, UNKNOWNS>;
/// How each unknown shows, and last the angle.
type Equation = [f64; UNKNOWNS + 1];

/// One interval: what it says of the shaft and how each unknown shows in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interval {
    /// Number of the edge that ends it.
    pub edge: u32,
    /// Whether the one before it in the list is the one before it in time.
    pub follows: bool,
    /// Angle, less that of a steady run, rad.
    pub angle: f64,
    /// Share of every unknown.
    pub shares: [f64; UNKNOWNS],
}

/// Unknowns found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fitted {
    solution: Vector,
    covariance: Matrix,
    /// Variance of what is left, rad^2.
    pub left: f64,
}

impl Fitted {
    pub fn gains(&self) -> Gains {
        Gains {
            kp: self.solution[0],
            ki: self.solution[1],
        }
    }

    pub fn standard_error(&self) -> Gains {
        Gains {
            kp: self.covariance[(0, 0)].sqrt(),
            ki: self.covariance[(1, 1)].sqrt(),
        }
    }

    pub fn correlation(&self) -> f64 {
        let Gains { kp, ki } = self.standard_error();
        let both = self.covariance[(0, 1)] / (kp * ki);
        if both.is_finite() { both } else { 0.0 }
    }
}

/// Solves for the unknowns, gains near `prior` within a relative standard deviation of `known_within`. None where there are fewer
/// equations than unknowns, edges among them.
#[allow(clippy::cast_precision_loss)]
pub(super) fn fit(
    intervals: &[Interval],
    edges: u32,
    filter: &[f64],
    prior: Gains,
    known_within: f64,
) -> Option<Fitted> {
    let equations = equations(intervals, edges, filter);
    let freedom = equations.len() as f64 - f64::from(edges) - UNKNOWNS as f64;
    if freedom < 1.0 {
        return None;
    }
    let (mut gram, mut right, mut square) = (Matrix::zeros(), Vector::zeros(), 0.0);
    for equation in &equations {
        let (shares, angle) = (
            Vector::from_column_slice(&equation[..UNKNOWNS]),
            equation[UNKNOWNS],
        );
        gram += shares * shares.transpose();
        right += shares * angle;
        square += angle * angle;
    }
    // Columns of very different size, brought to one.
    let size = gram
        .diagonal()
        .map(|x| if x > 0.0 { x.sqrt().recip() } else { 0.0 });
    let sizes = Matrix::from_diagonal(&size);
    let prior = Vector::new(prior.kp, prior.ki, 0.0, 0.0);
    let mut left = square / freedom;
    let mut fitted = None;
    // The prior counts against the noise, which is known once something is fitted.
    for _ in 0..3 {
        let weight = prior.map(|gain| {
            if gain == 0.0 {
                0.0
            } else {
                left / (known_within * gain).powi(2)
            }
        });
        let penalty = Matrix::from_diagonal(&weight.component_mul(&size).component_mul(&size));
        let system = sizes * gram * sizes + penalty + Matrix::identity() * 1e-12;
        let wanted = (right + weight.component_mul(&prior)).component_mul(&size);
        let inverse = system.cholesky()?.inverse();
        let solution = (inverse * wanted).component_mul(&size);
        let rest = square - 2.0 * solution.dot(&right) + solution.dot(&(gram * solution));
        left = (rest / freedom).max(f64::MIN_POSITIVE);
        let bread = sizes * inverse * sizes;
        let prior_part = Matrix::from_diagonal(&(weight * left));
        let covariance = bread * (meat(&equations, &solution) + prior_part) * bread;
        fitted = Some(Fitted {
            solution,
            covariance,
            left,
        });
    }
    fitted
}

/// How much the residuals say by chance, measured in blocks, for what is left is neither quite white nor of one size.
fn meat(equations: &[Equation], solution: &Vector) -> Matrix {
    let score = |block: &[Equation]| {
        block.iter().fold(Vector::zeros(), |sum, equation| {
            let shares = Vector::from_column_slice(&equation[..UNKNOWNS]);
            sum + shares * (equation[UNKNOWNS] - shares.dot(solution))
        })
    };
    equations.chunks(BLOCK).fold(Matrix::zeros(), |sum, block| {
        let score = score(block);
        sum + score * score.transpose()
    })
}

/// The filter that makes what `fitted` leaves white, by Levinson's recursion on its autocorrelation.
pub(super) fn filter(intervals: &[Interval], edges: u32, fitted: &Fitted) -> Vec<f64> {
    let rest: Vec<f64> = equations(intervals, edges, &[1.0])
        .iter()
        .map(|equation| {
            let shares = Vector::from_column_slice(&equation[..UNKNOWNS]);
            equation[UNKNOWNS] - shares.dot(&fitted.solution)
        })
        .collect();
    let lagged = |lag: usize| {
        rest.iter()
            .zip(rest.iter().skip(lag))
            .map(|(a, b)| a * b)
            .sum()
    };
    let correlation: Vec<f64> = (0..=TAPS).map(lagged).collect();
    let mut filter = vec![1.0];
    let mut power = correlation[0];
    for order in 1..=TAPS {
        if power <= 0.0 {
            break;
        }
        let miss: f64 = (0..order).map(|i| filter[i] * correlation[order - i]).sum();
        let reflection = -miss / power;
        filter.push(0.0);
        let back: Vec<f64> = filter.iter().rev().copied().collect();
        filter
            .iter_mut()
            .zip(back)
            .for_each(|(tap, back)| *tap += reflection * back);
        power *= 1.0 - reflection * reflection;
    }
    filter
}

/// The filtered intervals, each edge's mean over the turns taken out: with it go the encoder's own errors, filtered or not.
fn equations(intervals: &[Interval], edges: u32, filter: &[f64]) -> Vec<Equation> {
    let mut run = 0;
    let mut filtered: Vec<(usize, Equation)> = Vec::with_capacity(intervals.len());
    for (at, interval) in intervals.iter().enumerate() {
        run = if interval.follows { run + 1 } else { 0 };
        if run + 1 < filter.len() {
            continue;
        }
        let mut equation = [0.0; UNKNOWNS + 1];
        for (tap, earlier) in filter.iter().zip(intervals[..=at].iter().rev()) {
            for (sum, value) in equation.iter_mut().zip(earlier.shares) {
                *sum += tap * value;
            }
            equation[UNKNOWNS] += tap * earlier.angle;
        }
        filtered.push((interval.edge as usize, equation));
    }
    let mut sums = vec![([0.0; UNKNOWNS + 1], 0.0); edges as usize];
    for (edge, equation) in &filtered {
        let (sum, count) = &mut sums[*edge];
        sum.iter_mut()
            .zip(equation)
            .for_each(|(sum, value)| *sum += value);
        *count += 1.0;
    }
    filtered
        .into_iter()
        .map(|(edge, mut equation)| {
            let (sum, count) = &sums[edge];
            equation
                .iter_mut()
                .zip(sum)
                .for_each(|(value, sum)| *value -= sum / count);
            equation
        })
        .collect()
}
