//! A wheel found from its recording: pulses a turn, and where teeth are missing.
//!
//! The pattern of a turn repeats, whatever it is made of: gaps, teeth out of place, torques locked to the turn. So the pulses a turn are
//! the shift at which log intervals come again but for slow changes of speed. Then turns here and there in the recording vote for the
//! whole numbers of pitches that make their speed smoothest, and the wheels that got most votes are tried on all of it.

use std::cmp::Reverse;
use std::collections::HashMap;

use super::wheel::both;
use super::{Edges, Sensor, median, place};
use crate::recording::Row;

/// Most pulses a turn that are tried: wheels have fewer teeth, and time goes with the square.
const MOST_PULSES: usize = 400;
/// A pattern repeats where its changes cost this part of what they do at other shifts, and a shorter one is taken where it
/// is nearer to the best shift than to the others by this part: a shift of two turns fits an engine of four strokes a little better.
const REPEATS: f64 = 0.6;
const SHORTER: f64 = 0.25;
/// Most pitches of one step: longer gaps are rare, and each more has others look like it.
const MOST_PITCHES: usize = 6;
/// Turns that vote, and share of votes that a wheel needs to be tried.
const VOTES: usize = 61;
const TRIED: f64 = 0.15;
/// Prior of a wheel: log speeds a usual step apart differ by about this; price of a step that is not the usual one, and of its length.
const SWING: f64 = 0.15;
const UNLIKE: f64 = 6.0;
const PITCH: f64 = 0.1;

/// A wheel.
#[derive(Clone, Debug, PartialEq)]
pub struct WheelFound {
    /// For each tooth place whether a tooth is there; tooth 0 is the first behind the longest gap.
    pub present: Vec<bool>,
    /// Whether teeth are low.
    pub inverted: bool,
    /// How sure it is, 0 to 1: the share of turns that look like it.
    pub confidence: f64,
    /// Other wheels that turns look like, with their shares, best first.
    pub alternatives: Vec<(Vec<bool>, f64)>,
}

/// Finds the wheel of a recording of both edges of teeth, or of pulses whose levels say nothing. None where no pattern repeats, as
/// with teeth that are all alike: how many there are in a turn cannot be seen then.
#[must_use]
pub fn find_wheel(rows: &[Row], both_edges: bool) -> Option<WheelFound> {
    let kinds = if both_edges {
        both(rows).to_vec()
    } else {
        vec![rows.iter().map(|row| row.ticks).collect()]
    };
    let ballots = kinds.iter().filter_map(|ticks| vote(&log_intervals(ticks)));
    let votes = ballots.reduce(Ballot::better)?.votes;
    let all: usize = votes.iter().map(|(_, votes)| votes).sum();
    let enough = |(_, votes): &&(Vec<usize>, usize)| *votes as f64 >= TRIED * all as f64;
    let mut tried: Vec<(WheelFound, f64)> = Vec::new();
    for (steps, votes) in votes.iter().filter(enough) {
        let present = teeth(steps);
        let sensor = Sensor::Wheel {
            present: present.clone(),
            both_edges,
        };
        if let Ok(Edges { inverted, fit, .. }) = place(&sensor, 1, rows) {
            let wheel = WheelFound {
                present,
                inverted,
                confidence: *votes as f64 / all as f64,
                alternatives: Vec::new(),
            };
            tried.push((wheel, fit));
        }
    }
    tried.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    let mut tried = tried.into_iter().map(|(wheel, _)| wheel);
    let mut best = tried.next()?;
    best.alternatives = tried
        .map(|wheel| (wheel.present, wheel.confidence))
        .collect();
    Some(best)
}

/// Log intervals from the middle of a recording.
fn log_intervals(ticks: &[u64]) -> Vec<f64> {
    let most = 50 * MOST_PULSES;
    let skipped = ticks.len().saturating_sub(most) / 2;
    let pairs = ticks[skipped..].windows(2).take(most);
    pairs
        .map(|pair| ((pair[1] - pair[0]) as f64).max(0.5).ln())
        .collect()
}

/// What turns look like.
struct Ballot {
    /// Steps of a turn, in pitches, and how many turns look like it, most first.
    votes: Vec<(Vec<usize>, usize)>,
    /// Median cost of a turn.
    cost: f64,
}

impl Ballot {
    fn better(self, other: Self) -> Self {
        let shape = |ballot: &Self| {
            let (steps, _) = ballot.votes.first()?;
            let gaps = steps.iter().filter(|&&step| step > 1).count();
            Some((steps.len(), steps.iter().sum::<usize>(), gaps))
        };
        let worse = match (shape(&self), shape(&other)) {
            // The field beside a gap bends edges of one kind so far that one gap looks like two.
            (Some((n, pitches, gaps)), Some((same, all, fewer)))
                if n == same && pitches == all && gaps != fewer =>
            {
                fewer < gaps
            }
            _ => other.cost < self.cost,
        };
        if worse { other } else { self }
    }
}

fn vote(logs: &[f64]) -> Option<Ballot> {
    let pulses = period(logs)?;
    let apart = (logs.len() - pulses).div_ceil(VOTES).max(1);
    let mut costs = Vec::new();
    let mut votes: HashMap<Vec<usize>, usize> = HashMap::new();
    for turn in logs.windows(pulses).step_by(apart) {
        let (steps, cost) = steps(turn);
        costs.push(cost);
        *votes.entry(canonical(&steps)).or_default() += 1;
    }
    let mut votes: Vec<_> = votes.into_iter().collect();
    votes.sort_by_key(|(steps, votes)| (Reverse(*votes), steps.clone()));
    let cost = median(costs)?;
    Some(Ballot { votes, cost })
}

/// Pulses a turn: the least shift at which log intervals come again.
fn period(logs: &[f64]) -> Option<usize> {
    let most = MOST_PULSES.min(logs.len() / 3);
    let changes = |shift: usize| {
        let apart = logs[shift..].iter().zip(logs);
        let far: Vec<f64> = apart.map(|(late, early)| late - early).collect();
        let pairs = far.windows(2);
        pairs.map(|pair| (pair[1] - pair[0]).abs()).collect()
    };
    let all: Vec<Vec<f64>> = (1..=most).map(changes).collect();
    let spread = all.iter().filter_map(|changes| median(changes.clone()));
    let spread = spread.fold(f64::INFINITY, f64::min).max(1e-6);
    // Likelihood of a Student distribution: most intervals come again at any shift, it is the others that tell.
    let cost = |changes: &Vec<f64>| {
        let each = (changes.iter()).map(|change| (change / spread).powi(2).ln_1p());
        each.sum::<f64>() / changes.len() as f64
    };
    let costs: Vec<f64> = all.iter().map(cost).collect();
    let least = costs.iter().copied().reduce(f64::min)?;
    let others = median(costs.clone())?;
    if least > REPEATS * others {
        return None;
    }
    let near = least + SHORTER * (others - least);
    costs.iter().position(|cost| *cost < near).map(|at| at + 1)
}

/// The whole numbers of pitches that make a turn's speed smoothest, and what they cost.
fn steps(turn: &[f64]) -> (Vec<usize>, f64) {
    let one = steps_about(turn, 1);
    // Usual steps are seldom two pitches, as where a tooth is put between two others.
    let mut two = steps_about(turn, 2);
    two.1 += 2.0 * UNLIKE;
    if two.1 < one.1 { two } else { one }
}

/// As [`steps`], where most are of `usual` pitches.
fn steps_about(turn: &[f64], usual: usize) -> (Vec<usize>, f64) {
    let change = |(from, before): (f64, usize), (to, after): (f64, usize)| {
        let speeds = [from - (before as f64).ln(), to - (after as f64).ln()];
        let unlike = if after == usual { 0.0 } else { UNLIKE };
        let apart = 0.5 * (before + after) as f64 / usual as f64;
        (speeds[1] - speeds[0]).powi(2) / (2.0 * SWING * SWING * apart)
            + unlike
            + PITCH * after as f64 / usual as f64
    };
    let mut best = (Vec::new(), f64::INFINITY);
    for first in 1..=MOST_PITCHES {
        // Least cost of a way to each number of pitches, and where it came from.
        let mut costs = [f64::INFINITY; MOST_PITCHES];
        costs[first - 1] = 0.0;
        let mut from = Vec::with_capacity(turn.len());
        for pair in turn.windows(2) {
            let mut next = [(f64::INFINITY, 0); MOST_PITCHES];
            for (after, least) in (1..).zip(&mut next) {
                for (before, cost) in (1..).zip(&costs) {
                    let cost = cost + change((pair[0], before), (pair[1], after));
                    if cost < least.0 {
                        *least = (cost, before);
                    }
                }
            }
            costs = next.map(|(cost, _)| cost);
            from.push(next.map(|(_, before)| before));
        }
        let (Some(start), Some(end)) = (turn.first(), turn.last()) else {
            break;
        };
        for (last, cost) in (1..).zip(&costs) {
            let cost = cost + change((*end, last), (*start, first));
            if cost < best.1 {
                let mut steps = vec![last];
                for from in from.iter().rev() {
                    steps.push(from[steps[steps.len() - 1] - 1]);
                }
                steps.reverse();
                best = (steps, cost);
            }
        }
    }
    best
}

/// The turn that starts behind the longest gap, in as few pitches as it takes.
fn canonical(steps: &[usize]) -> Vec<usize> {
    let longest = steps.iter().copied().max().unwrap_or(1);
    let all = |n: &usize| steps.iter().all(|step| step.is_multiple_of(*n));
    let common = (1..=longest).rev().find(all).unwrap_or(1);
    let rotations = (1..=steps.len()).filter(|&start| steps[start - 1] == longest);
    let turns = rotations.map(|start| [&steps[start..], &steps[..start]].concat());
    let first = turns.min().unwrap_or_default();
    first.iter().map(|step| step / common).collect()
}

/// Tooth places of steps.
fn teeth(steps: &[usize]) -> Vec<bool> {
    let step = |&step: &usize| (0..step).map(|place| place == 0);
    steps.iter().flat_map(step).collect()
}
