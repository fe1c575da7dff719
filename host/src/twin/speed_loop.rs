//! The speed loop of a twin's drive, worked out: gains as accelerations, and the speed that the loop sees.

use std::f64::consts::TAU;

use quadcal::edge::Direction;

use super::{Drive, Twin};

/// Intervals of the speed asked for without an edge after which the measured speed is zero, where a twin does not say.
const TIMEOUT_INTERVALS: f64 = 20.0;

/// Gains of a PI speed loop as accelerations: torque over inertia.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// Proportional gain, rad/s^2 a rad/s.
    pub kp: f64,
    /// Integral gain, rad/s^2 a rad.
    pub ki: f64,
}

/// A [`Drive::SpeedLoop`] with what it leaves out filled in; torques are divided by the inertia.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedLoop {
    /// Speed asked for, rad/s; negative for reverse.
    pub target_rad_s: f64,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Gains over inertia.
    pub gains: Gains,
    /// Most acceleration the drive gives either way, rad/s^2; infinite without a limit.
    pub limit: f64,
    /// The measured speed is zero when no edge came for so long, s.
    pub timeout_s: f64,
    /// Acceleration that the integrator holds at the start, rad/s^2: that of friction at the speed asked for.
    pub start: f64,
}

impl Twin {
    /// The speed loop of the drive; none where it is open loop.
    #[must_use]
    pub fn speed_loop(&self) -> Option<SpeedLoop> {
        let Drive::SpeedLoop {
            f_hz,
            bandwidth_hz,
            kp_n_m_s,
            ki_n_m,
            timeout_s,
            limit_n_m,
            ..
        } = self.drive
        else {
            return None;
        };
        let inertia = self.shaft.inertia_or_one();
        let target = self.drive.nominal_rad_s();
        let gains = match bandwidth_hz {
            Some(bandwidth) => {
                let kp = TAU * bandwidth;
                Gains {
                    kp,
                    ki: kp * TAU * bandwidth / 5.0,
                }
            }
            None => Gains {
                kp: kp_n_m_s.unwrap_or(0.0) / inertia,
                ki: ki_n_m.unwrap_or(0.0) / inertia,
            },
        };
        let friction = self.friction_n_m(target.abs()) / inertia * target.signum();
        let interval_s = TAU / f64::from(self.encoder.grid_edges()) / target.abs();
        Some(SpeedLoop {
            target_rad_s: target,
            rate_hz: f_hz,
            gains,
            limit: limit_n_m.map_or(f64::INFINITY, |limit| limit / inertia),
            timeout_s: timeout_s.unwrap_or(TIMEOUT_INTERVALS * interval_s),
            start: self.shaft.viscous_n_m_s / inertia * target + friction,
        })
    }
}

/// The speed that a loop sees: the way from edge to edge over the last interval in ticks (T-method, equation (2)).
#[derive(Clone, Copy, Debug)]
pub struct SeenSpeed {
    clock_hz: f64,
    step_rad: f64,
    timeout_ticks: f64,
    direction: Option<Direction>,
    /// Tick of the last edge, or from which on the first is waited for.
    last: Option<u64>,
    rad_s: Option<f64>,
}

impl SeenSpeed {
    /// No speed yet. `step_rad` is a step of the grid; the first edge is waited for from tick `from` on, without an end where there
    /// is none.
    #[must_use]
    pub fn new(clock_hz: f64, step_rad: f64, timeout_s: f64, from: Option<u64>) -> Self {
        Self {
            clock_hz,
            step_rad,
            timeout_ticks: timeout_s * clock_hz,
            direction: None,
            last: from,
            rad_s: None,
        }
    }

    /// Takes an edge captured at `ticks`, `steps` of the grid after the one before.
    #[allow(clippy::cast_precision_loss)]
    pub fn edge(&mut self, ticks: u64, direction: Direction, steps: u32) {
        if let (Some(last), Some(before)) = (self.last, self.direction) {
            let interval = ticks.saturating_sub(last);
            if before != direction {
                // The same edge again: the shaft turned round in between.
                self.rad_s = Some(0.0);
            } else if interval > 0 {
                let way = f64::from(direction.sign()) * f64::from(steps) * self.step_rad;
                self.rad_s = Some(way * self.clock_hz / interval as f64);
            }
        }
        (self.last, self.direction) = (Some(ticks), Some(direction));
    }

    /// The speed seen at tick `now`, rad/s: zero when no edge came for the timeout, none until the first interval ends.
    #[allow(clippy::cast_precision_loss)]
    pub fn at(&mut self, now: f64) -> Option<f64> {
        let late = |last: u64| now - last as f64 > self.timeout_ticks;
        if self.last.is_some_and(late) {
            self.rad_s = Some(0.0);
        }
        self.rad_s
    }
}
