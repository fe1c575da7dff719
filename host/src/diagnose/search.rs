//! Looks for what is missing, one mechanism after another, until what is left is noise.

use std::f64::consts::TAU;

use super::basis::Basis;
use super::board::{Board, Column, Model};
use super::hypothesis::Hypothesis;
use super::propose::propose;
use crate::mechanism::Mechanism;

/// Mechanisms at the most.
const MOST: usize = 12;

/// What a finding must explain beyond Schwarz's cost of its numbers, so that noise seldom gives one: twice the logarithm of how many
/// independent places were searched, over the probability of a false one.
const BEYOND: f64 = 40.0;

/// A mechanism that was found.
#[derive(Clone, Debug)]
pub struct Found {
    /// It.
    pub hypothesis: Hypothesis,
    /// Its columns.
    pub columns: Vec<Column>,
    /// Fall of the sum of squares, less what its numbers cost.
    pub score: f64,
    /// Others in its place, with theirs, best first.
    pub rivals: Vec<(Hypothesis, f64)>,
}

/// What a search came to.
pub struct Searched {
    /// Mechanisms, in the order in which they were found.
    pub found: Vec<Found>,
    /// All of them fitted together.
    pub model: Model,
    /// Strongest rhythm left, over what noise reaches.
    pub left: f64,
}

/// Searches.
#[must_use]
pub fn search(board: &mut Board) -> Searched {
    let mut found: Vec<Found> = Vec::new();
    let empty = Model::none(board);
    let mut model = empty;
    let mut left = 0.0;
    while found.len() < MOST {
        let (proposed, strongest) = propose(board, &model);
        left = strongest;
        let Some(best) = best(board, &model, proposed) else {
            break;
        };
        found.push(best);
        let columns: Vec<Column> = found.iter().flat_map(|f| f.columns.clone()).collect();
        let Some(fitted) = board.fit(columns) else {
            found.pop();
            break;
        };
        model = fitted;
    }
    Searched { found, model, left }
}

impl Model {
    /// Nothing fitted.
    #[must_use]
    pub fn none(board: &Board) -> Self {
        Self {
            columns: Vec::new(),
            sizes: nalgebra::DVector::zeros(0),
            covariance: nalgebra::DMatrix::zeros(0, 0),
            factor: None,
            left: board.benches.iter().map(|bench| bench.white.clone()).collect(),
        }
    }
}

/// Schwarz's cost of a hypothesis.
#[must_use]
pub fn cost(board: &Board, hypothesis: &Hypothesis, columns: usize) -> f64 {
    (columns + hypothesis.searched()) as f64 * (board.edges() as f64).ln()
}

/// The best hypothesis on top of a model.
fn best(board: &Board, model: &Model, proposed: Vec<Hypothesis>) -> Option<Found> {
    let mut tried: Vec<(Hypothesis, Vec<Column>, f64)> = Vec::new();
    for hypothesis in proposed {
        let columns = hypothesis.columns(board);
        let Some(gain) = board.gain(model, &columns) else {
            continue;
        };
        let score = gain.squares - cost(board, &hypothesis, columns.len());
        tried.push((hypothesis, columns, score));
    }
    tried.sort_by(|a, b| b.2.total_cmp(&a.2));
    let top = tried.first()?.2;
    // Only what may win is worth a closer look: a frequency a little off costs a good part.
    let mut closer: Vec<(Hypothesis, Vec<Column>, f64)> = Vec::new();
    for (hypothesis, columns, score) in tried {
        if score < 0.3 * top {
            continue;
        }
        let (hypothesis, columns, score) = refined(board, model, hypothesis, columns, score);
        if !closer.iter().any(|other| other.0 == hypothesis) {
            closer.push((hypothesis, columns, score));
        }
    }
    closer.sort_by(|a, b| b.2.total_cmp(&a.2));
    let mut closer = closer.into_iter();
    let (hypothesis, columns, score) = closer.next()?;
    (score > BEYOND).then(|| Found {
        hypothesis,
        columns,
        score,
        rivals: closer.map(|(h, _, score)| (h, score)).collect(),
    })
}

/// The same with what is searched for where it explains most.
fn refined(
    board: &Board,
    model: &Model,
    hypothesis: Hypothesis,
    columns: Vec<Column>,
    score: f64,
) -> (Hypothesis, Vec<Column>, f64) {
    let mut best = (hypothesis, columns, score);
    let steps = steps(board, &best.0);
    if steps.is_empty() {
        return best;
    }
    let mut size = 1.0;
    for _ in 0..5 {
        for &(ref change, step) in &steps {
            let at = |by: f64| change(&best.0, by * step * size);
            let weigh = |hypothesis: Hypothesis| {
                let columns = hypothesis.columns(board);
                let gain = board.gain(model, &columns).map_or(f64::NEG_INFINITY, |g| g.squares);
                let score = gain - cost(board, &hypothesis, columns.len());
                (hypothesis, columns, score)
            };
            let (before, after) = (weigh(at(-1.0)), weigh(at(1.0)));
            let bend = before.2 - 2.0 * best.2 + after.2;
            let top = if bend < 0.0 {
                (0.5 * (before.2 - after.2) / bend).clamp(-2.0, 2.0)
            } else {
                0.0
            };
            let there = weigh(at(top));
            for other in [before, after, there] {
                if other.2 > best.2 {
                    best = other;
                }
            }
        }
        size *= 0.4;
    }
    best
}

type Change = Box<dyn Fn(&Hypothesis, f64) -> Hypothesis>;

/// Numbers that are searched for, and first steps.
fn steps(board: &Board, hypothesis: &Hypothesis) -> Vec<(Change, f64)> {
    let turns = board.benches.iter().map(|b| b.seen.turns()).fold(1.0, f64::max);
    let long = board.benches.iter().map(|b| b.seen.seconds()).fold(0.0, f64::max);
    match hypothesis.bases.first() {
        _ if hypothesis.whole() => Vec::new(),
        Some(Basis::Round { .. } | Basis::TorqueOrder { .. }) => {
            let change: Change = Box::new(|h, by| h.at_rhythm(h.rhythm().unwrap_or(0.0) + by));
            vec![(change, 0.25 / turns)]
        }
        Some(Basis::TorqueTone { .. } | Basis::LevelTone { .. }) => {
            let change: Change = Box::new(|h, by| h.at_rhythm(h.rhythm().unwrap_or(0.0) + by));
            vec![(change, 0.25 / long)]
        }
        Some(Basis::LevelDrift { tau_s, .. }) => {
            let from: Change = Box::new(|h, by| with(h, |basis| {
                if let Basis::LevelDrift { from_s, .. } = basis {
                    *from_s = (*from_s + by).max(0.0);
                }
            }));
            let tau: Change = Box::new(|h, by| with(h, |basis| {
                if let Basis::LevelDrift { tau_s, .. } = basis {
                    *tau_s = (*tau_s * (1.0 + by)).max(1e-9);
                }
            }));
            vec![(from, 0.04 * long), (tau, 0.3)].into_iter().map(|(c, s)| (c, s.min(0.5 * tau_s.max(s)))).collect()
        }
        Some(Basis::Load { .. }) => {
            let from: Change = Box::new(|h, by| with(h, |basis| {
                if let Basis::Load { from_s, .. } = basis {
                    *from_s = (*from_s + by).max(0.0);
                }
            }));
            let until: Change = Box::new(|h, by| with(h, |basis| {
                if let Basis::Load { until_s, .. } = basis {
                    *until_s += by;
                }
            }));
            vec![(from, 0.01 * long), (until, 0.01 * long)]
        }
        Some(Basis::Stribeck { .. }) => {
            let speed: Change = Box::new(|h, by| with(h, |basis| {
                if let Basis::Stribeck { rad_s } = basis {
                    *rad_s *= 1.0 + by;
                }
            }));
            vec![(speed, 0.1)]
        }
        _ => Vec::new(),
    }
}

fn with(hypothesis: &Hypothesis, change: impl Fn(&mut Basis)) -> Hypothesis {
    let mut changed = hypothesis.clone();
    changed.bases.iter_mut().for_each(change);
    changed
}

/// Frequency or order of a rhythm as cycles a turn at a recording's mean speed.
#[must_use]
pub fn cycles_a_turn(board: &Board, hypothesis: &Hypothesis) -> Option<f64> {
    let rhythm = hypothesis.rhythm()?;
    match hypothesis.bases.first()? {
        Basis::TorqueTone { .. } | Basis::LevelTone { .. } => {
            Some(rhythm * TAU / board.benches.first()?.seen.mean_speed())
        }
        _ => Some(rhythm),
    }
}

/// Whether a mechanism is of the disc or head: the same at every turn and speed.
#[must_use]
pub const fn geometry(mechanism: Mechanism) -> bool {
    matches!(
        mechanism,
        Mechanism::LineError
            | Mechanism::WidthError
            | Mechanism::QuadratureError
            | Mechanism::Eccentricity
            | Mechanism::DiscTilt
            | Mechanism::LocalDefect
    )
}
