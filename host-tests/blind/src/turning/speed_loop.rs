//! The speed that a sampled loop sees, from edge to edge.

use super::Crossing;
use crate::rig::Rig;

/// A sampled PI loop; torques in N m, speeds in rad/s.
pub(super) struct Loop {
    pub(super) target: f64,
    pub(super) rate_hz: f64,
    pub(super) kp: f64,
    pub(super) ki: f64,
    pub(super) integral: f64,
    pub(super) samples: u64,
    pub(super) seen: Option<f64>,
    pub(super) last: Option<(f64, bool)>,
    /// Whether stamps are whole ticks.
    pub(super) rounds: bool,
}

impl Loop {
    /// Takes an edge as it is captured.
    pub(super) fn edge(&mut self, crossing: &Crossing, rig: &Rig) {
        let clock = rig.clock_hz as f64;
        let now = (crossing.time_s + crossing.error_s) * clock;
        let now = if self.rounds { now.floor() } else { now };
        if let Some((last, forward)) = self.last {
            let way = if crossing.forward { 1.0 } else { -1.0 } * rig.encoder.step_rad();
            if forward != crossing.forward {
                self.seen = Some(0.0);
            } else if now > last {
                self.seen = Some(way * clock / (now - last));
            }
        }
        self.last = Some((now, crossing.forward));
    }
}
