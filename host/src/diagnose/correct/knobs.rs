//! Knobs that the twins declare, and what a small change of each does.

use rayon::prelude::*;

use crate::diagnose::bench::Bench;
use crate::diagnose::effect::{Carrier, Effect, Site};
use crate::diagnose::lsq::{Basis, dot};
use crate::diagnose::model::{Board, Correction, Fit, Model};
use crate::diagnose::numbers::{self, Knob};
use crate::mechanism::Mechanism;

/// A knob with what a small change of each of its values does.
#[derive(Clone, Debug)]
pub struct Slopes {
    /// It.
    pub knob: Knob,
    /// Its values as declared.
    pub declared: Vec<f64>,
    /// Columns, rad, of each recording and each value; empty where a recording's twin does not declare it so.
    pub(super) raw: Vec<Vec<Vec<f64>>>,
}

/// Innovations, in deviations, that a step for a slope should make in all: small enough to be a slope, large enough for the numbers' digits.
const STEP: f64 = 0.5;
/// The first step and the greatest one, as parts of the number.
const PARTS: [f64; 2] = [1e-4, 0.1];

/// Size of values.
fn size(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |sum: f64, value| sum.hypot(*value))
}

impl Correction {
    /// Whether values are not so far from the declared ones, up to 30 times them, that they are another thing.
    pub(super) fn is_near(&self, values: &[f64]) -> bool {
        size(values) < 30.0 * size(&self.declared)
    }

    /// Effects of its values.
    pub fn effects(&self) -> Vec<Effect> {
        (self.first..self.first + self.declared.len())
            .map(|at| Effect::new(Site::Declared(at as u16), Carrier::Steady))
            .collect()
    }

    /// Whether it is of these slopes.
    pub(super) fn is_of(&self, slopes: &Slopes) -> bool {
        self.knob == slopes.knob && self.declared == slopes.declared
    }

    /// Whether a model has it.
    pub(super) fn is_in(&self, model: &Model) -> bool {
        let (effects, mut terms) = (self.effects(), model.terms.iter());
        terms.any(|term| effects.contains(&term.effect))
    }
}

/// Columns of a knob's values beside a bench; `now` are its present values. Empty ones where the bench's twin does not declare it so.
pub fn slopes(bench: &Bench, declares: bool, knob: &Knob, now: &[f64]) -> Option<Vec<Vec<f64>>> {
    if !declares {
        return Some(vec![Vec::new(); now.len()]);
    }
    let by = |at: usize, step: f64| -> Option<(Vec<f64>, f64)> {
        let mut values = now.to_vec();
        values[at] += step;
        let moved = bench.beside(&numbers::changed(&bench.twin, &[(knob, &values)])?)?;
        let each = bench.own.iter().zip(&moved);
        let slope: Vec<f64> = each.map(|(own, moved)| (own - moved) / step).collect();
        let white = bench.white(&slope);
        let shown = dot(&white, &white).sqrt() * step.abs();
        Some((slope, shown))
    };
    let [first, greatest] = PARTS.map(|part| part * size(now));
    let slope = |at: usize| {
        let either = |step: f64| by(at, step).or_else(|| by(at, -step));
        let (slope, shown) = either(first)?;
        let next = (first * STEP / shown.max(f64::MIN_POSITIVE)).min(greatest);
        Some(either(next).map_or(slope, |(slope, _)| slope))
    };
    (0..now.len()).map(slope).collect()
}

/// Slopes of all that the twins declare and that bears on these recordings.
pub fn all(board: &Board) -> Vec<Slopes> {
    let other = board.pattern.as_ref().is_some_and(|pattern| !pattern.known);
    slopes_of(board, |knob| !(other && knob.is_of_edges()))
}

/// Slopes of the size of a disc that the twins draw.
pub fn of_disc(board: &Board) -> Vec<Slopes> {
    slopes_of(board, Knob::draws_disc)
}

/// Slopes of some knobs.
fn slopes_of(board: &Board, has: impl Fn(&Knob) -> bool) -> Vec<Slopes> {
    // How an unknown drive holds the shaft is not to be told from friction.
    let open = |knob: &Knob| board.undriven && knob.path().mechanism() == Mechanism::Friction;
    let values = |bench: &Bench, knob: &Knob| knob.values(&numbers::tree(&bench.twin)?);
    let mut knobs: Vec<(Knob, Vec<f64>)> = Vec::new();
    for bench in &board.benches {
        for knob in numbers::knobs(&bench.twin) {
            let one = values(bench, &knob).map(|values| (knob, values));
            knobs.extend(one.filter(|one| has(&one.0) && !open(&one.0) && !knobs.contains(one)));
        }
    }
    let of_knob = |(knob, declared): (Knob, Vec<f64>)| {
        let each = board.benches.iter().map(|bench| {
            let declares = values(bench, &knob).is_some_and(|own| own == declared);
            slopes(bench, declares, &knob, &declared)
        });
        let raw = each.collect::<Option<_>>()?;
        Some(Slopes {
            knob,
            declared,
            raw,
        })
    };
    knobs.into_par_iter().filter_map(of_knob).collect()
}

impl Slopes {
    /// Columns of its values, white, all recordings in a row; nothing of a recording that has none.
    pub fn white(&self, board: &Board) -> Vec<Vec<f64>> {
        let column = |at: usize| {
            let each = self.raw.iter().zip(&board.benches);
            let full = each.map(|(raw, bench)| match raw[at].as_slice() {
                [] => vec![0.0; bench.record.len()],
                some => some.to_vec(),
            });
            board.white(&full.collect::<Vec<_>>())
        };
        (0..self.declared.len()).map(column).collect()
    }
}

/// A candidate for a correction.
#[derive(Clone, Debug)]
pub struct Candidate<'a> {
    /// What is corrected.
    pub slopes: &'a Slopes,
    /// By how much the sum of squares falls, going by the slopes.
    pub gain: f64,
}

/// All knobs that are not yet fitted, those first that explain most.
pub fn candidates<'a>(
    board: &Board,
    slopes: &'a [Slopes],
    fit: &Fit,
    basis: &Basis,
) -> Vec<Candidate<'a>> {
    let fitted = board.corrections.iter().filter(|own| own.is_in(&fit.model));
    let fitted: Vec<&Correction> = fitted.collect();
    let mut all: Vec<Candidate<'a>> = slopes
        .par_iter()
        .filter(|slopes| !fitted.iter().any(|own| own.is_of(slopes)))
        .map(|slopes| Candidate {
            slopes,
            gain: basis.gain(&slopes.white(board), &fit.left),
        })
        .collect();
    all.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    all
}
