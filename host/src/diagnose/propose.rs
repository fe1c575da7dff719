//! What may be missing, going by what stands out of the residual.

use super::basis::Basis;
use super::board::{Board, Model};
use super::hypothesis::{Hypothesis, of_classes, of_rhythm};
use super::locate::{Among, Peak, peaks};
use super::shaft::ShaftLaw;
use crate::mechanism::Mechanism;

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
                if !all.contains(&hypothesis) {
                    all.push(hypothesis);
                }
            }
        }
    }
    if let Some(first) = board.benches.first() {
        all.extend(of_classes(first.seen.classes));
        all.extend(slow(board));
    }
    (all, strongest)
}

fn of_peak(peak: &Peak) -> Vec<Hypothesis> {
    match peak.among {
        // What does not come round once is a drift or a load.
        Among::All if peak.order < 2.0 * peak.within => Vec::new(),
        Among::All => of_rhythm(peak.order, peak.f_hz, 2.0 * peak.within),
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
                vec![Hypothesis::of(Mechanism::ThresholdRipple, basis)]
            }
        }
        Among::Channel(_) => Vec::new(),
    }
}

/// What happens slowly, once or by speed.
fn slow(board: &Board) -> Vec<Hypothesis> {
    let mut all = Vec::new();
    let driven = |bench: &super::board::Bench| {
        bench
            .law
            .driven(bench.seen.times_s.first().copied().unwrap_or(0.0))
    };
    if board.benches.iter().any(driven) {
        all.push(Hypothesis::of(Mechanism::SpeedDrift, Basis::Drift));
    }
    let off = |law: &ShaftLaw| !law.driven(f64::MAX);
    if board.benches.iter().any(|bench| off(&bench.law)) {
        let top = board.benches[0].seen.speed_range();
        let top = top[1].abs().max(top[0].abs());
        all.extend([
            Hypothesis::of(Mechanism::Friction, Basis::Coulomb),
            Hypothesis::of(Mechanism::Friction, Basis::Viscous),
            Hypothesis::of(Mechanism::Friction, Basis::Drag),
        ]);
        all.extend([0.3, 0.4, 0.5, 0.6, 0.7, 0.8].map(|share| {
            Hypothesis::of(Mechanism::Friction, Basis::Stribeck { rad_s: share * top })
        }));
    }
    let reverses = |bench: &super::board::Bench| {
        let [low, high] = bench.seen.speed_range();
        low < 0.0 && high > 0.0
    };
    if board.benches.iter().any(reverses) {
        all.push(Hypothesis::of(Mechanism::Hysteresis, Basis::Direction));
    }
    if board.benches[0].seen.classes > 1 {
        for bench in &board.benches {
            let (from, long) = (
                bench.seen.times_s.first().copied().unwrap_or(0.0),
                bench.seen.seconds(),
            );
            for start in 0..8 {
                for tau in [0.08, 0.2, 0.5] {
                    all.push(Hypothesis::of(
                        Mechanism::ThresholdDrift,
                        Basis::LevelDrift {
                            from_s: from + f64::from(start) / 12.0 * long,
                            tau_s: tau * long,
                        },
                    ));
                }
            }
        }
    }
    all
}
