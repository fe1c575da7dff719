//! What looks like noisier stamps and is not: few edges that are far off among many that are not.
//!
//! Normal stamps have no fourth cumulant, exponential waits one of six squares of their variance, and whatever else adds to either
//! brings that down. Edges that are off by far more now and then have no such noise, but something that comes and goes.

use super::super::board::Board;
use super::levels::Levels;
use super::{NoiseFinding, NoiseParameter};
use crate::mechanism::Mechanism;

/// Fourth cumulant over the variance's square from which on neither is in it.
const HEAVY: f64 = 9.0;
/// Deviations from which on an edge is far off.
const FAR: f64 = 6.0;
/// Times of edges that are named at the most.
const NAMED: usize = 20;

/// The same as few edges that are far off, where it is that.
#[must_use]
pub fn instead(board: &Board, levels: &Levels, found: &NoiseFinding) -> Option<NoiseFinding> {
    let mut times_s = Vec::new();
    let [mut count, mut square, mut fourth, mut far] = [0.0; 4];
    for (bench, white) in board.benches.iter().zip(&levels.white) {
        for (time_s, white) in bench.seen.times_s.iter().zip(white) {
            let own = white * white;
            count += 1.0;
            square += own;
            fourth += own * own;
            if own > FAR * FAR {
                times_s.push(*time_s);
                far += own;
            }
        }
    }
    let mean = square / count;
    let heavy = fourth / count / (mean * mean) - 3.0 > HEAVY;
    let share = times_s.len() as f64 / count;
    let wider = (far / times_s.len() as f64 * (1.0 - share) / (mean - far / count)).sqrt();
    let edges = times_s.len();
    times_s.truncate(NAMED);
    heavy.then(|| NoiseFinding {
        mechanism: Mechanism::Unknown,
        parameters: [("share", share), ("times_as_wide", wider)]
            .map(|(name, value)| NoiseParameter {
                name,
                value,
                standard_error: value / (edges as f64).sqrt(),
            })
            .to_vec(),
        text: format!(
            "{edges} edges, one in {:.0}, are off by {wider:.0} times as much as the others: no noise of the stamps",
            share.recip()
        ),
        times_s,
        edge_classes: Vec::new(),
        runner_up: Some((found.mechanism, found.delta_bic)),
        ..found.clone()
    })
}
