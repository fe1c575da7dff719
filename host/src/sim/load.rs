//! Loads that come and go at given times.

use crate::twin::Twin;

/// What the loads add up to from one instant to the next.
#[derive(Clone, Debug)]
pub(super) struct Loads {
    /// Instants, s, by time, and the acceleration from there on, rad/s^2.
    changes: Vec<(f64, f64)>,
    next: usize,
}

impl Loads {
    /// The loads of a twin.
    pub(super) fn new(twin: &Twin) -> Self {
        let mut instants: Vec<f64> = twin
            .load_step
            .iter()
            .flat_map(|load| std::iter::once(load.from_s).chain(load.until_s))
            .collect();
        instants.sort_by(f64::total_cmp);
        instants.dedup();
        // Summed anew at every instant, so that nothing is left when all are gone.
        let push = |now: f64| {
            let there = twin
                .load_step
                .iter()
                .filter(|load| load.from_s <= now && load.until_s.is_none_or(|until| now < until));
            there.map(|load| load.torque_n_m).sum::<f64>() / twin.shaft.inertia_or_one()
        };
        Self {
            changes: instants.iter().map(|&now| (now, push(now))).collect(),
            next: 0,
        }
    }

    /// Time of the next change, s; infinite after the last.
    pub(super) fn next_s(&self) -> f64 {
        self.changes
            .get(self.next)
            .map_or(f64::INFINITY, |change| change.0)
    }

    /// The acceleration until the next change.
    pub(super) fn change(&mut self) -> f64 {
        let push = self.changes.get(self.next).map_or(0.0, |change| change.1);
        self.next += 1;
        push
    }
}
