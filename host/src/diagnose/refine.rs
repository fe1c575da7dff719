//! Frequencies, orders, times and places where a hypothesis explains most.

use super::basis::Basis;
use super::board::{Board, Model};
use super::hypothesis::Hypothesis;
use super::weigh::{Weighed, weigh};

/// The same hypothesis with what is searched for where it explains most.
#[must_use]
pub fn refined(board: &Board, model: &Model, first: Weighed) -> Weighed {
    let mut best = first;
    let steps = steps(board, &best.hypothesis);
    if steps.is_empty() {
        return best;
    }
    let mut size = 1.0;
    for _ in 0..5 {
        let before = best.score;
        for (change, step) in &steps {
            let at = |by: f64| {
                let changed = with(&best.hypothesis, |basis| change(basis, by * step * size));
                let columns = changed.columns(board);
                weigh(board, model, changed, columns)
            };
            let (below, above) = (at(-1.0), at(1.0));
            let score = |w: &Option<Weighed>| w.as_ref().map_or(f64::NEG_INFINITY, |w| w.score);
            let bend = score(&below) - 2.0 * best.score + score(&above);
            let there = if bend < 0.0 && bend.is_finite() {
                at((0.5 * (score(&below) - score(&above)) / bend).clamp(-2.0, 2.0))
            } else {
                None
            };
            for other in [below, above, there].into_iter().flatten() {
                if other.score > best.score {
                    best = other;
                }
            }
        }
        size *= if best.score - before > 1.0 { 0.6 } else { 0.3 };
        if size < 0.01 {
            break;
        }
    }
    best
}

/// Changes a pattern's searched number.
pub type Change = fn(&mut Basis, f64);

/// Numbers that are searched for, and first steps.
#[must_use]
pub fn steps(board: &Board, hypothesis: &Hypothesis) -> Vec<(Change, f64)> {
    let most = |value: &dyn Fn(usize) -> f64| (0..board.benches.len()).map(value).fold(0.0, f64::max);
    let turns = most(&|i| board.benches[i].seen.turns());
    let long = most(&|i| board.benches[i].seen.seconds());
    match hypothesis.bases.first() {
        _ if hypothesis.whole() => Vec::new(),
        Some(Basis::Round { .. } | Basis::TorqueOrder { .. }) => vec![(rhythm, 0.25 / turns)],
        Some(Basis::TorqueTone { .. } | Basis::LevelTone { .. }) => vec![(rhythm, 0.25 / long)],
        Some(Basis::LevelDrift { .. }) => vec![(from, 0.05 * long), (length, 0.3)],
        Some(Basis::Load { .. }) => vec![(from, 0.006 * long), (until, 0.006 * long)],
        Some(Basis::Stribeck { .. }) => vec![(length, 0.1)],
        Some(Basis::Bump { width_rad, .. }) => vec![(rhythm, 0.3 * width_rad), (length, 0.3)],
        _ => Vec::new(),
    }
}

fn rhythm(basis: &mut Basis, by: f64) {
    match basis {
        Basis::Round { order } | Basis::TorqueOrder { order } => *order += by,
        Basis::TorqueTone { f_hz } | Basis::LevelTone { f_hz, .. } => *f_hz += by,
        Basis::Bump { angle_rad, .. } => *angle_rad += by,
        _ => {}
    }
}

fn from(basis: &mut Basis, by: f64) {
    match basis {
        Basis::LevelDrift { from_s, .. } | Basis::Load { from_s, .. } => *from_s += by,
        _ => {}
    }
}

fn until(basis: &mut Basis, by: f64) {
    if let Basis::Load { until_s, .. } = basis {
        *until_s += by;
    }
}

fn length(basis: &mut Basis, by: f64) {
    match basis {
        Basis::LevelDrift { tau_s: scale, .. }
        | Basis::Stribeck { rad_s: scale }
        | Basis::Bump {
            width_rad: scale, ..
        } => *scale *= by.exp(),
        _ => {}
    }
}

/// A hypothesis with its patterns changed.
fn with(hypothesis: &Hypothesis, change: impl Fn(&mut Basis)) -> Hypothesis {
    let mut changed = hypothesis.clone();
    changed.bases.iter_mut().for_each(change);
    changed
}
