//! States beside the shaft's own: the stretch of a drive's spring, the twist of a second mass.
//!
//! Each grows term by term with the shaft's series.

use std::f64::consts::TAU;

use super::taylor::{DEGREE, Series};
use crate::twin::TorsionalResonance;

/// A polynomial in the time from the step's start, and the value there.
#[derive(Clone, Debug, Default)]
pub(super) struct State {
    pub(super) series: Series,
}

impl State {
    /// Begins a step where the last one ended.
    pub(super) fn at(value: f64) -> Self {
        let mut series = [0.0; DEGREE];
        series[0] = value;
        Self { series }
    }

    /// Goes to `tau` s after the step's start; the first `terms` are known.
    pub(super) fn go_to(&mut self, tau: f64, terms: usize) {
        let known = self.series[..terms.min(DEGREE)].iter().rev();
        *self = Self::at(known.fold(0.0, |sum, c| sum * tau + c));
    }
}

/// The spring through which a drive pulls.
#[derive(Clone, Debug)]
pub(super) struct DriveSpring {
    /// Stiffness over inertia, 1/s^2.
    pub(super) stiffness: f64,
    /// How far its far end is ahead of the shaft, rad.
    pub(super) stretch: State,
}

/// The second mass behind a torsional spring.
#[derive(Clone, Debug)]
pub(super) struct Twist {
    /// Share of the inertia on the far side.
    pub(super) share: f64,
    /// Square of the free frequency, rad^2/s^2.
    pub(super) square: f64,
    /// Twice the damping ratio times the free frequency, 1/s.
    pub(super) damping: f64,
    /// How far the far side is ahead, rad.
    pub(super) angle: State,
    /// How much faster it turns, rad/s.
    pub(super) speed: State,
    /// Acceleration of the far side by what pushes it there, rad/s^2.
    pub(super) push: f64,
}

impl Twist {
    pub(super) fn new(resonance: &TorsionalResonance) -> Self {
        let free = TAU * resonance.f_hz;
        Self {
            share: resonance.inertia_share,
            square: free * free,
            damping: 2.0 * resonance.damping_ratio * free,
            angle: State::default(),
            speed: State::default(),
            push: 0.0,
        }
    }

    /// Acceleration of the twist by the spring and damper, rad/s^2, term `k`.
    pub(super) fn pull(&self, k: usize) -> f64 {
        self.square * self.angle.series[k] + self.damping * self.speed.series[k]
    }

    /// Works out term `k` + 1 from term `k`, `near` being that of the near side's acceleration.
    pub(super) fn grow(&mut self, k: usize, near: f64) {
        let push = if k == 0 { self.push } else { 0.0 };
        let far = push - (1.0 - self.share) * self.pull(k);
        let over = 1.0 / (k as f64 + 1.0);
        self.angle.series[k + 1] = self.speed.series[k] * over;
        self.speed.series[k + 1] = (far - near) * over;
    }
}
