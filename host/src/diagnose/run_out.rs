//! A twin's run-out, exactly: it goes by the angle at which the shaft is when a mark passes, so it moves the angle that it goes by.

use super::seen::Seen;
use crate::twin::Twin;

/// Newton's steps at the most.
const STEPS: usize = 20;
/// Last step that is small enough, rad.
const NEAR_RAD: f64 = 1e-14;

/// One run-out: amplitude sin(order theta + phase).
#[derive(Clone, Copy, Debug)]
struct RunOut {
    order: f64,
    amplitude_rad: f64,
    phase_rad: f64,
}

/// The run-outs of a twin.
#[derive(Clone, Debug, Default)]
pub struct RunOuts(Vec<RunOut>);

impl RunOuts {
    /// Of a twin's bearings.
    #[must_use]
    pub fn of(twin: &Twin) -> Self {
        let each = twin.bearing.iter().filter_map(|bearing| {
            Some(RunOut {
                order: bearing.order,
                amplitude_rad: bearing.runout_rad?,
                phase_rad: bearing.phase_rad,
            })
        });
        Self(each.collect())
    }

    /// How much further along a mark is than the shaft that it passes on, rad: theta + off(theta) is the mark's angle.
    fn off_rad(&self, mark_rad: f64) -> f64 {
        let mut theta = mark_rad;
        for _ in 0..STEPS {
            let (mut off, mut slope) = (theta - mark_rad, 1.0);
            for one in &self.0 {
                let (sin, cos) = (one.order * theta + one.phase_rad).sin_cos();
                off += one.amplitude_rad * sin;
                slope += one.amplitude_rad * one.order * cos;
            }
            let step = off / slope;
            theta -= step;
            if step.abs() < NEAR_RAD {
                break;
            }
        }
        mark_rad - theta
    }
}

impl Seen {
    /// Takes off the run-out of the disc as it is known now.
    pub(super) fn run_out(&mut self) {
        if self.run_outs.0.is_empty() {
            return;
        }
        let off: Vec<f64> = (0..self.len())
            .map(|at| self.run_outs.off_rad(self.mark_theta(at)))
            .collect();
        for (at, angle) in self.angles.iter_mut().enumerate() {
            *angle -= off[at] - self.run_off.get(at).copied().unwrap_or(0.0);
        }
        self.run_off = off;
    }
}
