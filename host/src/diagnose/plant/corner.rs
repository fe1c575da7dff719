//! Corners of the speed of a drive that nobody declared: where its acceleration jumps.
//!
//! Such a drive is a slow drift of the acceleration, as dense all along. A profile of ramps and holds is none: spread over the whole
//! recording, its corners would make that noise many times too dense. So the drift is open by the size of the jump where one is sure.

use super::leaps::Gains;
use crate::diagnose::filter::Pull;

/// A corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// When, s.
    pub time_s: f64,
    /// By how much the acceleration changes, rad/s^2.
    pub jump: f64,
    /// By how much the speed does, rad/s: where the shaft rests for a while, both go on from there.
    pub kick: f64,
}

impl Corner {
    /// Numbers of one.
    pub const NUMBERS: usize = 3;
}

/// Edges to either side of a corner whose stamps may make what looks like it.
const SHOWN: usize = 4;
/// Corners that are found at once at the most.
const MOST: usize = 256;

/// Innovations of a recording over their deviations, with what corners of it are found by.
#[derive(Clone, Copy, Debug)]
pub struct White<'a> {
    /// The filter.
    pub gains: &'a Gains,
    /// The innovations, weighed.
    pub innovations: &'a [f64],
    /// The same, those that are far out brought near.
    pub near: &'a [f64],
    /// Weight of each edge.
    pub weights: &'a [f64],
    /// Time of each edge, s.
    pub time_s: &'a [f64],
}

impl White<'_> {
    /// Corners that are worth so much at the least, each the best of its neighbours; one at which the speed jumps too has to be worth so much
    /// more.
    pub fn corners(&self, worth: f64) -> Vec<Corner> {
        let pulls = |innovations: &[f64]| self.gains.pulls(innovations, self.weights);
        let sizes = pulls(self.innovations);
        let near = pulls(self.near);
        let gain = |pull: &Pull| pull.of_drift().0.max(pull.of_both().0 - worth);
        // A stamp that is far out is no corner: what is worth more than the error of any stamp that shows it is one.
        let beyond = |at: usize| {
            let about = at.saturating_sub(SHOWN)..(at + SHOWN).min(sizes.len());
            let stamps = sizes[about].iter().map(|pull| pull.of_stamp);
            gain(&sizes[at]) - stamps.fold(0.0, f64::max)
        };
        let gains: Vec<f64> = (0..near.len())
            .map(|at| gain(&near[at]).max(beyond(at)))
            .collect();
        let mut found: Vec<(f64, Corner)> = Vec::new();
        let mut first = 0;
        for stretch in gains.chunk_by(|a, b| (*a > worth) == (*b > worth)) {
            let each = stretch.iter().enumerate();
            let best = each.max_by(|a, b| a.1.total_cmp(b.1));
            if let Some((best, most)) = best.filter(|(_, gain)| **gain > worth) {
                let at = first + best;
                let here = if gain(&near[at]) > worth {
                    &near[at]
                } else {
                    &sizes[at]
                };
                let rests = here.of_both().0 - worth > here.of_drift().0;
                let [jump, kick] = match rests {
                    true => sizes[at].of_both().1,
                    false => [sizes[at].of_drift().1, 0.0],
                };
                let time_s = 0.5 * (self.time_s[at.saturating_sub(1)] + self.time_s[at]);
                found.push((*most, Corner { time_s, jump, kick }));
            }
            first += stretch.len();
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found.truncate(MOST);
        found.into_iter().map(|(_, corner)| corner).collect()
    }
}
