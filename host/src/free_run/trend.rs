//! The part of a displacement that a free shaft could have made by itself: what the recording's start leaves open.

use nalgebra::{Matrix3, SMatrix};

use super::motion::Response;

/// A free shaft's motions from any start under a constant push, as coefficients for each of so many displacements: angle, speed,
/// acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trend<const CHANNELS: usize> {
    viscous: f64,
    coefficients: SMatrix<f64, 3, CHANNELS>,
}

impl<const CHANNELS: usize> Trend<CHANNELS> {
    /// Standstill.
    #[must_use]
    pub fn none() -> Self {
        Self {
            viscous: 0.0,
            coefficients: SMatrix::zeros(),
        }
    }

    /// All displacements after `time_s`.
    #[must_use]
    pub fn at(&self, time_s: f64) -> [f64; CHANNELS] {
        self.sum(basis(time_s, self.viscous))
    }

    /// Their speeds.
    #[must_use]
    pub fn speed_at(&self, time_s: f64) -> [f64; CHANNELS] {
        let response = Response::after(time_s, self.viscous);
        self.sum([0.0, response.decay, response.to_speed])
    }

    /// The speed at the start of one of the displacements.
    pub(super) fn speed(&self, channel: usize) -> f64 {
        self.coefficients[(1, channel)]
    }

    /// The constant acceleration of one of them.
    pub(super) fn push(&self, channel: usize) -> f64 {
        self.coefficients[(2, channel)]
    }

    fn sum(&self, basis: [f64; 3]) -> [f64; CHANNELS] {
        std::array::from_fn(|channel| {
            (0..3)
                .map(|i| basis[i] * self.coefficients[(i, channel)])
                .sum()
        })
    }
}

fn basis(time_s: f64, viscous: f64) -> [f64; 3] {
    let response = Response::after(time_s, viscous);
    [1.0, response.to_speed, response.to_push]
}

/// Least squares of displacements on the motions of a free shaft, in one pass.
#[derive(Clone, Debug)]
pub struct TrendFit<const CHANNELS: usize> {
    viscous: f64,
    gram: Matrix3<f64>,
    right: SMatrix<f64, 3, CHANNELS>,
}

impl<const CHANNELS: usize> TrendFit<CHANNELS> {
    /// Of a shaft with this viscous friction over inertia, 1/s.
    #[must_use]
    pub fn new(viscous: f64) -> Self {
        Self {
            viscous,
            gram: Matrix3::zeros(),
            right: SMatrix::zeros(),
        }
    }

    /// Takes the displacements at a time from the start, s.
    pub fn add(&mut self, time_s: f64, made: &[f64; CHANNELS]) {
        let basis = basis(time_s, self.viscous);
        for (i, x) in basis.iter().enumerate() {
            for (j, y) in basis.iter().enumerate() {
                self.gram[(i, j)] += x * y;
            }
            for (channel, made) in made.iter().enumerate() {
                self.right[(i, channel)] += x * made;
            }
        }
    }

    /// The trend.
    #[must_use]
    pub fn trend(&self) -> Trend<CHANNELS> {
        // Columns in one size, so that what is too small to tell from rounding is the same for all of them.
        let scale = self.gram.diagonal().map(|square| {
            if square > 0.0 {
                square.sqrt().recip()
            } else {
                0.0
            }
        });
        let sizes = Matrix3::from_diagonal(&scale);
        let scaled = sizes * self.gram * sizes;
        let inverse = scaled
            .pseudo_inverse(1e-13)
            .unwrap_or_else(|_| Matrix3::zeros());
        Trend {
            viscous: self.viscous,
            coefficients: sizes * inverse * sizes * self.right,
        }
    }
}
