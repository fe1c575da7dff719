//! Times at which something changes suddenly: no step of the integrator goes across one.

use crate::effect::Effect;
use crate::rig::{Profile, Rig};

/// The times, in order.
#[derive(Clone, Debug)]
pub struct Sudden(Vec<f64>);

impl Sudden {
    /// All of a rig with its effects; `jumps` are the effects' random ones.
    #[must_use]
    pub fn new(rig: &Rig, effects: &[Effect], jumps: &[Vec<f64>]) -> Self {
        let mut times: Vec<f64> = match rig.profile {
            Profile::Ramp { from, to, over_s } => {
                let zero = from / (from - to) * over_s;
                vec![over_s, zero]
            }
            Profile::RunDown { off_s, .. } => vec![off_s],
            Profile::Free(pieces) => pieces.sudden(),
            Profile::Constant { .. } | Profile::Loop { .. } => Vec::new(),
        };
        for (effect, jumps) in effects.iter().zip(jumps) {
            times.extend(effect.sudden(jumps));
        }
        times.retain(|time| time.is_finite() && *time > 0.0);
        times.sort_by(f64::total_cmp);
        Self(times)
    }

    /// The next after a time, s; infinite after the last.
    #[must_use]
    pub fn next_after(&self, time_s: f64) -> f64 {
        let next = self.0.partition_point(|&time| time <= time_s);
        self.0.get(next).copied().unwrap_or(f64::INFINITY)
    }
}
