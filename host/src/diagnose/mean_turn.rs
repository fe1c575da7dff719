//! One turn in place of all that were recorded: what stands for a disc's normal matrix where that is divided by.
//!
//! In angle, not in time, every turn of a free shaft is alike: torque noise of density q makes its angle wander with q / speed^3, a drift
//! of density d with d / speed^5 that fades with its rate / speed, and a stamp is off by speed times its error. Turns add what they know
//! of the disc, so the mean turn has the sum of the inverse of both. With C the covariance of what it leaves of the edges' errors,
//! 1 / (1 / C + 1 / s^2) is s^2 - s^4 / (C + s^2), whose last term is a filter run there and back for edges that are blurred by s,
//! around the turn.

use std::f64::consts::TAU;

use super::bench::Bench;
use super::filter::{Around, DRIFTING, Filter, Leap, Noise};
use super::plant::free;

/// Turns and edges, at the least, in which the gains settle to those of a turn without ends.
const SETTLES: [usize; 2] = [4, 400];
/// Part of the usual speed that counts as slow.
const SLOW: f64 = 0.5;
/// Part of a step that edges are apart at the least.
const APART: f64 = 1e-3;
/// Variance of an edge's error over the least one that the recordings leave of it, from which on differences are lost in rounding.
const CLEAR: f64 = 1e9;

/// The mean turn.
#[derive(Clone, Debug)]
pub struct MeanTurn {
    leaps: Vec<Leap<DRIFTING>>,
    /// Density of the wander, 1/rad, and of that of a drift, 1/rad^3.
    wander: [f64; 2],
    /// How fast a drift fades, 1/rad.
    fade: f64,
    /// RMS error that stamps leave of each edge, rad.
    own_rad: Vec<f64>,
    /// Least variance that the recordings leave of an edge, rad^2.
    least2: f64,
    filter: Option<Around<DRIFTING>>,
    /// Variance of an edge's error, rad^2.
    size2: f64,
}

impl MeanTurn {
    /// Of recordings of one disc.
    pub fn new(benches: &[Bench], edges: usize) -> Self {
        let step = TAU / edges as f64;
        let mut known = vec![0.0; edges];
        let mut apart = vec![(0.0, 0.0); edges];
        let (mut stiff, mut fade, mut all) = ([0.0; 2], 0.0, 0.0);
        for bench in benches {
            let (record, noise, usual) = (&bench.record, bench.noise(), bench.leaps.speed());
            for at in 0..record.len() {
                let steady = bench.course.steady[at].abs();
                let weight = (bench.weights[at] * bench.tails[at]).powi(2);
                // Where the shaft hardly turns it wanders by more from edge to edge than stamps are off.
                let speed = bench.course.speed[at].abs().max(SLOW * usual);
                let stamp_s = noise.stamp_s.hypot(bench.course.doubt_s[at]);
                let own2 = (speed * stamp_s).powi(2) + noise.angle_rad.powi(2) + 1e-30;
                known[record.slot(at)] += weight / own2;
                let part = weight / edges as f64;
                stiff[0] += part * steady.powi(3) / noise.torque;
                stiff[1] += part * steady.powi(5) / noise.drift;
                fade += noise.fade / speed;
                all += 1.0;
                if at > 0 && (record.place[at] - record.place[at - 1]).abs() == 1 {
                    let from = record.place[at].min(record.place[at - 1]);
                    let (sum, count) = &mut apart[from.rem_euclid(edges as i64) as usize];
                    *sum += steady * (record.time_s[at] - record.time_s[at - 1]);
                    *count += 1.0;
                }
            }
        }
        let most = known.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let turns = SETTLES[0].max(SETTLES[1].div_ceil(edges));
        let leaps = (0..turns * edges).map(|at| {
            let (sum, count) = apart[(at + edges - 1) % edges];
            let apart = if count > 0.0 { sum / count } else { step };
            let apart = apart.clamp(APART * step, edges as f64 * step);
            free(apart)
        });
        let leaps: Vec<Leap<DRIFTING>> = leaps.collect();
        Self {
            filter: None,
            fade: fade / f64::max(all, 1.0),
            wander: stiff.map(|stiff| f64::max(stiff, f64::MIN_POSITIVE).recip()),
            own_rad: known
                .iter()
                .map(|known| known.max(1e-12 * most).recip().sqrt())
                .collect(),
            least2: most.recip(),
            leaps,
            size2: 0.0,
        }
    }

    /// Sets the variance of an edge's error, rad^2.
    pub fn set_size(&mut self, size2: f64) {
        self.size2 = size2.min(CLEAR * self.least2);
        self.filter = None;
        if self.size2 <= 0.0 {
            return;
        }
        // All as parts of that error: a start that is unknown stays within the digits.
        let size = self.size2.sqrt();
        let each = self.leaps.iter_mut().zip(self.own_rad.iter().cycle());
        each.for_each(|(leap, own_rad)| leap.doubt_s = own_rad / size);
        let [torque, drift] = self.wander.map(|wander| wander / self.size2);
        let noise = Noise {
            torque,
            drift,
            fade: self.fade,
            angle_rad: 1.0,
            ..Noise::default()
        };
        let filter = Filter::<DRIFTING>::new(&self.leaps, &noise);
        self.filter = Some(filter.around(self.own_rad.len()));
    }

    /// A row divided by about the normal matrix.
    pub fn divided(&self, row: &[f64]) -> Vec<f64> {
        let mut fold = row.to_vec();
        if let Some(filter) = &self.filter {
            filter.whiten(&mut fold);
            filter.transposed(&mut fold);
        }
        let each = row.iter().zip(fold);
        let each = each.map(|(value, fold)| self.size2 * (value - fold));
        each.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::filter::{State, Whitens};

    /// A turn of edges that come unevenly.
    fn turn(edges: usize) -> Vec<Leap<DRIFTING>> {
        let leap = |at: usize| {
            let apart = 0.01 * (1.0 + 0.3 * (at % edges % 4) as f64);
            let mut leap = Leap {
                doubt_s: 0.1,
                ..free(apart)
            };
            // A drift would take more turns to settle.
            leap.way.0[State::Drift as usize] = [0.0; DRIFTING];
            leap
        };
        (0..40 * edges).map(leap).collect()
    }

    fn row(edges: usize, by: f64) -> Vec<f64> {
        (0..edges).map(|at| (by * (at * at) as f64).sin()).collect()
    }

    #[test]
    fn around_a_turn_is_the_end_of_many() {
        let noise = Noise {
            torque: 3.0,
            angle_rad: 1.0,
            ..Noise::default()
        };
        let filter = Filter::<DRIFTING>::new(&turn(40), &noise);
        let mut one = row(40, 0.7);
        let mut many = one.repeat(40);
        filter.around(40).whiten(&mut one);
        filter.whiten(&mut many);
        for (one, many) in one.iter().zip(&many[39 * 40..]) {
            assert!((one - many).abs() < 1e-9, "{one} {many}");
        }
    }

    #[test]
    fn back_around_a_turn_is_the_transposed() {
        let noise = Noise {
            torque: 3.0,
            angle_rad: 1.0,
            ..Noise::default()
        };
        let around = Filter::<DRIFTING>::new(&turn(40), &noise).around(40);
        let (angles, values) = (row(40, 0.7), row(40, 1.9));
        let (mut white, mut back) = (angles.clone(), values.clone());
        around.whiten(&mut white);
        around.transposed(&mut back);
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (there, here) = (product(&white, &values), product(&angles, &back));
        assert!((there - here).abs() < 1e-10, "{there} {here}");
    }
}
