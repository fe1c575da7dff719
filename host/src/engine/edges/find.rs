//! A wheel found from its recording: pulses a turn, and where teeth are missing.
//!
//! The pattern of a turn repeats, whatever it is made of. So pulses a turn are the shift at which log intervals come again, but for slow
//! changes of speed; then each turn of the recording votes for the whole numbers of pitches that make its intervals smoothest.

use std::collections::HashMap;

use super::median;
use super::wheel::{both, roughness};
use crate::recording::Row;

/// Most pulses a turn that are tried.
const MOST_PULSES: usize = 400;
/// Pulses looked at.
const MOST_LOOKED: usize = 20_000;
/// Most pitches of one step.
const MOST_PITCHES: usize = 6;
/// Turns that vote.
const VOTES: usize = 60;

/// A wheel.
#[derive(Clone, Debug, PartialEq)]
pub struct WheelFound {
    /// For each tooth place whether a tooth is there; tooth 0 is the first behind the longest gap.
    pub present: Vec<bool>,
    /// How sure it is, 0 to 1: the share of turns that look like it.
    pub confidence: f64,
    /// Other wheels that some turns look like, with their shares, best first.
    pub alternatives: Vec<(Vec<bool>, f64)>,
}

/// Finds the wheel that a recording shows: of both edges, or of pulses whose levels say nothing. None where no pattern repeats.
pub fn find_wheel(rows: &[Row], both_edges: bool) -> Option<WheelFound> {
    let ticks = if both_edges {
        let [falls, rises] = both(rows);
        if roughness(&rises) < roughness(&falls) {
            rises
        } else {
            falls
        }
    } else {
        rows.iter().map(|row| row.ticks).collect()
    };
    let skipped = ticks.len().saturating_sub(MOST_LOOKED) / 2;
    let logs: Vec<f64> = ticks[skipped..]
        .windows(2)
        .take(MOST_LOOKED)
        .map(|pair| ((pair[1] - pair[0]) as f64).max(0.5).ln())
        .collect();
    let costs = periods(&logs);
    for (n, c) in costs.iter().enumerate().take(80) {
        eprintln!("{} {:.4}", n + 1, c);
    }
    None
}

/// For each number of pulses a turn, how little log intervals a turn apart follow each other.
pub fn periods(logs: &[f64]) -> Vec<f64> {
    let most = MOST_PULSES.min(logs.len() / 3);
    let changes = |shift: usize| {
        let far = logs[shift..].iter().zip(logs).map(|(a, b)| a - b);
        let far: Vec<f64> = far.collect();
        far.windows(2).map(|d| (d[1] - d[0]).abs()).collect::<Vec<f64>>()
    };
    let spread = (1..=most)
        .filter_map(|shift| median(changes(shift)))
        .fold(f64::INFINITY, f64::min)
        .max(1e-6);
    (1..=most)
        .map(|shift| {
            let all = changes(shift);
            let cost: f64 = all.iter().map(|r| (1.0 + (r / spread).powi(2)).ln()).sum();
            cost / all.len() as f64
        })
        .collect()
}
