//! The best of all cells beside a fit, and what else explains as much.

use rayon::prelude::*;

use super::classes::joined;
use super::open::{is_course, is_open, left_open, own_errors, past_learned};
use crate::diagnose::cells::{self, Bank};
use crate::diagnose::correct::{self, Slopes};
use crate::diagnose::effect::{Carrier, Effect, Site};
use crate::diagnose::judge;
use crate::diagnose::lsq::Basis;
use crate::diagnose::model::{Board, Fit};
use crate::diagnose::nearby::Left;
use crate::diagnose::pattern::Pattern;
use crate::diagnose::scan::{self, Candidate, SURE, evidence};
use crate::mechanism::Mechanism;

/// Part of what a candidate explains that rounding to ticks alone may make.
const SPUR: f64 = 0.25;
/// Candidates that are fitted with everything else until one is worth it.
pub const TRIED: usize = 4;
/// Part of the best one's evidence that another one has to have to be fitted too.
pub const NEARLY: f64 = 0.8;
/// Part of the evidence that is asked for that a candidate has to have to be fitted with everything else.
const PROMISING: f64 = 0.7;
/// Difference of evidence within which two explanations are alike.
pub const ALIKE: f64 = 10.0;
/// Difference of evidence that is none: at one speed a gear and a bearing's run-out are the same numbers.
const TIED: f64 = 1.0;
/// Turns by which the phase of a torque at a whole order may seem to slip.
const SLIP: f64 = 3.0;
/// Part of what counts as noise that has to be explained for the noise to be another one without it.
pub const LOUD: f64 = 0.05;

/// Evidence of a candidate.
#[must_use]
pub fn worth(board: &Board, one: &Candidate) -> f64 {
    evidence(board, one.gain, one.numbers())
}

/// All candidates beside a fit, strongest first.
#[must_use]
pub fn candidates(board: &Board, bank: &Bank, fit: &Fit) -> Vec<Candidate> {
    let basis = fit.basis();
    let mut fit = fit.clone();
    basis.clear(&mut fit.left);
    let mut all = bank.candidates(&fit, &basis);
    let left = Left::of(board, &fit, &basis);
    all.extend(scan::spectra(&left, &fit.model));
    all.extend(cells::loads(bank, &left));
    all.extend(cells::bumps(bank, &left));
    all.sort_by(|a, b| worth(board, b).total_cmp(&worth(board, a)));
    all
}

/// Whole orders at which a torque shows most beside a fit, or so close that its phase slips by a few turns: where the speed changes, what
/// a torque at a whole order has more than a free disc looks like that.
#[must_use]
pub fn torque_orders(board: &Board, fit: &Fit) -> Vec<usize> {
    let basis = fit.basis();
    let mut fit = fit.clone();
    basis.clear(&mut fit.left);
    let found = scan::spectra(&Left::of(board, &fit, &basis), &fit.model);
    let turns = { board.benches.iter() }.map(|bench| bench.record.turns());
    let slip = SLIP / turns.fold(f64::MIN_POSITIVE, f64::max);
    let orders = found.iter().filter_map(|one| match one.effects[..] {
        [
            Effect {
                site: Site::Torque,
                carrier: Carrier::Order(order),
                ..
            },
        ] if (order - order.round()).abs() <= slip => Some(order.round() as usize),
        _ => None,
    });
    let mut orders: Vec<usize> = orders.filter(|order| *order > 0).collect();
    orders.dedup();
    orders
}

/// Whether the disc is another one than the twins give: its edges are further off than they leave open, and all at once have more evidence
/// than the best cells together. The board with such a pattern.
pub fn another_disc(board: &Board, bank: &Bank, fit: &Fit, cells: usize) -> Option<Board> {
    let known = board.pattern.as_ref();
    if known.is_some_and(|pattern| !pattern.known) {
        return None;
    }
    let white = board.with_pattern(&board.rest(&fit.model));
    let mut pattern = Pattern::new(&board.benches)?;
    // A place of the disc is a finding of its own.
    pattern.sparse = false;
    let mut worth = pattern.size_up(&board.benches, &white);
    if known.is_some_and(|known| pattern.size2 <= known.size2) {
        return None;
    }
    if let Some(mut known) = known.cloned() {
        worth -= known.size_up(&board.benches, &white);
    }
    let worth = evidence(board, worth, 1);
    if worth < SURE || together(board, bank, fit, cells, worth) >= worth {
        return None;
    }
    let mut other = board.clone();
    other.pattern = Some(pattern);
    other.size_up(&fit.model);
    Some(other)
}

/// Evidence that some cells have together, each beside those before it, up to what is enough: what a few effects explain needs no disc.
/// Nor does what another size of the declared one explains.
pub fn together(board: &Board, bank: &Bank, fit: &Fit, cells: usize, enough: f64) -> f64 {
    let mut board = board.clone();
    let drawn = correct::of_disc(&board);
    let sized = drawn.iter().flat_map(|slopes| board.correct(slopes));
    let sized: Vec<Effect> = sized.collect();
    let mut sum = 0.0;
    let mut fit = fit.clone();
    if !sized.is_empty() {
        let model = fit.model.with(&sized, usize::MAX - 1);
        let next = board.fit(&model);
        let worth = evidence(&board, fit.rss - next.rss, sized.len());
        if worth >= SURE {
            (sum, fit) = (worth, next);
        }
    }
    let board = &board;
    for group in 0..cells {
        let found = candidates(board, bank, &fit);
        let Some(best) = found.first() else { break };
        let model = fit.model.with(&best.effects, usize::MAX - 2 - group);
        let next = board.fit(&model);
        let worth = evidence(board, fit.rss - next.rss, best.numbers());
        sum += worth.max(0.0);
        fit = next;
        // Those to come are worth less each.
        let most = sum + worth * (cells - 1 - group) as f64;
        if worth < SURE || sum >= enough || most < enough {
            break;
        }
    }
    sum
}

/// Effects with their evidence, and the place of the candidate that they come from among all.
type Worthy = (f64, Vec<Effect>, usize);

/// The next fit.
pub struct Next {
    /// Its evidence.
    pub worth: f64,
    /// It.
    pub fit: Fit,
    /// Place of what it has more among the candidates.
    pub from: usize,
}

/// A fit that something is missing in.
pub struct Beside<'a> {
    board: &'a Board,
    fit: &'a Fit,
    basis: Basis,
    /// What rounding to ticks alone would leave of the course as it is modelled, clear of the basis.
    spurs: Vec<f64>,
    precision: f64,
}

impl<'a> Beside<'a> {
    /// Of a fit.
    pub fn of(board: &'a Board, fit: &'a Fit) -> Self {
        let basis = fit.basis();
        let mut spurs = board.white(&board.rounded(&fit.model));
        basis.clear(&mut spurs);
        Self {
            board,
            fit,
            basis,
            spurs,
            precision: board.precision(),
        }
    }

    /// Whether what some columns explain is more than digits and rounding make of it.
    fn tells(&self, gain: f64, columns: impl FnOnce() -> Vec<Vec<f64>>) -> bool {
        gain > self.precision && self.basis.gain(&columns(), &self.spurs) < SPUR * gain
    }

    /// The fit with what of some candidates, strongest first, explains most. `open` is the group of what turns out to be no finding.
    pub fn next(&self, found: &[Candidate], open: usize) -> Option<Next> {
        let ranked = self.ranked(self.tried(found));
        ranked.into_iter().find_map(|(worth, effects, from)| {
            let (worth, fit) = self.entered(&self.varied(worth, effects), open)?;
            Some(Next { worth, fit, from })
        })
    }

    /// The first candidates that a machine can have, each fitted with everything else, of those that look nearly as good as the best.
    fn tried(&self, found: &[Candidate]) -> Vec<Worthy> {
        let board = self.board;
        let mut told = found.iter().enumerate().filter(|(_, one)| {
            let columns = || {
                let each = one.effects.iter();
                each.flat_map(|effect| board.columns(effect)).collect()
            };
            let course = board.undriven && one.effects.iter().any(is_course);
            !course && self.tells(one.gain, columns)
        });
        let mut tried = Vec::new();
        for _ in 0..TRIED {
            let few: Vec<(usize, &Candidate)> = told.by_ref().take(TRIED).collect();
            let most = few.first().map_or(0.0, |(_, best)| worth(board, best));
            let few = few.into_par_iter().filter(|(_, one)| {
                let here = worth(board, one);
                here >= PROMISING * SURE && here >= NEARLY * most
            });
            let fitted = few.map(|(from, one)| {
                let (effects, gain) = board.beside(self.fit, &self.basis, &one.effects);
                (gain, (evidence(board, gain, one.numbers()), effects, from))
            });
            let gains: Vec<f64>;
            (gains, tried) = fitted.unzip();
            if tried.is_empty() || gains.iter().any(|gain| *gain > 0.0) {
                break;
            }
        }
        tried
    }

    /// Some effects by their evidence, best first. What has no name, and what only shows in a disc that the twins do not give, comes after
    /// what has one or shows elsewhere and is about as good, and a run-out after a torque that is as good, or a width after a delay beside
    /// a disc that has both in it. Where a good part of what counts as noise is explained, each is seen beside the noise that it leaves.
    fn ranked(&self, mut tried: Vec<Worthy>) -> Vec<Worthy> {
        let board = self.board;
        let delays_open = !past_learned(board).is_empty();
        let late = |effects: &[Effect]| {
            let image = effects.iter().any(|effect| board.is_image(effect));
            let nameless = board.mechanism(effects) == Mechanism::Unknown;
            let is_tied = |effect: &Effect| match (effect.site, effect.carrier) {
                (Site::Disc(_), Carrier::Order(order)) => order.fract() != 0.0,
                // Up to how it goes with the speed, which is open, a delay is the same.
                (Site::Disc(_), Carrier::Steady) => delays_open,
                _ => false,
            };
            if image || nameless || is_open(board, effects) {
                ALIKE
            } else if effects.iter().any(is_tied) {
                TIED
            } else {
                0.0
            }
        };
        let worth = |one: &Worthy| one.0 - late(&one.1);
        tried.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
        let most = tried.first().map_or(0.0, |best| best.0);
        let near = tried.into_iter().partition(|one| one.0 > NEARLY * most);
        let (mut near, rest): (Vec<Worthy>, Vec<Worthy>) = near;
        if near.len() > 1 && most > LOUD * self.fit.rss {
            let lost = near.into_par_iter().map(|one| {
                let model = self.fit.model.with(&one.1, usize::MAX - 1);
                (board.at_its_noise(&model).2 + late(&one.1), one)
            });
            let mut lost: Vec<(f64, Worthy)> = lost.collect();
            lost.sort_by(|a, b| a.0.total_cmp(&b.0));
            near = lost.into_iter().map(|(_, one)| one).collect();
        }
        near.into_iter().chain(rest).collect()
    }

    /// Effects as they are better: what grows, or is no sine, is no row of lines beside each other.
    fn varied(&self, worth: f64, effects: Vec<Effect>) -> Vec<Effect> {
        let mut varied = cells::grown(self.board, &effects);
        varied.extend(cells::harmonics(self.board, &effects));
        let varied = varied.into_par_iter().map(|effects| {
            let (effects, gain) = self.board.beside(self.fit, &self.basis, &effects);
            let numbers = cells::numbers(&effects);
            (evidence(self.board, gain, numbers), effects)
        });
        match varied.max_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((better, varied)) if better > worth + SURE => varied,
            _ => effects,
        }
    }

    /// The fit with some effects, as a finding or as what the twins leave open, and its evidence, if it is enough.
    fn entered(&self, effects: &[Effect], open: usize) -> Option<(f64, Fit)> {
        let board = self.board;
        let worth = |next: Fit| {
            let gain = self.fit.rss - next.rss;
            let worth = evidence(board, gain, cells::numbers(effects));
            (worth > SURE).then_some((worth, next))
        };
        if !is_open(board, effects) {
            let (group, mut model) = joined(&self.fit.model, effects, cells::channels(board));
            model.add_open(&own_errors(board, &model, effects), group);
            let next = board.fit(&model);
            let drags = board.undriven && effects.iter().all(Effect::is_friction);
            // What does not recur is what a drive that nobody declared did there, and a little of what counts as noise is how it goes on.
            let shows = self.fit.rss - next.rss > LOUD * self.fit.rss;
            if !drags || shows && judge::recurs(board, &next, group) {
                return worth(next).filter(|(_, next)| board.can_be(&next.model));
            }
        }
        let mut model = self.fit.model.clone();
        model.add_open(&left_open(board, effects), open);
        worth(board.fit(&model))
    }

    /// The declared number that explains most, if it has so much evidence: the board beside twins with it, and the fit.
    pub fn corrected(&self, slopes: &[Slopes], least: f64) -> Option<(Board, Fit)> {
        let (board, fit) = (self.board, self.fit);
        let least = least.max(SURE);
        let mut cleared = fit.clone();
        self.basis.clear(&mut cleared.left);
        let mut best: Option<(f64, Board, Fit)> = None;
        let candidates = correct::candidates(board, slopes, &cleared, &self.basis);
        for candidate in candidates.into_iter().take(TRIED) {
            let numbers = candidate.slopes.declared.len();
            if evidence(board, candidate.gain, numbers) < PROMISING * least {
                break;
            }
            if !self.tells(candidate.gain, || candidate.slopes.white(board)) {
                continue;
            }
            let mut wider = board.clone();
            let effects = wider.correct(candidate.slopes);
            let knob = &candidate.slopes.knob;
            let group = board.group_of(&fit.model, knob, fit.model.unused());
            let (better, tried, gain) = wider.settle(&fit.model.with(&effects, group), fit);
            let here = evidence(board, gain, numbers);
            let most = best.as_ref().map_or(least, |(most, ..)| *most);
            // A twin that can't be is none.
            if better.is_possible() && here > most {
                best = Some((here, better, tried));
            }
        }
        best.map(|(_, board, fit)| (board, fit))
    }
}
