//! Frequencies that the edges of one recording can't tell apart.
//!
//! At an even pace edges come `rate` times a second, and what swings with f looks like what swings with f + k rate or k rate - f. At
//! another speed it does not: with several recordings, the one that all of them show is the true one.

use rayon::prelude::*;

use super::basis::Basis;
use super::bench::Bench;
use super::board::{Board, Model};
use super::refine::refined;
use super::rivals::ALIKE;
use super::weigh::{Weighed, weigh};

/// Rates up to which frequencies are looked for.
const RATES: i32 = 2;

/// The same tone, or that of its aliases which explains surely more.
#[must_use]
pub fn unaliased(board: &Board, model: &Model, found: Weighed) -> Weighed {
    let (f_hz, channel) = match found.hypothesis.bases.first() {
        Some(Basis::LevelTone { f_hz, channel }) => (*f_hz, *channel),
        Some(Basis::TorqueTone { f_hz }) => (*f_hz, None),
        _ => return found,
    };
    if board.benches.len() < 2 {
        return found;
    }
    let rates = board.benches.iter().map(|bench| rate(bench, channel));
    let others: Vec<f64> = rates.flat_map(|rate| aliases(f_hz, rate)).collect();
    let each = others.into_par_iter().filter_map(|f_hz| {
        let other = found.hypothesis.at_rhythm(f_hz);
        let columns = other.columns(board);
        weigh(board, model, other, columns)
    });
    let best = each.max_by(|a, b| a.score.total_cmp(&b.score));
    match best {
        Some(best) if best.score > found.score + ALIKE => refined(board, model, best),
        _ => found,
    }
}

/// Edges a second of one channel, or of all.
fn rate(bench: &Bench, channel: Option<usize>) -> f64 {
    let seen = &bench.seen;
    let all = seen.len().saturating_sub(1) as f64 / seen.seconds();
    match channel {
        // Each channel rises and falls once a line.
        Some(_) => 2.0 * all / seen.classes as f64,
        None => all,
    }
}

/// Other frequencies that look like one at a rate.
fn aliases(f_hz: f64, rate: f64) -> impl Iterator<Item = f64> {
    let multiples = (1..=RATES).map(move |k| f64::from(k) * rate);
    multiples.flat_map(move |all| [all + f_hz, (all - f_hz).abs()])
}

#[cfg(test)]
mod tests {
    use super::aliases;

    #[test]
    fn a_tone_and_its_aliases_give_the_same_samples() {
        let (f_hz, rate) = (12.86, 87.14);
        for other in aliases(f_hz, rate) {
            for sample in 0..50 {
                let at =
                    |f_hz: f64| (std::f64::consts::TAU * f_hz * f64::from(sample) / rate).cos();
                assert!((at(other) - at(f_hz)).abs() < 1e-9, "{other}");
            }
        }
    }
}
