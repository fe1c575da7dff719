//! Numbers that the twins declare, fitted: each is a column like that of an effect, the slope of the innovations over it.
//!
//! A column is the difference that a small change of the number makes to all that the twin says, filter included. The twins are then
//! taken with the fitted numbers and the columns worked out anew, until nothing changes (Gauss and Newton on prediction errors: L. Ljung,
//! System Identification, 2nd ed., section 10.2).

mod knobs;
mod words;

use rayon::prelude::*;

pub use knobs::{Slopes, all, candidates, of_disc};
pub use words::{declared, measured, text};

use super::bench::Bench;
use super::effect::{Effect, Site};
use super::lsq::{self, Basis, add, dot};
use super::model::{Board, Correction, Fit, Model};
use super::numbers::{self, Knob};
use crate::mechanism::Mechanism;
use crate::sim;

/// Part of a column's square that is its own, up to which it is the same as others.
const SAME: f64 = 1e-2;

impl Board {
    /// Adds a knob to those that are fitted; its effects.
    pub fn correct(&mut self, slopes: &Slopes) -> Vec<Effect> {
        if let Some(known) = self.corrections.iter().find(|own| own.is_of(slopes)) {
            return known.effects();
        }
        let last = self.corrections.last();
        let correction = Correction {
            knob: slopes.knob.clone(),
            declared: slopes.declared.clone(),
            now: slopes.declared.clone(),
            first: last.map_or(0, |last| last.first + last.declared.len()),
        };
        for (bench, raw) in self.benches.iter_mut().zip(&slopes.raw) {
            bench.tangents.extend(raw.iter().cloned());
        }
        let effects = correction.effects();
        self.corrections.push(correction);
        effects
    }

    /// Which correction an effect is of, and which of its values.
    fn place(&self, effect: &Effect) -> Option<(usize, usize)> {
        let Site::Declared(at) = effect.site else {
            return None;
        };
        let mut each = self.corrections.iter().enumerate();
        each.find_map(|(which, own)| {
            let value = usize::from(at).checked_sub(own.first)?;
            (value < own.declared.len()).then_some((which, value))
        })
    }

    /// The correction that an effect is of, and which of its values.
    pub fn correction(&self, effect: &Effect) -> Option<(&Correction, usize)> {
        let place = self.place(effect);
        place.map(|(which, value)| (&self.corrections[which], value))
    }

    /// Values of all corrections in a model.
    fn values(&self, model: &Model) -> Vec<Vec<f64>> {
        let each = self.corrections.iter();
        let mut all: Vec<Vec<f64>> = each.map(|own| own.declared.clone()).collect();
        for term in &model.terms {
            if let Some((which, value)) = self.place(&term.effect) {
                all[which][value] += term.sizes[0];
            }
        }
        all
    }

    /// Of each recording, the knobs that a model corrects and its twin declares, with their values.
    pub fn corrected(&self, model: &Model) -> Vec<Vec<(Knob, Vec<f64>)>> {
        let values = self.values(model);
        let of_bench = |bench: &Bench| {
            let each = self.corrections.iter().zip(&values);
            each.filter(|(own, _)| own.is_in(model) && !bench.tangents[own.first].is_empty())
                .map(|(own, values)| (own.knob.clone(), values.clone()))
                .collect()
        };
        self.benches.iter().map(of_bench).collect()
    }

    /// The board beside twins with other values of the corrections; none where there are no such twins.
    fn taken(&self, values: &[Vec<f64>]) -> Option<Self> {
        let take = |bench: &Bench| {
            let each = self.corrections.iter().zip(values);
            let declares = |own: &Correction| !bench.tangents[own.first].is_empty();
            let own = each.clone().filter(|(own, _)| declares(own));
            let own: Vec<(&Knob, &[f64])> = own.map(|(own, now)| (&own.knob, &now[..])).collect();
            let twin = numbers::changed(&bench.twin, &own)?;
            let errors = sim::true_errors(&twin)
                .ok()
                .or_else(|| (twin.errors == bench.twin.errors).then(|| bench.disc.clone()))?;
            let mut next = bench.anew(&twin, &errors, &self.noise);
            let own = next.own.clone();
            next.decide_ties(&own);
            // The residual is one beside the twin as it was given, by the tangents.
            let mut residual = next.own.clone();
            for (own, values) in each {
                let tangents = knobs::slopes(&next, declares(own), &own.knob, values)?;
                let both = values.iter().zip(&own.declared);
                for ((value, declared), tangent) in both.zip(&tangents) {
                    add(&mut residual, value - declared, tangent);
                }
                next.tangents.extend(tangents);
            }
            next.residual = residual;
            next.own.iter().all(|own| own.is_finite()).then_some(next)
        };
        let benches = self.benches.par_iter().map(take);
        let mut next = Self {
            benches: benches.collect::<Option<_>>()?,
            ..self.clone()
        };
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
        let mut each = self.corrections.iter();
        if each.all(|own| own.is_in(model) || own.now == own.declared) {
            return self.clone();
        }
        let each = self.corrections.iter();
        let values = each.map(|own| {
            if own.is_in(model) {
                &own.now
            } else {
                &own.declared
            }
        });
        let values: Vec<Vec<f64>> = values.cloned().collect();
        self.taken(&values).unwrap_or_else(|| self.clone())
    }

    /// Twice the negative logarithm of the likelihood, but for a constant, with the corrections as the board's twins have them and all
    /// else fitted.
    fn cost(&self, fit: &Fit) -> f64 {
        let mut target = fit.beside(&|_| true);
        let mut others: Vec<&[f64]> = Vec::new();
        for (column, (term, _)) in fit.columns.iter().zip(&fit.of) {
            match self.correction(&fit.model.terms[*term].effect) {
                Some((own, at)) => add(&mut target, own.declared[at] - own.now[at], column),
                None => others.push(column),
            }
        }
        lsq::solve(&others, &target).rss + self.spread()
    }

    /// The part of that which goes by the filter alone.
    pub fn spread(&self) -> f64 {
        let scales = self.benches.iter().flat_map(|bench| &bench.scales);
        let shown = scales.filter(|scale| **scale > 0.0);
        shown.map(|scale| -2.0 * scale.ln()).sum()
    }

    /// A model with corrections, fitted until its twins are those of the fit: the board beside them, the fit, and the fall of the cost
    /// against another fit on this board.
    #[must_use]
    pub fn settle(&self, model: &Model, against: &Fit) -> (Self, Fit, f64) {
        let mut board = self.clone();
        let mut fit = board.fit(model);
        let mut cost = board.cost(&fit);
        for _ in 0..lsq::ROUNDS {
            let wanted = board.values(&fit.model);
            if board.is_settled(&fit, &wanted) {
                break;
            }
            let better = lsq::shares(4).find_map(|share| {
                let part = |(own, wanted): (&Correction, &Vec<f64>)| {
                    let each = own.now.iter().zip(wanted);
                    each.map(|(now, wanted)| now + share * (wanted - now))
                        .collect()
                };
                let values: Vec<Vec<f64>> =
                    board.corrections.iter().zip(&wanted).map(part).collect();
                let next = board.taken(&values)?;
                let tried = next.fit(&fit.model);
                let here = next.cost(&tried);
                (here < cost).then_some((next, tried, here))
            });
            let Some(next) = better else { break };
            (board, fit, cost) = next;
        }
        let gain = self.cost(against) - cost;
        (board, fit, gain)
    }

    /// Whether the twins can be, and no number is so far from the declared one that it is another thing.
    pub fn is_possible(&self) -> bool {
        let mut corrections = self.corrections.iter();
        let mut benches = self.benches.iter();
        corrections.all(|own| own.is_near(&own.now))
            && benches.all(|bench| bench.twin.check().is_ok())
    }

    /// Whether what a group of a model corrects is still about what the twins declare, and a twin can have it.
    pub fn is_near(&self, model: &Model, group: usize) -> bool {
        let effects = model.effects(group);
        let has = |own: &Correction| own.effects().iter().any(|one| effects.contains(one));
        let can_be = |own: &Correction, values: &[f64]| {
            let declares = |bench: &&Bench| !bench.tangents[own.first].is_empty();
            let mut declaring = self.benches.iter().filter(declares);
            declaring.all(|bench| {
                let twin = numbers::changed(&bench.twin, &[(&own.knob, values)]);
                twin.is_some_and(|twin| twin.check().is_ok())
            })
        };
        let mut each = self.corrections.iter().zip(self.values(model));
        each.all(|(own, values)| !has(own) || own.is_near(&values) && can_be(own, &values))
    }

    /// Whether the values that a fit wants are those that the twins have.
    fn is_settled(&self, fit: &Fit, wanted: &[Vec<f64>]) -> bool {
        fit.of.iter().enumerate().all(|(column, (term, _))| {
            let Some((which, at)) = self.place(&fit.model.terms[*term].effect) else {
                return true;
            };
            let by = wanted[which][at] - self.corrections[which].now[at];
            lsq::is_settled(by, fit.covariance[(column, column)])
        })
    }

    /// The mechanism that a group of effects is.
    pub fn mechanism(&self, effects: &[Effect]) -> Mechanism {
        match effects.first().and_then(|first| self.correction(first)) {
            Some((correction, _)) => correction.knob.path().mechanism(),
            None => super::name::mechanism(effects),
        }
    }

    /// The group of a fit that corrects the same entry of the twin as a knob, or one that is free.
    pub fn group_of(&self, model: &Model, knob: &Knob, free: usize) -> usize {
        let entry = knob.path().entry();
        let same = |(own, _): (&Correction, usize)| own.knob.path().entry() == entry;
        let mut terms = model.terms.iter();
        let term = terms.find(|term| self.correction(&term.effect).is_some_and(same));
        term.map_or(free, |term| term.group)
    }

    /// Whether the columns of some effects are those of a group of a fit.
    pub fn same_columns(&self, fit: &Fit, group: usize, effects: &[Effect]) -> bool {
        let mut beside = Basis::default();
        let mut own = Vec::new();
        for (column, (term, _)) in fit.columns.iter().zip(&fit.of) {
            if fit.model.terms[*term].group == group {
                own.push(column.clone());
            } else {
                beside.add(column.clone());
            }
        }
        let mut with = beside.clone();
        own.into_iter().for_each(|column| with.add(column));
        let square = |basis: &Basis, column: &[f64]| {
            let left = basis.beside(column);
            dot(&left, &left)
        };
        let same = |column: &Vec<f64>| square(&with, column) < SAME * square(&beside, column);
        effects
            .iter()
            .all(|effect| self.columns(effect).iter().all(same))
    }
}
