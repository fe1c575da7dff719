//! The displacement that a recorded torque made.

use std::sync::Arc;

use super::command::Shares;
use super::motion::Motion;

/// A torque as recorded: asked for since some time after `after`, ticks, and up to `from`; the two are one where it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueStep {
    /// The time of the row before.
    pub after: u64,
    /// The time of the row.
    pub from: u64,
    /// Torque, N m.
    pub torque_n_m: f64,
}

/// From a time on, ticks, a torque, N m.
type Held = (f64, f64);

/// What was recorded of the torque, and the shaft that it drove.
#[derive(Clone, Debug, PartialEq)]
pub struct TorqueRecord {
    held: Arc<[Held]>,
    inertia_kg_m2: f64,
    viscous: f64,
}

impl TorqueRecord {
    /// `steps` by time, an inertia, viscous friction over inertia, 1/s, and the ticks from one of the drive's samples to the next, if
    /// known. A change between two rows then was at the first sample between them, else it is taken to have been in the middle.
    #[must_use]
    pub fn new(
        steps: &[TorqueStep],
        inertia_kg_m2: f64,
        viscous: f64,
        sample_ticks: Option<f64>,
    ) -> Self {
        let samples = sample_ticks.map(|length| (length, phase_of(steps, length)));
        let held = steps.iter().map(|step| {
            #[allow(clippy::cast_precision_loss)]
            let (after, from) = (step.after as f64, step.from as f64);
            let at = match samples {
                Some((length, phase)) if from > after => {
                    let next = ((after - phase) / length).floor() + 1.0;
                    (next * length + phase).min(from)
                }
                _ => 0.5 * (after + from),
            };
            (at, step.torque_n_m)
        });
        Self {
            held: held.collect(),
            inertia_kg_m2,
            viscous,
        }
    }

    /// Viscous friction over inertia, 1/s.
    #[must_use]
    pub fn viscous(&self) -> f64 {
        self.viscous
    }
}

/// A sample's time within a sample's `length`, ticks, that lies within all steps shorter than that but for contradictions.
#[allow(clippy::cast_precision_loss)]
fn phase_of(steps: &[TorqueStep], length: f64) -> f64 {
    let mut bounds: Option<(f64, f64)> = None;
    // The first is what was held when the recording began, no change.
    for step in steps.iter().skip(1) {
        let width = (step.from - step.after) as f64;
        if width >= length {
            continue;
        }
        let Some((low, high)) = bounds else {
            bounds = Some((step.from as f64 - width, step.from as f64));
            continue;
        };
        // The step's end as near to the bounds as whole samples bring it.
        let middle = 0.5 * (low + high);
        let end = step.from as f64 - 0.5 * width - middle;
        let end = middle + (end - length * (end / length).round()) + 0.5 * width;
        let (low, high) = (low.max(end - width), high.min(end));
        if low <= high {
            bounds = Some((low, high));
        }
    }
    bounds.map_or(0.0, |(_, high)| high.rem_euclid(length))
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
        let next = record.held.partition_point(|&(at, _)| at <= now);
        let held = next.checked_sub(1).and_then(|at| record.held.get(at));
        let push = held.map_or(0.0, |(_, torque)| torque / record.inertia_kg_m2);
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
        while let Some(&(at, torque)) = self.record.held.get(self.next)
            && at <= ticks
        {
            self.advance(at);
            self.push = torque / self.record.inertia_kg_m2;
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

#[cfg(test)]
mod tests {
    use super::*;

    fn step(after: u64, from: u64, torque_n_m: f64) -> TorqueStep {
        TorqueStep {
            after,
            from,
            torque_n_m,
        }
    }

    #[test]
    fn sample_times_are_found_from_the_rows_between_which_the_torque_changes() {
        // Samples at 37 + 100 n.
        let steps = [
            step(130, 140, 1.0),
            step(236, 250, 2.0),
            step(330, 337, 3.0),
            step(405, 790, 4.0),
        ];
        let record = TorqueRecord::new(&steps, 1.0, 0.0, Some(100.0));
        let times: Vec<f64> = record.held.iter().map(|held| held.0).collect();
        assert_eq!(times, [137.0, 237.0, 337.0, 437.0]);
        let record = TorqueRecord::new(&steps[..2], 1.0, 0.0, None);
        assert_eq!(record.held[1].0, 243.0);
    }

    #[test]
    fn a_recorded_torque_turns_the_shaft() {
        let steps = [step(0, 0, 2.0), step(1000, 1000, 0.0)];
        let record = TorqueRecord::new(&steps, 4.0, 0.0, None);
        let mut motion = TorqueMotion::new(&record, 1000, 0);
        // Half a rad/s^2 for a second, then at half a rad/s.
        assert_eq!(motion.reach(1000)[0], 0.25);
        assert_eq!(motion.reach(3000)[0], 1.25);
    }
}
