//! The displacement that a recorded torque made.

use std::sync::Arc;

use super::command::Shares;
use super::motion::Motion;

/// From a time on, a torque.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueStep {
    /// Since when, ticks; a part of a tick where it was between two rows.
    pub from: f64,
    /// Torque, N m.
    pub torque_n_m: f64,
}

/// What was recorded of the torque, and the shaft that it drove.
#[derive(Clone, Debug, PartialEq)]
pub struct TorqueRecord {
    /// The torque, by time.
    pub steps: Arc<[TorqueStep]>,
    /// Moment of inertia, kg m^2.
    pub inertia_kg_m2: f64,
    /// Viscous friction over inertia, 1/s.
    pub viscous: f64,
}

/// A shaft under a recorded torque.
#[derive(Clone, Debug)]
pub struct TorqueMotion {
    record: TorqueRecord,
    clock_hz: f64,
    motion: Motion<3>,
    push: f64,
    now: f64,
    next: usize,
}

impl TorqueMotion {
    /// At rest at tick `from`.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn new(record: &TorqueRecord, clock_hz: u64, from: u64) -> Self {
        let now = from as f64;
        let next = record.steps.partition_point(|step| step.from <= now);
        let held = next.checked_sub(1).and_then(|at| record.steps.get(at));
        let push = held.map_or(0.0, |step| step.torque_n_m / record.inertia_kg_m2);
        Self {
            record: record.clone(),
            clock_hz: clock_hz as f64,
            motion: Motion::new(record.viscous),
            push,
            now,
            next,
        }
    }

    /// Goes on to a tick, which is not before the last one, and gives the displacement there: all in the first share, for a gain of 1.
    #[allow(clippy::cast_precision_loss)]
    pub fn reach(&mut self, ticks: u64) -> Shares {
        let ticks = ticks as f64;
        while let Some(&step) = self.record.steps.get(self.next)
            && step.from <= ticks
        {
            self.advance(step.from);
            self.push = step.torque_n_m / self.record.inertia_kg_m2;
            self.next += 1;
        }
        self.advance(ticks);
        self.motion.angle()
    }

    fn advance(&mut self, to: f64) {
        self.motion
            .advance((to - self.now) / self.clock_hz, &[self.push, 0.0, 0.0]);
        self.now = self.now.max(to);
    }
}
