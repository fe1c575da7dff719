//! What may be missing, going by what stands out of the residual.

use super::basis::Basis;
use super::board::{Bench, Board, Model};
use super::hypothesis::{Hypothesis, of_rhythm, whatever_shows};
use super::locate::{Among, Peak, peaks};
use crate::mechanism::Rhythm;

/// Probability that noise alone makes a rhythm stand out of a recording.
const FALSE_ALARM: f64 = 1e-3;

/// Hypotheses worth trying on what a model leaves, and the strongest rhythm's power over what noise reaches.
#[must_use]
pub fn propose(board: &Board, model: &Model) -> (Vec<Hypothesis>, f64) {
    let mut all: Vec<Hypothesis> = Vec::new();
    let mut strongest: f64 = 0.0;
    for (number, bench) in board.benches.iter().enumerate() {
        let found = peaks(bench, number, &model.left[number], FALSE_ALARM);
        strongest = strongest.max(found.first().map_or(0.0, |p| p.power / p.threshold));
        for peak in found.iter().take(4) {
            for hypothesis in of_peak(peak) {
                if !all.contains(&hypothesis) && !of_classes(bench, &hypothesis) {
                    all.push(hypothesis);
                }
            }
        }
    }
    if !board.benches.is_empty() {
        all.extend(whatever_shows(board));
    }
    (all, strongest)
}

/// Whether a rhythm of the disc comes round once a line: what all edges of a kind have has names of its own.
fn of_classes(bench: &Bench, hypothesis: &Hypothesis) -> bool {
    let seen = &bench.seen;
    match hypothesis.bases.first() {
        Some(Basis::Round { order }) if seen.classes > 1 => {
            let lines = (seen.edges / seen.classes) as f64;
            (order / lines).round() >= 1.0 && order % lines == 0.0
        }
        _ => false,
    }
}

fn of_peak(peak: &Peak) -> Vec<Hypothesis> {
    match peak.among {
        // What does not come round once is a drift or a load.
        Among::All if peak.order < 2.0 * peak.within => Vec::new(),
        Among::All => of_rhythm(Rhythm {
            order: peak.order,
            f_hz: peak.f_hz,
            within: 2.0 * peak.within,
        }),
        Among::Level | Among::LevelOf(_) => {
            let channel = match peak.among {
                Among::LevelOf(channel) => Some(channel),
                _ => None,
            };
            let basis = Basis::LevelTone {
                f_hz: peak.f_hz,
                channel,
            };
            // What hardly swings is a constant or a drift.
            if peak.order < 2.0 * peak.within {
                Vec::new()
            } else {
                vec![Hypothesis::by(basis)]
            }
        }
        Among::Channel(_) => Vec::new(),
    }
}
