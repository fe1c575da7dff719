//! All numbers of a model at once: sizes by least squares, knobs by steps of Gauss and Newton.

use std::borrow::Cow;
use std::f64::consts::TAU;
use std::sync::Arc;

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::board::Raw;
use super::{Board, Model, Term};
use crate::diagnose::effect::{Carrier, Effect, Growth, Site, is_exact};
use crate::diagnose::lsq::{self, Basis};
use crate::diagnose::pattern::{CLEAR, SMALLER};
use crate::diagnose::record::Record;

/// Step by which a knob's slope is taken, of what hardly changes its effect: far above the error of sums over an interval.
const STEP: f64 = 4e-3;

/// A fit.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The model with its numbers.
    pub model: Model,
    /// Columns of sizes and knobs, white, all recordings in a row.
    pub columns: Vec<Vec<f64>>,
    /// Of each column its term, and which of its numbers: sizes first, then knobs.
    pub of: Vec<(usize, usize)>,
    /// Covariance of the numbers, in the order of the columns.
    pub covariance: DMatrix<f64>,
    /// What is left, white, all recordings in a row.
    pub left: Vec<f64>,
    /// Sum of its squares.
    pub rss: f64,
    /// The same where knobs go on as their slopes say.
    lowest: f64,
    /// By how much each column's number still changes so.
    by: Vec<f64>,
}

impl Fit {
    /// Of columns, fitted to a row whatever the sizes in the model are.
    fn of(model: Model, columns: Vec<Vec<f64>>, of: Vec<(usize, usize)>, target: &[f64]) -> Self {
        let solved = lsq::solve(&columns, target);
        Self {
            model,
            columns,
            of,
            covariance: solved.covariance,
            left: solved.left,
            rss: solved.rss,
            lowest: solved.rss,
            by: solved.sizes,
        }
    }

    /// Whether a term, by its place, is of a group.
    fn is_of(&self, group: usize) -> impl Fn(usize) -> bool + '_ {
        move |term| self.model.terms[term].group == group
    }

    /// The same without a group: all other numbers fitted again, knobs as slopes.
    #[must_use]
    pub fn without(&self, group: usize) -> Self {
        self.without_some(&self.is_of(group))
    }

    /// The same without some terms, by their places.
    #[must_use]
    pub fn without_some(&self, gone: &dyn Fn(usize) -> bool) -> Self {
        let terms = { self.model.terms.iter().enumerate() }.filter(|(at, _)| !gone(*at));
        let terms = terms.map(|(_, term)| term.clone()).collect();
        let before = |term: usize| (0..term).filter(|&at| gone(at)).count();
        let kept = { self.columns.iter().zip(&self.of) }.filter(|(_, (term, _))| !gone(*term));
        let kept =
            kept.map(|(column, &(term, number))| (column.clone(), (term - before(term), number)));
        let (columns, of) = kept.unzip();
        let mut fit = Self::of(Model { terms }, columns, of, &self.beside(gone));
        for (&(term, number), by) in fit.of.iter().zip(&mut fit.by) {
            if let Some(size) = fit.model.terms[term].sizes.get_mut(number) {
                *size += std::mem::take(by);
            }
        }
        fit
    }

    /// The same whose numbers are less sure, by a factor for each term by its place: what is left may be larger than noise, or not white.
    #[must_use]
    pub fn widened(mut self, by: impl Fn(usize) -> f64) -> Self {
        let each: Vec<f64> = self.of.iter().map(|(term, _)| by(*term)).collect();
        self.covariance = DMatrix::from_fn(each.len(), each.len(), |a, b| {
            each[a] * each[b] * self.covariance[(a, b)]
        });
        self
    }

    /// What some terms make of each innovation.
    pub fn own_of(&self, asked: &dyn Fn(usize) -> bool) -> Vec<f64> {
        let mut own = vec![0.0; self.left.len()];
        for (column, (at, number)) in self.columns.iter().zip(&self.of) {
            // Knobs have no sizes.
            let size = self.model.terms[*at].sizes.get(*number);
            if let Some(size) = size.filter(|_| asked(*at)) {
                lsq::add(&mut own, *size, column);
            }
        }
        own
    }

    /// What is left where the sizes of some terms are none.
    pub fn beside(&self, gone: &dyn Fn(usize) -> bool) -> Vec<f64> {
        let mut target = self.own_of(gone);
        lsq::add(&mut target, 1.0, &self.left);
        target
    }

    /// An orthonormal basis of its columns.
    pub fn basis(&self) -> Basis {
        Basis::of(&self.columns)
    }

    /// By how much the sum of squares grows without a group, all else fitted again, knobs as slopes.
    pub fn loss(&self, group: usize) -> f64 {
        self.loss_of(&self.is_of(group))
    }

    /// The same without some terms, by their places.
    pub fn loss_of(&self, gone: &dyn Fn(usize) -> bool) -> f64 {
        (self.without_some(gone).rss - self.lowest).max(0.0)
    }
}

impl Board {
    /// What a small change of a knob of a term does to the edges of each recording, rad.
    fn slope(&self, term: &Term, knob: usize) -> Raw<'_> {
        let step = STEP * self.reach(&term.effect)[knob];
        let mut knobs = term.effect.knobs();
        knobs[knob] += step;
        let moved = term.effect.with_knobs(&knobs);
        let each = self.benches.iter().map(|bench| {
            let (now, moved) = (bench.columns(&term.effect), bench.columns(&moved));
            let mut sum = vec![0.0; bench.record.len()];
            for (size, (now, moved)) in term.sizes.iter().zip(now.iter().zip(moved.iter())) {
                let by = size / step;
                let each = sum.iter_mut().zip(now.iter().zip(moved));
                each.for_each(|(sum, (now, moved))| *sum += by * (moved - now));
            }
            Cow::Owned(sum)
        });
        (term.effect, each.collect())
    }

    /// Steps of an effect's knobs that hardly change it: what two of them are apart by to be told apart.
    pub fn reach(&self, effect: &Effect) -> Vec<f64> {
        let seconds = self.seconds();
        let records = self.benches.iter().map(|bench| &bench.record);
        let longest = { records.clone() }.max_by(|a, b| a.turns().total_cmp(&b.turns()));
        let turns = longest.map_or(1.0, |record| {
            let least = record.place.iter().min().copied().unwrap_or(0);
            let most = record.place.iter().max().copied().unwrap_or(1);
            (most - least).max(1) as f64 / record.edges as f64
        });
        let interval = seconds / records.map(Record::len).max().unwrap_or(1) as f64;
        let mut reach = match effect.carrier {
            Carrier::Order(_) => vec![1.0 / turns],
            Carrier::Tone(_) => vec![1.0 / seconds],
            Carrier::Chirp(..) => vec![1.0 / seconds, 2.0 / (seconds * seconds)],
            Carrier::Bump(_, sigma) => vec![sigma, 0.5 * sigma],
            Carrier::Window(..) => vec![3.0 * interval; 2],
            Carrier::Settling(_, tau) => vec![0.3 * tau, 0.3 * tau],
            Carrier::Stribeck(speed) => vec![0.2 * speed],
            Carrier::Steady | Carrier::Time | Carrier::Direction | Carrier::Power(_) => Vec::new(),
        };
        match effect.growth {
            Growth::Constant | Growth::Own | Growth::Past(_) => {}
            Growth::Even(_) => reach.push(0.3 / seconds),
            Growth::Speed(_) => reach.push(0.2),
            Growth::Modulated(..) => reach.extend([1.0 / seconds, 0.2, 0.3]),
        }
        reach
    }

    /// Whether two effects can't be told apart.
    pub fn is_same(&self, one: &Effect, other: &Effect) -> bool {
        let (here, there) = (one.knobs(), other.knobs());
        let near = here.iter().zip(&there).zip(self.reach(one));
        one.with_knobs(&there) == *other && { near }
            .all(|((here, there), reach)| here == there || (here - there).abs() < reach)
    }

    /// Knobs that are fitted: an instant beyond a recording's ends is none.
    fn fitted(&self, effect: &Effect) -> Vec<usize> {
        let knobs = effect.knobs();
        let on_one_edge = self.at_its_edge(effect) == Some(*effect);
        let times = self.benches.iter().map(|bench| &bench.record.time_s);
        let each = times.flat_map(|times| times.first().into_iter().chain(times.last()));
        let (first, last) = lsq::ends(each.copied());
        (0..knobs.len())
            .filter(|&at| match effect.carrier {
                Carrier::Bump(..) => at > 1 || !on_one_edge,
                Carrier::Window(..) => knobs[at] > first && knobs[at] < last,
                // Without a start it settles from the first edge on.
                Carrier::Settling(from, _) => at == 1 || from > first,
                // How its size goes is open at an exact order as well.
                Carrier::Order(order) => at > 0 || !is_exact(order),
                _ => true,
            })
            .collect()
    }

    /// Whether each edge of the disc is seen: those of a gap are not.
    pub fn seen(&self) -> Vec<bool> {
        let edges = self.benches.first().map_or(0, |bench| bench.record.edges);
        let mut seen = vec![false; edges as usize];
        for record in self.benches.iter().map(|bench| &bench.record) {
            (0..record.len()).for_each(|at| seen[record.slot(at)] = true);
        }
        seen
    }

    /// A bump that only one edge of those seen shows, as one at that edge: any other place and width say the same of it with another size.
    pub fn at_its_edge(&self, effect: &Effect) -> Option<Effect> {
        /// Part of a bump at an edge that is none at those beside it, and its width then, of the way to the nearest of them.
        const ALONE: f64 = 0.02;
        const NARROW: f64 = 0.25;
        let record = &self.benches.first()?.record;
        let (Site::Disc(on), Carrier::Bump(middle, sigma)) = (effect.site, effect.carrier) else {
            return None;
        };
        if sigma > record.step_rad() {
            return None;
        }
        let seen = self.seen();
        let own = (0..seen.len()).filter(|slot| seen[*slot] && on.has(record.change_of(*slot)));
        let apart = |from: f64, to: f64| (from - to - TAU * ((from - to) / TAU).round()).abs();
        let angles: Vec<f64> = own.map(|slot| record.angle_of(slot)).collect();
        let near = |from: f64| move |a: &f64, b: &f64| apart(from, *a).total_cmp(&apart(from, *b));
        let own = angles.iter().copied().min_by(near(middle))?;
        let others = angles.iter().copied().filter(|angle| *angle != own);
        let next = others.clone().min_by(near(middle))?;
        let squares = [own, next].map(|angle| (apart(middle, angle) / sigma).powi(2));
        let beside = others.min_by(near(own))?;
        let at_edge = Carrier::Bump(own, NARROW * apart(own, beside));
        ((0.5 * (squares[0] - squares[1])).exp() < ALONE).then_some(Effect {
            carrier: at_edge,
            ..*effect
        })
    }

    /// Fits all numbers of a model, from where they are.
    pub fn fit(&self, model: &Model) -> Fit {
        self.settled(model, &self.target(), &Basis::default())
    }

    /// More effects with their best numbers beside a fit, whose own sizes and knobs move along but are not worked out anew: their terms,
    /// and by how much the sum of squares falls. `basis` is that of the fit's columns.
    pub fn beside(&self, fit: &Fit, basis: &Basis, effects: &[Effect]) -> (Vec<Effect>, f64) {
        let mut target = fit.left.clone();
        basis.clear(&mut target);
        let before = lsq::dot(&target, &target);
        let settled = self.settled(&Model::default().with(effects, 0), &target, basis);
        let possible = self.can_be(&settled.model);
        let gain = if possible { before - settled.rss } else { 0.0 };
        (settled.model.effects(0), gain)
    }

    /// All numbers of a model, re-linearised until nothing changes; what is of the basis is taken off its columns.
    fn settled(&self, model: &Model, target: &[f64], basis: &Basis) -> Fit {
        /// Fall of the sum of squares that is none.
        const NONE: f64 = 0.02;
        let mut now = self.with_slopes(self.sized(model, target, basis), basis);
        for _ in 0..lsq::ROUNDS {
            let is_size =
                |(term, number): &(usize, usize)| *number < now.model.terms[*term].effect.sizes();
            // Knobs that go on as their slopes say would gain nothing.
            if now.of.iter().all(is_size) || now.rss - now.lowest < NONE {
                break;
            }
            let Some(better) = self.step(&now, target, basis) else {
                break;
            };
            let gain = now.rss - better.rss;
            now = self.with_slopes(better, basis);
            if gain < NONE {
                break;
            }
        }
        now
    }

    /// Sizes for knobs as they are; columns of these alone.
    fn sized(&self, model: &Model, target: &[f64], basis: &Basis) -> Fit {
        let effects = model.terms.iter().map(|term| term.effect);
        // What the twins declare has other columns beside other twins.
        let is_declared = |effect: &Effect| matches!(effect.site, Site::Declared(_));
        let (declared, others): (Vec<_>, Vec<_>) = effects.partition(is_declared);
        let work_out = |effects: &[Effect]| self.columns_until(effects, SMALLER);
        let mut others = self.white.of(self.mark(), &others, work_out).into_iter();
        let mut declared = work_out(&declared).into_iter().map(Arc::new);
        let (mut columns, mut of) = (Vec::new(), Vec::new());
        for (at, term) in model.terms.iter().enumerate() {
            let own = match is_declared(&term.effect) {
                true => declared.next(),
                false => others.next(),
            };
            columns.extend(own.iter().flat_map(|own| own.iter().cloned()));
            of.extend((0..term.effect.sizes()).map(|size| (at, size)));
        }
        let each = columns.par_iter_mut();
        each.for_each(|column: &mut Vec<f64>| basis.clear(column));
        let mut fit = Fit::of(model.clone(), columns, of, target);
        for ((term, number), size) in fit.of.iter().zip(&fit.by) {
            fit.model.terms[*term].sizes[*number] = *size;
        }
        fit
    }

    /// The same with what a small change of each knob does, at these sizes.
    fn with_slopes(&self, mut fit: Fit, basis: &Basis) -> Fit {
        let knobs = fit.model.terms.iter().enumerate().flat_map(|(at, term)| {
            let fitted = self.fitted(&term.effect);
            fitted.into_iter().map(move |knob| (at, knob))
        });
        let knobs: Vec<(usize, usize)> = knobs.collect();
        if knobs.is_empty() {
            return fit;
        }
        let terms = &fit.model.terms;
        let slopes = { knobs.par_iter() }.map(|&(at, knob)| self.slope(&terms[at], knob));
        let mut slopes = self.shown(&slopes.collect::<Vec<_>>(), CLEAR);
        slopes.par_iter_mut().for_each(|slope| basis.clear(slope));
        for ((at, knob), slope) in knobs.into_iter().zip(slopes) {
            fit.columns.push(slope);
            fit.of.push((at, fit.model.terms[at].effect.sizes() + knob));
        }
        let solved = lsq::solve(&fit.columns, &fit.left);
        fit.covariance = solved.covariance;
        fit.lowest = solved.rss;
        fit.by = solved.sizes;
        fit
    }

    /// A step of Gauss and Newton, shortened until it helps, without its slopes; none where it does not.
    fn step(&self, now: &Fit, target: &[f64], basis: &Basis) -> Option<Fit> {
        lsq::shares(5).find_map(|share| {
            let mut model = now.model.clone();
            for (at, term) in model.terms.iter_mut().enumerate() {
                let reach = self.reach(&term.effect);
                let mut knobs = term.effect.knobs();
                let own = now.of.iter().zip(&now.by).filter(|(of, _)| of.0 == at);
                for ((_, number), by) in own {
                    if let Some(knob) = number.checked_sub(term.effect.sizes()) {
                        knobs[knob] += (share * by).clamp(-reach[knob], reach[knob]);
                    }
                }
                let moved = term.effect.with_knobs(&knobs);
                let moved = self.at_its_edge(&moved).unwrap_or(moved);
                if moved.is_possible() {
                    term.effect = moved;
                }
            }
            let next = self.sized(&model, target, basis);
            (next.rss < now.rss).then_some(next)
        })
    }
}
