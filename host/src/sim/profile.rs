//! What an open-loop profile asks for where it is no straight line: its speed, and the push that follows it, as series in time.

use super::drive::Knot;
use super::extended::Friction;
use super::plant::Plant;
use super::taylor::{DEGREE, Series};
use crate::twin::{SpeedDrift, Twin};

/// How the speed of a profile drifts, over the speed.
#[derive(Clone, Copy, Debug)]
enum Drift {
    Linear { per_s: f64 },
    Settling { fraction: f64, tau_s: f64 },
}

/// A profile with its drift, and all that its push balances.
#[derive(Clone, Debug)]
pub(super) struct Profile {
    drift: Drift,
    /// Coulomb friction, rad/s^2.
    coulomb: f64,
    friction: Friction,
    /// Stiffness of the drive, 1/s.
    stiffness: f64,
    /// Whether it pulls through a spring and balances nothing.
    through_spring: bool,
}

impl Profile {
    pub(super) fn new(twin: &Twin, plant: &Plant, friction: Friction) -> Self {
        let drift = match twin.speed_drift {
            Some(SpeedDrift {
                fraction: Some(fraction),
                tau_s: Some(tau_s),
                ..
            }) => Drift::Settling { fraction, tau_s },
            drift => Drift::Linear {
                per_s: drift.and_then(|drift| drift.fraction_per_s).unwrap_or(0.0),
            },
        };
        Self {
            drift,
            coulomb: plant.coulomb,
            friction,
            stiffness: plant.damping - plant.viscous,
            through_spring: twin.stick_slip.is_some(),
        }
    }

    /// Push, rad/s^2, and speed asked for, rad/s, around a time.
    pub(super) fn around(&self, knot: &Knot, now_s: f64) -> (Series, Series) {
        let (mut push, mut asked) = ([0.0; DEGREE], [0.0; DEGREE]);
        let since_s = now_s - knot.from_s;
        if !knot.driven {
            (push[0], push[1]) = (knot.level + knot.slope * since_s, knot.slope);
            return (push, asked);
        }
        let speed = knot.speed + knot.rate * since_s;
        let drift = self.drift_around(now_s);
        asked[0] = speed * drift[0];
        for k in 1..DEGREE {
            asked[k] = speed * drift[k] + knot.rate * drift[k - 1];
        }
        if self.through_spring {
            for (push, asked) in push.iter_mut().zip(asked) {
                *push = self.stiffness * asked;
            }
            return (push, asked);
        }
        let mut falling = [0.0; DEGREE];
        for k in 0..DEGREE {
            let next = if k + 1 < DEGREE { asked[k + 1] } else { 0.0 };
            push[k] = self.push(k, knot, &asked, next * (k as f64 + 1.0), &mut falling);
        }
        (push, asked)
    }

    /// Term `k` of the push that follows a speed, rad/s^2, given terms 0 to `k` of that and term `k` of its rate; `falling` keeps terms of
    /// the friction.
    pub(super) fn push(
        &self,
        k: usize,
        knot: &Knot,
        asked: &Series,
        rate: f64,
        falling: &mut Series,
    ) -> f64 {
        if self.through_spring {
            return self.stiffness * asked[k];
        }
        let against = self.friction.term(k, asked, falling);
        let coulomb = if k == 0 { self.coulomb } else { 0.0 };
        rate + knot.damping * asked[k] + knot.towards * against + knot.towards * coulomb
    }

    /// 1 + drift around a time.
    fn drift_around(&self, now_s: f64) -> Series {
        let mut drift = [0.0; DEGREE];
        match self.drift {
            Drift::Linear { per_s } => {
                drift[0] = 1.0 + per_s * now_s;
                drift[1] = per_s;
            }
            Drift::Settling { fraction, tau_s } => {
                let mut left = -fraction * libm::exp(-now_s / tau_s);
                for (k, term) in drift.iter_mut().enumerate() {
                    *term = left;
                    left /= -tau_s * (k as f64 + 1.0);
                }
                drift[0] += 1.0 + fraction;
            }
        }
        drift
    }

    /// Fastest rate of change around a knot, 1/s: the series is good for a fraction of its inverse.
    pub(super) fn fastest(&self, knot: &Knot) -> f64 {
        let drift = match self.drift {
            Drift::Linear { .. } => 0.0,
            Drift::Settling { tau_s, .. } => 1.0 / tau_s,
        };
        drift.max(knot.rate.abs() * self.friction.per_speed())
    }
}
