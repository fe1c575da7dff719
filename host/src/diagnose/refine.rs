//! Frequencies, orders, times and places where a hypothesis explains most.

use rayon::prelude::*;

use super::basis::Basis;
use super::board::{Board, Column, Model};
use super::hypothesis::Hypothesis;
use super::weigh::{Weighed, weigh};

/// Widest place of the disc that is out of line, rad (sigma).
pub const WIDEST_RAD: f64 = std::f64::consts::TAU / 8.0;

/// The same hypothesis with what is searched for where it explains most: Gauss and Newton's steps, the slopes by differences.
#[must_use]
pub fn refined(board: &Board, model: &Model, first: Weighed) -> Weighed {
    let mut best = first;
    let steps = steps(board, &best.hypothesis);
    if steps.is_empty() {
        return best;
    }
    for _ in 0..5 {
        let Some(moves) = moves(board, model, &best, &steps) else {
            break;
        };
        let mut better = None;
        for share in [1.0, 0.3] {
            let mut changed = best.hypothesis.clone();
            for ((change, step), by) in steps.iter().zip(&moves) {
                let by = (by * share).clamp(-2.5 * step, 2.5 * step);
                changed.bases.iter_mut().for_each(|basis| change(basis, by));
            }
            let columns = changed.columns(board);
            better = weigh(board, model, changed, columns).filter(|w| w.score > best.score);
            if better.is_some() {
                break;
            }
        }
        let Some(better) = better else {
            break;
        };
        let gained = better.score - best.score;
        best = better;
        if gained < 0.3 {
            break;
        }
    }
    best
}

/// How far each searched number should move, by the linear fit of sizes and slopes.
fn moves(board: &Board, model: &Model, at: &Weighed, steps: &[(Change, f64)]) -> Option<Vec<f64>> {
    let slopes = slopes(board, &at.hypothesis, at.gain.sizes.as_slice(), steps);
    if slopes.len() != steps.len() {
        return None;
    }
    let count = at.columns.len();
    let all: Vec<Column> = at.columns.iter().cloned().chain(slopes).collect();
    let gain = board.gain(model, &all)?;
    Some(gain.sizes.as_slice()[count..].to_vec())
}

/// How the angles change with each searched number, white.
#[must_use]
pub fn slopes(
    board: &Board,
    hypothesis: &Hypothesis,
    sizes: &[f64],
    steps: &[(Change, f64)],
) -> Vec<Column> {
    let signal = |hypothesis: &Hypothesis| -> Option<Vec<Vec<f64>>> {
        let columns = hypothesis.columns(board);
        if columns.len() != sizes.len() {
            return None;
        }
        let parts = (0..board.benches.len()).map(|bench| {
            let mut sum = vec![0.0; board.benches[bench].seen.len()];
            for (column, size) in columns.iter().zip(sizes) {
                if let Some(part) = &column.0[bench] {
                    for (sum, value) in sum.iter_mut().zip(part) {
                        *sum += size * value;
                    }
                }
            }
            sum
        });
        Some(parts.collect())
    };
    let each = steps.par_iter().filter_map(|(change, step)| {
        let small = 0.05 * step;
        let moved = |by: f64| {
            let mut moved = hypothesis.clone();
            moved.bases.iter_mut().for_each(|basis| change(basis, by));
            signal(&moved)
        };
        let (below, above) = rayon::join(|| moved(-small), || moved(small));
        let (below, mut above) = (below?, above?);
        for (above, below) in above.iter_mut().zip(&below) {
            for (a, b) in above.iter_mut().zip(below) {
                *a = (*a - b) / (2.0 * small);
            }
        }
        Some(Column::of(above.into_iter().map(Some)))
    });
    each.collect()
}

/// Changes a pattern's searched number.
pub type Change = fn(&mut Basis, f64);

/// Numbers that are searched for, and first steps.
#[must_use]
pub fn steps(board: &Board, hypothesis: &Hypothesis) -> Vec<(Change, f64)> {
    let most =
        |value: &dyn Fn(usize) -> f64| (0..board.benches.len()).map(value).fold(0.0, f64::max);
    let turns = most(&|i| board.benches[i].seen.turns());
    let long = most(&|i| board.benches[i].seen.seconds());
    match hypothesis.bases.first() {
        _ if hypothesis.whole() => Vec::new(),
        Some(Basis::Round { .. } | Basis::Lagged { .. } | Basis::TorqueOrder { .. }) => {
            vec![(rhythm, 0.25 / turns)]
        }
        Some(Basis::TorqueTone { .. } | Basis::LevelTone { .. }) => vec![(rhythm, 0.25 / long)],
        Some(Basis::LevelDrift { .. }) => vec![(from, 0.05 * long), (length, 0.3)],
        Some(Basis::Load { .. }) => vec![(from, 0.006 * long), (until, 0.006 * long)],
        Some(Basis::Stribeck { .. }) => vec![(length, 0.1)],
        Some(Basis::Warming { .. }) => vec![(length, 0.3)],
        Some(Basis::Bump { width_rad, .. }) => vec![(rhythm, 0.3 * width_rad), (length, 0.3)],
        _ => Vec::new(),
    }
}

fn rhythm(basis: &mut Basis, by: f64) {
    match basis {
        Basis::Round { order } | Basis::Lagged { order } | Basis::TorqueOrder { order } => {
            *order += by;
        }
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
        | Basis::Warming { tau_s: scale }
        | Basis::Stribeck { rad_s: scale } => {
            *scale *= by.exp();
        }
        // What is wider is no place any more.
        Basis::Bump { width_rad, .. } => *width_rad = (*width_rad * by.exp()).min(WIDEST_RAD),
        _ => {}
    }
}
