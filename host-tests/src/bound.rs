//! How good any linear unbiased estimate can be: the error of generalised least squares that knows the noise's covariance, which is
//! the Cramer-Rao bound for normal noise.
//!
//! Known are: nominal motion, damping and density of the torque noise, the time stamps' rounding (uniform over a tick). Not known are:
//! the geometry at every order, start angle and speed of every recording (and the ramp's acceleration), and, as asked for, torque
//! locked to the shaft at no order, at those of the cogging or at every order.
//!
//! Low orders, where nearly all of the noise is, are solved exactly on fewer points a turn than the disc has edges; above them each
//! order's variance is that of a long recording.

pub mod gls;
pub mod high;
pub mod pass;
pub mod shaft;

#[cfg(test)]
mod tests;

use std::f64::consts::TAU;

use crate::anywhere::{self, Rig, Scenario};
use gls::{Gls, Problem};
use pass::Pass;
use shaft::Shaft;

/// At which orders there may be torque locked to the shaft, of unknown size and phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LockedTorque {
    /// At none.
    None,
    /// At the orders of the cogging, [`anywhere::COGGING`].
    Cogging,
    /// At every order.
    Every,
}

/// A bound.
#[derive(Clone, Debug)]
pub struct Bound {
    /// Standard error of order n's part of e, RMS over a turn, rad, at n - 1, up to half the edges; infinite where the order can't
    /// be told from locked torque.
    pub orders: Vec<f64>,
}

impl Bound {
    /// RMS error over all edges, rad, with the orders left out that are not to be told from torque; infinite where none is.
    #[must_use]
    pub fn rms(&self) -> f64 {
        let known = self.orders.iter().filter(|se| se.is_finite());
        known
            .map(|se| se * se)
            .reduce(|sum, square| sum + square)
            .map_or(f64::INFINITY, f64::sqrt)
    }

    /// Orders that are not to be told from torque.
    #[must_use]
    pub fn unknown(&self) -> Vec<usize> {
        let orders = (1..).zip(&self.orders);
        orders
            .filter(|(_, se)| se.is_infinite())
            .map(|(n, _)| n)
            .collect()
    }

    /// RMS error over all edges, rad, where the orders that are not to be told from torque are left as they are, so that
    /// `truth`'s own part of them stays.
    #[must_use]
    pub fn rms_left_alone(&self, truth: &[f64]) -> f64 {
        let edges = truth.len() as f64;
        let left = self.unknown().into_iter().map(|order| {
            let (mut re, mut im) = (0.0, 0.0);
            for (k, e) in truth.iter().enumerate() {
                let (sin, cos) = (TAU * (order * k) as f64 / edges).sin_cos();
                re += e * cos / edges;
                im += e * sin / edges;
            }
            2.0 * (re * re + im * im)
        });
        (self.rms().powi(2) + left.sum::<f64>()).sqrt()
    }
}

/// Recordings of a rig as the ideal estimator sees them: 11 turns of each speed, all turns of the ramp.
///
/// A speed loop whose gains are known makes a torque that is known from the edges, so what is left is the free shaft with the same
/// torque noise and its own friction.
#[must_use]
pub fn passes(rig: Rig) -> Vec<Pass> {
    let looped = rig.scenario == Scenario::SpeedLoop;
    let friction = rig.twins(0)[0].shaft;
    let shaft = Shaft {
        damping: if looped {
            friction.viscous_n_m_s / friction.inertia_kg_m2
        } else {
            anywhere::damping()
        },
        density: anywhere::noise_density(),
        settled: !looped,
    };
    let pass = |r_min: f64| Pass {
        shaft,
        from_rad_s: r_min * TAU / 60.0,
        rate: 0.0,
        turns: anywhere::TURNS as usize,
        stamp_s: 1.0 / (12.0_f64.sqrt() * anywhere::CLOCK_HZ as f64),
    };
    match rig.scenario {
        Scenario::TwoSpeeds | Scenario::SpeedLoop => {
            vec![pass(anywhere::SLOW_R_MIN), pass(anywhere::FAST_R_MIN)]
        }
        Scenario::OneSpeed | Scenario::OneSpeedCogging => vec![pass(anywhere::SLOW_R_MIN)],
        Scenario::Ramp => {
            let start = anywhere::slow_rad_s();
            let rate = (anywhere::RAMP_END_R_MIN * TAU / 60.0 - start) / anywhere::ramp_s();
            let before = anywhere::RAMP_MARGIN_TURNS * TAU;
            vec![Pass {
                from_rad_s: (start * start + 2.0 * rate * before).sqrt(),
                rate,
                turns: anywhere::RAMP_TURNS as usize,
                // The cogging at the slowest speeds swings the start by far more than the noise does.
                shaft: Shaft {
                    settled: false,
                    ..shaft
                },
                ..pass(anywhere::SLOW_R_MIN)
            }]
        }
    }
}

/// Points a turn for [`bound`]: enough for the bound to stay within a thousandth when they are doubled.
#[must_use]
pub const fn usual_points(scenario: Scenario) -> usize {
    match scenario {
        Scenario::Ramp => 64,
        _ => 128,
    }
}

/// The bound of a rig, solved on `points` a turn (all edges where there are fewer), a multiple of 4 and at least 64 where locked
/// torque may be at the cogging's orders only.
#[must_use]
pub fn bound(rig: Rig, torque: LockedTorque, points: usize) -> Bound {
    let edges = 4 * rig.lines as usize;
    let points = points.min(edges);
    let passes = passes(rig);
    let solvable = passes.len() > 1 || passes[0].rate != 0.0;
    let locked = |order: usize| match torque {
        LockedTorque::None => false,
        LockedTorque::Cogging => anywhere::COGGING.iter().any(|(n, _)| *n == order as f64),
        LockedTorque::Every => true,
    };
    let mut orders: Vec<f64> = (1..=edges / 2)
        .map(|order| high::variance(&passes, order as f64, edges, locked(order)).sqrt())
        .collect();
    // At half the edges there is one amplitude in place of two.
    orders[edges / 2 - 1] /= 2.0_f64.sqrt();
    let solved: Vec<usize> = (1..points / 2)
        .filter(|order| solvable || !locked(*order))
        .collect();
    let problem = Problem {
        passes,
        points,
        stamp_share: points as f64 / edges as f64,
        ripple: solved.iter().copied().filter(|n| locked(*n)).collect(),
        orders: solved.clone(),
    };
    // Near half the points the torque noise folds down, which it does not with all edges.
    let sound = if points == edges { points } else { points / 4 };
    let variances =
        Gls::new(problem).map_or_else(|| vec![f64::INFINITY; solved.len()], |gls| gls.variances());
    for (order, variance) in solved.into_iter().zip(variances) {
        if order <= sound {
            orders[order - 1] = variance.sqrt();
        }
    }
    Bound { orders }
}
