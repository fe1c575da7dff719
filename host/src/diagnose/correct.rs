//! Numbers that the twins declare, fitted: each is a column like that of an effect, the slope of the innovations over it.
//!
//! A column is the difference that a small change of the number makes to all that the twin says, filter included. The twins are then
//! taken with the fitted numbers and the columns worked out anew, until nothing changes (Gauss and Newton on prediction errors: L. Ljung,
//! System Identification, 2nd ed., section 10.2).

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::bench::Bench;
use super::diagnosis::Parameter;
use super::diagnosis::Sized;
use super::effect::{Carrier, Effect, Site};
use super::lsq::{self, Basis, dot};
use super::model::{Board, Fit, Model};
use super::name::{NINETY_FIVE, Number};
use super::numbers::{self, Knob};
use crate::mechanism::Mechanism;
use crate::report::si;
use crate::sim;
use crate::twin::Twin;

/// A declared knob that is fitted.
#[derive(Clone, Debug)]
pub struct Correction {
    /// It.
    pub knob: Knob,
    /// Its values as declared.
    pub declared: Vec<f64>,
    /// Its values in the twins that the board goes by.
    pub now: Vec<f64>,
    /// Index of its first value among [`Site::Declared`].
    first: usize,
}

/// A knob with what a small change of each of its values does.
#[derive(Clone, Debug)]
pub struct Slopes {
    /// It.
    pub knob: Knob,
    /// Its values as declared.
    pub declared: Vec<f64>,
    /// Columns, rad, of each value and each recording; empty where a recording's twin does not declare it so.
    raw: Vec<Vec<Vec<f64>>>,
}

/// Rounds of re-linearisation at the most, and how often a step that does not help is shortened.
const ROUNDS: usize = 8;
const SHORTENED: usize = 4;
const SHORTER: f64 = 0.3;
/// Part of its standard error by which a number may still move.
const SETTLED: f64 = 0.05;
/// Innovations, in deviations, that a step for a slope should make in all: small enough to be a slope, large enough for the numbers' digits.
const STEP: f64 = 0.5;
/// Least and greatest of them that are taken as they come.
const STEPS: [f64; 2] = [0.05, 3.0];
/// The first step and the greatest one, as parts of the number.
const FIRST: f64 = 1e-4;
const GREATEST: f64 = 0.1;
/// Times a declared number that a measured one may be.
const FARTHEST: f64 = 30.0;
/// Part of a column's square that is its own, up to which it is the same as others.
const SAME: f64 = 1e-2;

impl Correction {
    /// Whether values are not so far from the declared ones that they are another thing.
    fn is_near(&self, values: &[f64]) -> bool {
        let size = |values: &[f64]| values.iter().fold(0.0, |sum: f64, value| sum.hypot(*value));
        size(values) < FARTHEST * size(&self.declared)
    }

    /// Effects of its values.
    #[must_use]
    pub fn effects(&self) -> Vec<Effect> {
        (self.first..self.first + self.declared.len())
            .map(|at| Effect::new(Site::Declared(at as u16), Carrier::Steady))
            .collect()
    }
}

/// Whether a twin declares a knob with these values.
fn declares(twin: &Twin, knob: &Knob, values: &[f64]) -> bool {
    numbers::tree(twin)
        .and_then(|tree| knob.values(&tree))
        .is_some_and(|own| own == values)
}

/// Columns of a knob's values beside a bench; `now` are its present values.
fn slopes(bench: &Bench, knob: &Knob, now: &[f64]) -> Option<Vec<Vec<f64>>> {
    let size = now.iter().fold(0.0, |sum: f64, value| sum.hypot(*value));
    let by = |at: usize, step: f64| -> Option<(Vec<f64>, f64)> {
        let mut values = now.to_vec();
        values[at] += step;
        let moved = bench.beside(&numbers::changed(&bench.twin, &[(knob, &values)])?)?;
        let slope: Vec<f64> = bench
            .own
            .iter()
            .zip(&moved)
            .map(|(own, moved)| (own - moved) / step)
            .collect();
        let white = bench.white(&slope);
        let shown = dot(&white, &white).sqrt() * step.abs();
        Some((slope, shown))
    };
    (0..now.len())
        .map(|at| {
            let first = FIRST * size;
            let either = |step: f64| {
                by(at, step)
                    .map(|made| (made, step))
                    .or_else(|| by(at, -step).map(|made| (made, -step)))
            };
            let ((slope, shown), step) = either(first)?;
            if (STEPS[0]..STEPS[1]).contains(&shown) {
                return Some(slope);
            }
            let next = (step.abs() * STEP / shown.max(f64::MIN_POSITIVE)).min(GREATEST * size);
            Some(either(next).map_or(slope, |((slope, _), _)| slope))
        })
        .collect()
}

/// Slopes of all that the twins declare.
#[must_use]
pub fn all(board: &Board) -> Vec<Slopes> {
    let mut knobs: Vec<(Knob, Vec<f64>)> = Vec::new();
    for bench in &board.benches {
        let Some(tree) = numbers::tree(&bench.twin) else {
            continue;
        };
        // How an unknown drive holds the shaft is not to be told from friction.
        let open = |knob: &Knob| board.undriven && knob.path().mechanism() == Mechanism::Friction;
        for knob in numbers::knobs(&bench.twin) {
            if open(&knob) {
                continue;
            }
            if let Some(values) = knob.values(&tree) {
                let one = (knob, values);
                if !knobs.contains(&one) {
                    knobs.push(one);
                }
            }
        }
    }
    knobs
        .into_par_iter()
        .filter_map(|(knob, declared)| {
            let mut raw = vec![Vec::new(); declared.len()];
            for bench in &board.benches {
                let here = if declares(&bench.twin, &knob, &declared) {
                    slopes(bench, &knob, &declared)?
                } else {
                    vec![Vec::new(); declared.len()]
                };
                raw.iter_mut()
                    .zip(here)
                    .for_each(|(raw, here)| raw.push(here));
            }
            Some(Slopes {
                knob,
                declared,
                raw,
            })
        })
        .collect()
}

impl Slopes {
    /// Columns of its values, white, all recordings in a row.
    #[must_use]
    pub fn white(&self, board: &Board) -> Vec<Vec<f64>> {
        self.raw
            .iter()
            .map(|each| board.white_or_none(each))
            .collect()
    }
}

impl Board {
    /// Angles of all recordings, white, in a row; none of a recording that has none.
    fn white_or_none(&self, each: &[Vec<f64>]) -> Vec<f64> {
        let full: Vec<Vec<f64>> = each
            .iter()
            .zip(&self.benches)
            .map(|(some, bench)| {
                if some.is_empty() {
                    vec![0.0; bench.record.len()]
                } else {
                    some.clone()
                }
            })
            .collect();
        self.white(&full)
    }

    /// Adds a knob to those that are fitted; its effects.
    pub fn correct(&mut self, slopes: &Slopes) -> Vec<Effect> {
        let known = self
            .corrections
            .iter()
            .find(|own| own.knob == slopes.knob && own.declared == slopes.declared);
        if let Some(known) = known {
            return known.effects();
        }
        let first = self
            .corrections
            .last()
            .map_or(0, |last| last.first + last.declared.len());
        let correction = Correction {
            knob: slopes.knob.clone(),
            declared: slopes.declared.clone(),
            now: slopes.declared.clone(),
            first,
        };
        for (at, bench) in self.benches.iter_mut().enumerate() {
            bench
                .tangents
                .extend(slopes.raw.iter().map(|raw| raw[at].clone()));
        }
        let effects = correction.effects();
        self.corrections.push(correction);
        effects
    }

    /// The correction that an effect is of, and which of its values.
    #[must_use]
    pub fn correction(&self, effect: &Effect) -> Option<(&Correction, usize)> {
        let Site::Declared(at) = effect.site else {
            return None;
        };
        let at = usize::from(at);
        self.corrections
            .iter()
            .find(|own| (own.first..own.first + own.declared.len()).contains(&at))
            .map(|own| (own, at - own.first))
    }

    /// Values of all corrections in a model.
    fn values(&self, model: &Model) -> Vec<Vec<f64>> {
        let mut all: Vec<Vec<f64>> = self
            .corrections
            .iter()
            .map(|own| own.declared.clone())
            .collect();
        for term in &model.terms {
            let Site::Declared(at) = term.effect.site else {
                continue;
            };
            for (own, values) in self.corrections.iter().zip(&mut all) {
                if let Some(value) = usize::from(at)
                    .checked_sub(own.first)
                    .and_then(|at| values.get_mut(at))
                {
                    *value += term.sizes[0];
                }
            }
        }
        all
    }

    /// Of each recording, the knobs that a model corrects and its twin declares, with their values.
    #[must_use]
    pub fn corrected(&self, model: &Model) -> Vec<Vec<(Knob, Vec<f64>)>> {
        let values = self.values(model);
        let in_model = |own: &Correction| {
            let mut terms = model.terms.iter();
            terms.any(|term| own.effects().contains(&term.effect))
        };
        let of_bench = |bench: &Bench| {
            let each = self.corrections.iter().zip(&values);
            each.filter(|(own, _)| in_model(own) && !bench.tangents[own.first].is_empty())
                .map(|(own, values)| (own.knob.clone(), values.clone()))
                .collect()
        };
        self.benches.iter().map(of_bench).collect()
    }

    /// The board beside twins with other values of the corrections; none where there are no such twins.
    fn taken(&self, values: &[Vec<f64>]) -> Option<Self> {
        let benches: Option<Vec<Bench>> = self
            .benches
            .par_iter()
            .map(|bench| {
                let own: Vec<(&Knob, &[f64])> = self
                    .corrections
                    .iter()
                    .zip(values)
                    .filter(|(own, _)| !bench.tangents[own.first].is_empty())
                    .map(|(own, values)| (&own.knob, values.as_slice()))
                    .collect();
                let twin = numbers::changed(&bench.twin, &own)?;
                let errors = sim::true_errors(&twin)
                    .ok()
                    .or_else(|| (twin.errors == bench.twin.errors).then(|| bench.disc.clone()))?;
                let mut next = Bench::about(
                    bench.record.clone(),
                    &twin,
                    &errors,
                    &bench.found,
                    &self.noise,
                );
                next.stays(bench);
                let own = next.own.clone();
                next.decide_ties(&own);
                for (correction, values) in self.corrections.iter().zip(values) {
                    let count = correction.declared.len();
                    let some = if bench.tangents[correction.first].is_empty() {
                        vec![Vec::new(); count]
                    } else {
                        slopes(&next, &correction.knob, values)?
                    };
                    next.tangents.extend(some);
                }
                next.count_as_declared(&self.corrections, values);
                next.own.iter().all(|own| own.is_finite()).then_some(next)
            })
            .collect();
        let mut next = self.clone();
        next.benches = benches?;
        for (correction, values) in next.corrections.iter_mut().zip(values) {
            correction.now.clone_from(values);
        }
        Some(next)
    }

    /// The board about what its benches say was found.
    #[must_use]
    pub fn found_anew(&self) -> Option<Self> {
        let each = self.corrections.iter();
        let values: Vec<Vec<f64>> = each.map(|own| own.now.clone()).collect();
        self.taken(&values)
    }

    /// The board beside twins as they are declared but for the corrections of a model.
    #[must_use]
    pub fn declaring(&self, model: &Model) -> Self {
        let has = |own: &Correction| {
            let mut terms = model.terms.iter();
            terms.any(|term| own.effects().contains(&term.effect))
        };
        let each = self.corrections.iter();
        let values: Vec<Vec<f64>> = each
            .map(|own| if has(own) { &own.now } else { &own.declared }.clone())
            .collect();
        let mut each = self.corrections.iter().zip(&values);
        if each.all(|(own, values)| own.now == *values) {
            return self.clone();
        }
        self.taken(&values).unwrap_or_else(|| self.clone())
    }

    /// Twice the negative logarithm of the likelihood, but for a constant, with the corrections as the board's twins have them and all
    /// else fitted.
    fn cost(&self, fit: &Fit) -> f64 {
        let mut target = fit.left.clone();
        let mut others: Vec<&[f64]> = Vec::new();
        for (column, (term, number)) in fit.columns.iter().zip(&fit.of) {
            let term = &fit.model.terms[*term];
            let Some((correction, at)) = self.correction(&term.effect) else {
                if *number < term.sizes.len() {
                    let size = term.sizes[*number];
                    target
                        .iter_mut()
                        .zip(column)
                        .for_each(|(target, of)| *target += size * of);
                }
                others.push(column);
                continue;
            };
            let by = term.sizes[*number] - (correction.now[at] - correction.declared[at]);
            target
                .iter_mut()
                .zip(column)
                .for_each(|(target, of)| *target += by * of);
        }
        lsq::solve(&others, &target).rss + self.spread()
    }

    /// The part of that which goes by the filter alone.
    #[must_use]
    pub fn spread(&self) -> f64 {
        let scales = self.benches.iter().flat_map(|bench| &bench.scales);
        scales
            .filter(|scale| **scale > 0.0)
            .map(|scale| -2.0 * scale.ln())
            .sum()
    }

    /// A model with corrections, fitted until its twins are those of the fit: the board beside them, the fit, and the fall of the cost
    /// against another fit on this board.
    #[must_use]
    pub fn settle(&self, model: &Model, against: &Fit) -> (Self, Fit, f64) {
        let mut board = self.clone();
        let mut fit = board.fit(model);
        let mut cost = board.cost(&fit);
        for _ in 0..ROUNDS {
            let wanted = board.values(&fit.model);
            if board.is_settled(&fit, &wanted) {
                break;
            }
            let mut share = 1.0;
            let mut better = None;
            for _ in 0..SHORTENED {
                let values: Vec<Vec<f64>> = board
                    .corrections
                    .iter()
                    .zip(&wanted)
                    .map(|(own, wanted)| {
                        let each = own.now.iter().zip(wanted);
                        each.map(|(now, wanted)| now + share * (wanted - now))
                            .collect()
                    })
                    .collect();
                if let Some(next) = board.taken(&values) {
                    let tried = next.fit(&fit.model);
                    let here = next.cost(&tried);
                    if here < cost {
                        better = Some((next, tried, here));
                        break;
                    }
                }
                share *= SHORTER;
            }
            let Some(next) = better else { break };
            (board, fit, cost) = next;
        }
        let gain = self.cost(against) - cost;
        (board, fit, gain)
    }

    /// Whether the twins can be, and no number is so far from the declared one that it is another thing.
    #[must_use]
    pub fn is_possible(&self) -> bool {
        let mut benches = self.benches.iter();
        let mut corrections = self.corrections.iter();
        corrections.all(|own| own.is_near(&own.now))
            && benches.all(|bench| bench.twin.check().is_ok())
    }

    /// Whether what a group of a model corrects is still about what the twins declare.
    #[must_use]
    pub fn is_near(&self, model: &Model, group: usize) -> bool {
        let effects = model.effects(group);
        let has = |own: &Correction| own.effects().iter().any(|one| effects.contains(one));
        let mut each = self.corrections.iter().zip(self.values(model));
        each.all(|(own, values)| !has(own) || own.is_near(&values))
    }

    /// Whether the values that a fit wants are those that the twins have.
    fn is_settled(&self, fit: &Fit, wanted: &[Vec<f64>]) -> bool {
        fit.of.iter().enumerate().all(|(column, (term, _))| {
            let effect = &fit.model.terms[*term].effect;
            let Some((correction, at)) = self.correction(effect) else {
                return true;
            };
            let place = self
                .corrections
                .iter()
                .position(|own| own.first == correction.first);
            let by = place.map_or(0.0, |place| wanted[place][at] - correction.now[at]);
            let error = fit.covariance[(column, column)].max(0.0).sqrt();
            by.abs() <= SETTLED * error
        })
    }

    /// The mechanism that a group of effects is.
    #[must_use]
    pub fn mechanism(&self, effects: &[Effect]) -> Mechanism {
        match effects.first().and_then(|first| self.correction(first)) {
            Some((correction, _)) => correction.knob.path().mechanism(),
            None => super::name::mechanism(effects),
        }
    }

    /// The group of a fit that corrects the same entry of the twin as a knob, or one that is free.
    #[must_use]
    pub fn group_of(&self, model: &Model, knob: &Knob, free: usize) -> usize {
        let entry = knob.path().entry();
        let same = model.terms.iter().find(|term| {
            self.correction(&term.effect)
                .is_some_and(|(own, _)| own.knob.path().entry() == entry)
        });
        same.map_or(free, |term| term.group)
    }

    /// Whether the columns of some effects are those of a group of a fit.
    #[must_use]
    pub fn same_columns(&self, fit: &Fit, group: usize, effects: &[Effect]) -> bool {
        let mut others: Vec<&[f64]> = Vec::new();
        let mut own: Vec<&[f64]> = Vec::new();
        for (column, (term, _)) in fit.columns.iter().zip(&fit.of) {
            if fit.model.terms[*term].group == group {
                own.push(column);
            } else {
                others.push(column);
            }
        }
        let columns: Vec<Vec<f64>> = effects
            .iter()
            .flat_map(|effect| self.columns(effect))
            .collect();
        let mut span = others.clone();
        span.extend(own);
        let (beside, with) = (Basis::of(&others), Basis::of(&span));
        columns.iter().all(|column| {
            let square = |basis: &Basis| {
                let mut column = column.clone();
                basis.clear(&mut column);
                dot(&column, &column)
            };
            square(&with) < SAME * square(&beside)
        })
    }
}

impl Bench {
    /// Makes the residual one beside the twin as it was given, by the tangents.
    fn count_as_declared(&mut self, corrections: &[Correction], values: &[Vec<f64>]) {
        self.residual.clone_from(&self.own);
        for (correction, values) in corrections.iter().zip(values) {
            for (at, (value, declared)) in values.iter().zip(&correction.declared).enumerate() {
                let by = value - declared;
                self.residual
                    .iter_mut()
                    .zip(&self.tangents[correction.first + at])
                    .for_each(|(rest, of)| *rest += by * of);
            }
        }
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
#[must_use]
pub fn candidates<'a>(
    board: &Board,
    slopes: &'a [Slopes],
    fit: &Fit,
    basis: &Basis,
) -> Vec<Candidate<'a>> {
    let free = |slopes: &&Slopes| {
        fit.model.terms.iter().all(|term| {
            board
                .correction(&term.effect)
                .is_none_or(|(own, _)| own.knob != slopes.knob || own.declared != slopes.declared)
        })
    };
    let free: Vec<&Slopes> = slopes.iter().filter(free).collect();
    let mut all: Vec<Candidate<'a>> = free
        .into_par_iter()
        .map(|slopes| Candidate {
            slopes,
            gain: basis.gain(&slopes.white(board), &fit.left),
        })
        .collect();
    all.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    all
}

/// A number that a correction has: its path, its value as declared and as measured.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Where it is in the twin.
    pub path: String,
    /// Its unit.
    pub unit: &'static str,
    /// As declared.
    pub declared: f64,
    /// As measured.
    pub number: Number,
}

/// Numbers of a group of corrections.
#[must_use]
pub fn measured(board: &Board, fit: &Fit, group: usize) -> Vec<Measured> {
    let mut all = Vec::new();
    let mut seen = Vec::new();
    for term in fit.model.terms.iter().filter(|term| term.group == group) {
        let Some((correction, _)) = board.correction(&term.effect) else {
            continue;
        };
        if seen.contains(&correction.first) {
            continue;
        }
        seen.push(correction.first);
        let effects = correction.effects();
        let column = |at: usize| {
            let term = fit
                .model
                .terms
                .iter()
                .position(|term| Some(&term.effect) == effects.get(at))?;
            let column = fit.of.iter().position(|of| *of == (term, 0))?;
            Some((fit.model.terms[term].sizes[0], column))
        };
        let each: Vec<(f64, usize)> = (0..effects.len()).filter_map(column).collect();
        if each.len() < effects.len() {
            continue;
        }
        let values: Vec<f64> = correction
            .declared
            .iter()
            .zip(&each)
            .map(|(declared, (by, _))| declared + by)
            .collect();
        let of = |a: usize, b: usize| {
            let pair = (each.get(a), each.get(b));
            match pair {
                (Some((_, a)), Some((_, b))) => fit.covariance[(*a, *b)],
                _ => 0.0,
            }
        };
        let covariance = [[of(0, 0), of(0, 1)], [of(1, 0), of(1, 1)]];
        let errors = correction.knob.errors(&values, &covariance);
        let (now, declared) = (
            correction.knob.numbers(&values),
            correction.knob.numbers(&correction.declared),
        );
        for (at, path) in correction.knob.paths().into_iter().enumerate() {
            all.push(Measured {
                path: path.to_string(),
                unit: path.unit(),
                declared: declared[at],
                number: Number {
                    name: path.name(),
                    value: now[at],
                    error: Some(errors[at]),
                },
            });
        }
    }
    all
}

/// Corrections in words: "gear_mesh.torque_n_m: 4.00 mN m declared, 2.00 +- 0.01 mN m measured"; `spread` widens the intervals.
#[must_use]
pub fn text(corrections: &[Measured], spread: f64) -> String {
    let each = corrections.iter().map(|one| {
        let error = one.number.error.unwrap_or(0.0) * NINETY_FIVE * spread;
        format!(
            "{}: {} declared, {} +- {} measured",
            one.path,
            si(one.declared, one.unit),
            si(one.number.value, one.unit),
            si(error, one.unit)
        )
    });
    each.collect::<Vec<_>>().join("; ")
}

/// Numbers that some cells correct, as the twin declares them.
#[must_use]
pub fn declared(board: &Board, cells: &[Sized]) -> BTreeMap<String, f64> {
    let corrections = cells
        .iter()
        .filter_map(|cell| board.correction(&cell.effect));
    corrections
        .filter(|(_, at)| *at == 0)
        .flat_map(|(own, _)| {
            let paths = own.knob.paths().into_iter();
            let numbers = own.knob.numbers(&own.declared);
            paths
                .zip(numbers)
                .map(|(path, number)| (path.name(), number))
                .collect::<Vec<_>>()
        })
        .collect()
}

/// Numbers of corrections as a finding has them; `spread` widens the intervals.
#[must_use]
pub fn parameters(corrections: &[Measured], spread: f64) -> BTreeMap<String, Parameter> {
    let each = corrections.iter().map(|one| {
        let by = one.number.error.map(|error| NINETY_FIVE * spread * error);
        let parameter = Parameter {
            value: one.number.value,
            unit: one.unit.to_owned(),
            ci95: by.map(|by| [one.number.value - by, one.number.value + by]),
        };
        (one.number.name.clone(), parameter)
    });
    each.collect()
}
