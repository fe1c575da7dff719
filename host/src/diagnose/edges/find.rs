//! A wheel found from its recording: pulses a turn, and where teeth are missing.
//!
//! The pattern of a turn repeats, whatever it is made of: gaps, teeth out of place, torques locked to the turn. So the pulses a turn are
//! the shift at which log intervals come again but for slow changes of speed. Then turns here and there in the recording vote for the
//! whole numbers of pitches that make their speed smoothest, and the wheels that got most votes are tried on all of it.

use super::wheel::both;
use super::{Sensor, median, place};
use crate::recording::Row;

/// Most pulses a turn that are tried: wheels have fewer teeth, and time goes with the square.
const MOST_PULSES: usize = 400;
/// A pattern repeats where its changes cost this part of what they do at other shifts, and a shorter one is taken where it
/// is nearer to the best shift than to the others by this part: a shift of two turns fits an engine of four strokes a little better.
const REPEATS: f64 = 0.6;
const SHORTER: f64 = 0.25;
/// Most pitches of one step: longer gaps are rare, and each more has others look like it.
const MOST_PITCHES: usize = 6;
/// Share of votes that a wheel needs to be tried.
const TRIED: f64 = 0.15;
/// Log speeds a usual step apart differ by about this, and the price of a step that is not the usual one.
const SWING: f64 = 0.15;
const UNLIKE: f64 = 6.0;

/// A wheel.
#[derive(Clone, Debug, PartialEq)]
pub struct WheelFound {
    /// For each tooth place whether a tooth is there; tooth 0 is the first behind the longest gap.
    pub present: Vec<bool>,
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
    let votes = kinds.iter().flat_map(|ticks| votes(&log_intervals(ticks)));
    let mut votes: Vec<_> = votes.filter(|(_, share)| *share >= TRIED).collect();
    // The field beside a gap bends edges of one kind so far that one gap looks like two.
    let size = |steps: &[usize]| (steps.len(), steps.iter().sum::<usize>());
    let gaps = |steps: &[usize]| steps.iter().filter(|step| **step > 1).count();
    votes.sort_by(|(a, share), (b, other)| {
        let simpler = (size(a), gaps(a)).cmp(&(size(b), gaps(b)));
        simpler.then(other.total_cmp(share))
    });
    votes.dedup_by_key(|(steps, _)| size(steps));
    let each = votes.into_iter().filter_map(|(steps, share)| {
        let present = teeth(&steps);
        let sensor = Sensor::Wheel {
            present: present.clone(),
            both_edges,
        };
        let edges = place(&sensor, 1, rows).ok()?;
        Some((edges.fit, (present, share)))
    });
    let mut tried: Vec<_> = each.collect();
    tried.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    let mut tried = tried.into_iter().map(|(_, wheel)| wheel);
    let (present, confidence) = tried.next()?;
    Some(WheelFound {
        present: once(&present).to_vec(),
        confidence,
        alternatives: tried.collect(),
    })
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

/// What turns look like: steps of a turn, in pitches, and the share of turns that look like it.
fn votes(logs: &[f64]) -> Vec<(Vec<usize>, f64)> {
    let Some(pulses) = period(logs) else {
        return Vec::new();
    };
    let turns = logs
        .chunks_exact(pulses)
        .map(|turn| canonical(&steps(turn)));
    let mut turns: Vec<Vec<usize>> = turns.collect();
    turns.sort_unstable();
    let alike = turns.chunk_by(PartialEq::eq);
    let share = |alike: &[_]| alike.len() as f64 / turns.len() as f64;
    alike
        .map(|alike| (alike[0].clone(), share(alike)))
        .collect()
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

/// The whole numbers of pitches that make a turn's speed smoothest.
fn steps(turn: &[f64]) -> Vec<usize> {
    let (one, two) = (steps_about(turn, 1), steps_about(turn, 2));
    // Usual steps are seldom two pitches, as where a tooth is put between two others.
    let (steps, _) = if two.1 + 2.0 * UNLIKE < one.1 {
        two
    } else {
        one
    };
    steps
}

/// As [`steps`], where most are of `usual` pitches, and what they cost.
fn steps_about(turn: &[f64], usual: usize) -> (Vec<usize>, f64) {
    let change = |(from, before): (f64, usize), (to, after): (f64, usize)| {
        let speeds = [from - (before as f64).ln(), to - (after as f64).ln()];
        let unlike = if after == usual { 0.0 } else { UNLIKE };
        let apart = 0.5 * (before + after) as f64 / usual as f64;
        (speeds[1] - speeds[0]).powi(2) / (2.0 * SWING * SWING * apart) + unlike
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

/// A turn whose gaps come again and again within it, once: an engine of four strokes makes two turns of a wheel look like one.
fn once(present: &[bool]) -> &[bool] {
    let has_gap = |turn: &&[bool]| turn.contains(&false);
    let again = |turn: &&[bool]| present.chunks(turn.len()).all(|part| part == *turn);
    let whole = (1..=present.len()).filter(|places| present.len().is_multiple_of(*places));
    let mut turns = whole.map(|places| &present[..places]).filter(has_gap);
    turns.find(again).unwrap_or(present)
}

/// Tooth places of steps.
fn teeth(steps: &[usize]) -> Vec<bool> {
    let step = |&step: &usize| (0..step).map(|place| place == 0);
    steps.iter().flat_map(step).collect()
}
