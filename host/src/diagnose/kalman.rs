//! The filter that makes the noise of a turning shaft white.
//!
//! Torque noise pushes the shaft (see [`super::shaft`]), its mean speed may drift, and every time stamp has an error of its own:
//! dy = (v + m) dt, dv = -b v dt + white(q), dm = white(d), and an edge shows y + w j with w the speed and j the stamp's
//! error. The innovations of the Kalman filter are white and of known variance, whatever the speed does and wherever edges are
//! missing; a pattern that goes through the same filter can be held against them by plain least squares.

use super::filter::Filter;
use super::hold::Stiff;
use super::shaft::Leap;
use super::sprung::{STATES, Sprung};

/// Size of the noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShaftNoise {
    /// Density of the acceleration noise, (rad/s^2)^2 s.
    pub acceleration: f64,
    /// RMS error of a time stamp, s.
    pub stamp_s: f64,
    /// Density of the mean speed's drift, (rad/s)^2/s; 0 where the twin says what holds the speed.
    pub drift: f64,
    /// Damping on top of the twin's, 1/s: what a twin does not say.
    pub forgets_per_s: f64,
    /// Time for which a torque is held, on a grid from time 0, s; 0 where it is white. Where it is held, nothing drifts.
    pub hold_s: f64,
    /// Density of the acceleration noise at the far side of a spring, (rad/s^2)^2 s.
    pub load: f64,
}

impl ShaftNoise {
    /// What pushes the far side of a spring, white, and the rest.
    #[must_use]
    pub fn apart(self) -> (Self, Self) {
        let far = Self {
            acceleration: 0.0,
            drift: 0.0,
            ..self
        };
        (far, Self { load: 0.0, ..self })
    }
}

/// One edge as the filter sees it.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    /// From the edge before.
    pub leap: Leap,
    /// Speed here, rad/s, either way.
    pub speed: f64,
    /// When it came, s.
    pub at_s: f64,
    /// Whether the angle does not go on from the edge before: the count was disturbed.
    pub fresh: bool,
    /// Whether nothing is known of angle and speed: edges before it were left out.
    pub anew: bool,
    /// Variance of a jolt of the speed that nobody knows, (rad/s)^2.
    pub jolt: f64,
    /// RMS error of the stamp on top of the noise, s, where it is known to say little.
    pub doubt_s: f64,
}

/// Edges after a fresh start that only set the filter.
pub const SETTLES: usize = 2;

/// The filter's gains along a row of edges, which depend on times only: so one run serves every pattern.
#[derive(Clone, Debug)]
pub enum Whitener {
    /// Of a stiff shaft.
    Stiff(Filter<Stiff, 3>),
    /// Of a shaft with a spring.
    Sprung(Filter<Sprung, STATES>),
}

impl Default for Whitener {
    fn default() -> Self {
        Self::Stiff(Filter::default())
    }
}

/// Does the same with either.
macro_rules! either {
    ($whitener:expr, $filter:ident => $does:expr) => {
        match $whitener {
            Whitener::Stiff($filter) => $does,
            Whitener::Sprung($filter) => $does,
        }
    };
}

impl Whitener {
    /// For these edges.
    #[must_use]
    pub fn new(readings: &[Reading], noise: ShaftNoise) -> Self {
        if readings.iter().any(|reading| reading.leap.spring.is_some()) {
            Self::Sprung(Filter::new(readings, noise))
        } else {
            Self::Stiff(Filter::new(readings, noise))
        }
    }

    /// Whitens a row of angles, one an edge, in place: what comes out has unit variance if it is this noise; edges that only set
    /// the filter come out as zero.
    pub fn whiten(&self, angles: &mut [f64]) {
        self.whiten_from(0, angles);
    }

    /// Whitens a row of angles that begins at an edge, nothing before, in place.
    pub fn whiten_from(&self, first: usize, angles: &mut [f64]) {
        either!(self, filter => filter.whiten_from(first, angles));
    }

    /// Whitens two rows, one an edge, in place: together they take hardly longer than one.
    pub fn whiten_both(&self, one: &mut [f64], other: &mut [f64]) {
        either!(self, filter => filter.whiten_both(one, other));
    }

    /// The transposed filter, in place, for normal equations.
    pub fn transposed(&self, white: &mut [f64]) {
        either!(self, filter => filter.transposed(white));
    }

    /// Undoes [`Self::whiten`], in place: angles that give these numbers, less where the shaft began and how fast, which are lost.
    pub fn restore(&self, white: &mut [f64]) {
        either!(self, filter => filter.restore(white));
    }

    /// Diagonal of the inverse of the angles' covariance, 1/rad^2: how well each angle is known from all others and itself. An
    /// angle less what the others let expect is its entry of the filter, transposed and plain, applied to all, over this.
    #[must_use]
    pub fn precisions(&self) -> Vec<f64> {
        either!(self, filter => filter.precisions())
    }

    /// Standard deviation of the innovation of every edge, rad; none where it only sets the filter.
    pub fn deviations(&self) -> impl Iterator<Item = Option<f64>> {
        let scales: Vec<f64> = either!(self, filter => filter.scales().collect());
        let each = scales.into_iter();
        each.map(|scale| (scale > 0.0).then(|| scale.recip()))
    }

    /// Sum of the logarithms of the innovations' variances.
    #[must_use]
    pub fn log_variance(&self) -> f64 {
        let of = |scale: f64| if scale > 0.0 { scale.ln() } else { 0.0 };
        -2.0 * either!(self, filter => filter.scales().map(of).sum::<f64>())
    }
}
