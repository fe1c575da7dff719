//! Samples of a speed loop that came close to an edge.

use super::Bench;
use crate::diagnose::lsq::add;
use crate::diagnose::plant::Here;
use crate::diagnose::speed_loop::{self, Tie};
use crate::twin::SpeedLoop;

impl Bench {
    /// Decides for each sample of a declared speed loop that came close to an edge whether it saw it: by the innovations after it, of
    /// residual angles beside all that is known else.
    pub fn decide_ties(&mut self, rest: &[f64]) {
        let Some(looped) = self.twin.speed_loop() else {
            return;
        };
        let rest: Vec<f64> = rest.iter().zip(&self.tied).map(|(a, b)| a + b).collect();
        let mut tied = vec![0.0; self.record.len()];
        for (_, first, angles) in self.other_ties(&looped, &rest) {
            add(&mut tied[first..], 1.0, &angles);
        }
        for (at, now) in tied.iter().enumerate() {
            let by = now - self.tied[at];
            self.own[at] -= by;
            self.residual[at] -= by;
        }
        self.tied = tied;
    }

    /// Samples of a speed loop that saw an edge which they seem to have missed, or the other way: what that does to angles from an edge on,
    /// rad.
    pub fn other_ties(&self, looped: &SpeedLoop, rest: &[f64]) -> Vec<(Tie, usize, Vec<f64>)> {
        // Edges after it that tell, and for how long the torque of a sample shows in the angle, in steps of the loop.
        const EDGES: usize = 12;
        const STEPS: f64 = 3.0;
        let along = speed_loop::along(looped, &self.record, &self.twin, self.noise.stamp_s);
        let count = self.record.len();
        let mut white = rest.to_vec();
        self.gains.whiten(&mut white);
        let mut others = Vec::new();
        for tie in along.ties {
            let times = &self.course.time_s;
            let after = times.partition_point(|time| *time <= tie.at_s);
            let first = after.saturating_sub(1);
            if after == 0 || after >= count {
                continue;
            }
            let until_s = tie.at_s + tie.step_s;
            let shown_s = tie.at_s + STEPS * tie.step_s;
            let shown = times.partition_point(|time| *time <= shown_s);
            let shown = shown.max(after + EDGES).min(count);
            let push = |here: Here| {
                if here.inside_s < tie.at_s {
                    0.0
                } else if here.inside_s < until_s {
                    tie.push
                } else {
                    tie.lasting
                }
            };
            let breaks = [tie.at_s, until_s];
            let answer = |until: usize| {
                self.plant
                    .response_over(first..until, &self.course, push, |_| 0.0, &breaks)
            };
            let mut short = answer(shown);
            self.gains.whiten_from(first, &mut short);
            let here = white[first..].iter().zip(&short);
            let gain: f64 = here
                .map(|(white, other)| white * white - (white - other).powi(2))
                .sum();
            if gain > 0.0 {
                let long = answer(count);
                let mut whitened = long.clone();
                self.gains.whiten_from(first, &mut whitened);
                add(&mut white[first..], -1.0, &whitened);
                others.push((tie, first, long));
            }
        }
        others
    }
}
