//! Corners of the speed of drives that nobody declared, where its acceleration jumps: open like the noise, and found with it.
//!
//! Such a drive is a slow drift of the acceleration, as dense all along. A profile of ramps and holds is none: spread over the whole
//! recording, its corners would make that noise many times too dense. So the drift is open by the size of the jump where one is sure.

use std::collections::BTreeSet;

use super::bench::{self, Bench};
use super::disc;
use super::effect::{Carrier, Effect, Site};
use super::filter::{Noise, Pull};
use super::lsq;
use super::model::{Board, Model, Wander};
use super::noise::FAR;
use super::pipeline::SEARCHED;
use super::scan::SURE;

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
/// Part of a noise beside corners, of that in which they are none.
const LESS: f64 = 1e-3;
/// Whole orders of a torque that may make what looks like corners.
const ORDERS: u32 = 32;

impl Board {
    /// Finds the corners of drives that nobody declared in what a model leaves, and the noise beside them. Whether they are between other
    /// edges than before: where not, nothing changes.
    pub fn find_corners(&mut self, model: &Model) -> bool {
        if !self.undriven || self.is_looped() {
            return false;
        }
        let mut board = self.clone();
        board.find_corners_anew(model);
        let other = board.bent() != self.bent();
        if other {
            *self = board;
        }
        other
    }

    fn find_corners_anew(&mut self, model: &Model) {
        // Of other edges they are between others.
        let before = (self.free, self.levels, self.rounds);
        let noise = self.noise;
        let again = self.has_corners();
        if !again && self.edges() > SEARCHED {
            return;
        }
        if again {
            *self = self.in_plain_noise();
            self.loosen(true);
            let each = self.benches.iter_mut();
            each.for_each(|bench| bench.bend(Vec::new()));
            self.fit_noise(model);
        }
        if self.show_corners(&disc::rests(self, model)) {
            self.find_beside_torques(model);
        } else if !again {
            return;
        }
        if again {
            self.loosen(false);
            (self.free, self.levels, self.rounds) = before;
            self.noise.ring = noise.ring;
            if self.free.fade {
                // Corners other than before may need a drift beside them that was none.
                let lasting = self.fading(Wander::Lasting);
                let rests = disc::rests(self, model);
                self.set_noise(self.likelier(&rests, [noise, lasting]));
            }
        }
        self.fit_noise(model);
    }

    /// Finds corners in what a model and torques that the twins may lack leave: those come again, and are no drive's.
    fn find_beside_torques(&mut self, model: &Model) {
        // Of more edges a model has those that show.
        let seen = self.edges() <= SEARCHED;
        let each = self.benches.iter().filter(|_| seen);
        let torques: Vec<Vec<Vec<f64>>> = each.map(torques).collect();
        // As corners and the noise bear on each other.
        for _ in 0..lsq::ROUNDS {
            let mut rests = disc::rests(self, model);
            for ((bench, rest), torques) in self.benches.iter().zip(&mut rests).zip(&torques) {
                less(bench, rest, torques);
            }
            self.set_noise(self.noise_beside(&rests));
            if !self.show_corners(&rests) {
                break;
            }
            for (bench, rest) in self.benches.iter_mut().zip(&rests) {
                let known = bench.found.corners.clone();
                bench.bend([known, corners(bench, rest)].concat());
            }
        }
    }

    /// Whether residual angles of any recording show corners.
    fn show_corners(&self, rests: &[Vec<f64>]) -> bool {
        let mut each = self.benches.iter().zip(rests);
        each.any(|(bench, rest)| !corners(bench, rest).is_empty())
    }

    /// The noise that residual angles have: the best of where the present one leads, and one with far less of what corners made dense.
    fn noise_beside(&self, rests: &[Vec<f64>]) -> Noise {
        let less = Noise {
            torque: LESS * self.noise.torque,
            drift: LESS * self.noise.drift,
            unseen: LESS.sqrt() * self.noise.unseen,
            stamp_s: 3.0 * self.noise.stamp_s,
            ..self.noise
        };
        self.likelier(rests, [self.noise, less])
    }

    /// The likelier one of where two noises lead.
    fn likelier(&self, rests: &[Vec<f64>], starts: [Noise; 2]) -> Noise {
        let fitted = starts.map(|start| bench::fit_noise(&self.benches, rests, start, self.free));
        let [one, other] = fitted;
        if other.1 < one.1 { other.0 } else { one.0 }
    }

    /// Intervals that have a corner, of each recording.
    fn bent(&self) -> Vec<BTreeSet<usize>> {
        let each = self.benches.iter().map(|bench| {
            let times = &bench.record.time_s;
            let corners = bench.found.corners.iter();
            corners
                .map(|corner| times.partition_point(|time_s| *time_s < corner.time_s))
                .collect()
        });
        each.collect()
    }

    fn has_corners(&self) -> bool {
        let mut benches = self.benches.iter();
        benches.any(|bench| !bench.found.corners.is_empty())
    }
}

/// Evidence below which a corner is none: it may be in any interval, and of any size.
fn worth(bench: &Bench) -> f64 {
    Corner::NUMBERS as f64 * (bench.record.len() as f64).ln() + SURE
}

/// Corners that residual angles of a recording show, each the best of its neighbours; one at which the speed jumps too has to be worth so
/// much more.
fn corners(bench: &Bench, rest: &[f64]) -> Vec<Corner> {
    let worth = worth(bench);
    let time_s = &bench.record.time_s;
    let weights = bench.weights.iter().zip(&bench.tails);
    let weights: Vec<f64> = weights.map(|(level, tail)| level * tail).collect();
    let innovations = bench.white(rest);
    // A stamp that is far out is no corner, which all edges after it show.
    let near = innovations.iter().map(|white| white.clamp(-FAR, FAR));
    let near: Vec<f64> = near.collect();
    let sizes = bench.gains.pulls(&innovations, &weights);
    let near = bench.gains.pulls(&near, &weights);
    let gain = |pull: &Pull| pull.of_drift().0.max(pull.of_both().0 - worth);
    // What is worth more than the error of any stamp that shows it is one.
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
            let time_s = 0.5 * (time_s[at.saturating_sub(1)] + time_s[at]);
            found.push((*most, Corner { time_s, jump, kick }));
        }
        first += stretch.len();
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found.into_iter().map(|(_, corner)| corner).collect()
}

/// What torques that a twin may lack make of each edge for unit of each, rad: friction, and waves that come again every turn. Halves of an order
/// are those of an engine, which does not turn round.
fn torques(bench: &Bench) -> Vec<Vec<f64>> {
    let turns_round = !bench.course.reversals_s.is_empty();
    let most = f64::from(ORDERS).min(0.5 * bench.record.of_edges as f64);
    let orders = (1..=2 * ORDERS).map(|half| 0.5 * f64::from(half));
    let orders = orders.filter(|order| *order <= most && (order.fract() == 0.0 || !turns_round));
    let friction = turns_round.then_some(Carrier::Power(0.0));
    let carriers = friction.into_iter().chain(orders.map(Carrier::Order));
    let each =
        carriers.flat_map(|carrier| bench.columns(&Effect::new(Site::Torque, carrier)).to_vec());
    each.collect()
}

/// Takes what columns make of residual angles off them.
fn less(bench: &Bench, rest: &mut [f64], columns: &[Vec<f64>]) {
    let white = bench.white_rows(columns.to_vec());
    let solved = lsq::solve(&white, &bench.white(rest));
    for (column, size) in columns.iter().zip(&solved.sizes) {
        lsq::add(rest, -size, column);
    }
}
