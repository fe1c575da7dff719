//! One search: the best cell is added, all numbers are fitted together, what is no longer worth its numbers is dropped, until nothing
//! changes.

mod best;
mod classes;
mod open;

use rayon::prelude::*;

pub use best::{ALIKE, candidates, together, torque_orders, worth};
pub use classes::joins;
pub use open::{nuisances, past_learned, with};

use best::{Beside, LOUD, NEARLY, TRIED, another_disc};
use open::CHANGES;

use super::agreement;
use super::cells::{self, Bank};
use super::correct::{self, Slopes};
use super::disc;
use super::effect::{Carrier, Effect, Growth, Site};
use super::identify;
use super::jury;
use super::model::{Board, Fit, Model, Term};
use super::plant::Law;
pub use super::scan::{SURE, evidence};
use super::task;

/// How often a search goes on in other noise at the most.
const TRIALS: usize = 3;
/// Findings at the most.
pub const FINDINGS: usize = 7;
/// Rounds in which the course and what shifts edges are found, as each bears on the other.
const COURSES: usize = 3;
/// Part of another finding's evidence that a torque has to have beside a drive of which nothing says how stiffly it holds the shaft.
const HELD: f64 = 0.25;
/// Findings that are put elsewhere at the most, after one has been added.
const EXCHANGES: usize = 4;

/// What a search found.
#[derive(Clone, Debug)]
pub struct Found {
    /// The model with its numbers.
    pub fit: Fit,
    /// Cells that were tried throughout.
    pub bank: Bank,
    /// What the twins declare and the recordings do not determine, in words.
    pub not_identifiable: Vec<String>,
    /// Evidence of each group in noise of any kind.
    pub worth: Vec<(usize, f64)>,
    /// Evidence that the noise is not white, normal and the same throughout.
    pub noise: f64,
}

/// Searches until nothing is left that is worth its numbers, in noise of any kind.
#[must_use]
pub fn search(board: &mut Board) -> Found {
    let mut found = Found {
        bank: Bank::new(board),
        fit: board.fit(&nuisances(board)),
        not_identifiable: Vec::new(),
        worth: Vec::new(),
        noise: 0.0,
    };
    found.add_in_any_noise(board);
    found
}

impl Found {
    /// Sizes of what was found by a board of more edges of the same recordings, in noise of any kind.
    pub fn settle(&mut self, board: &mut Board) {
        self.fit = board.fit_in_noise(&self.fit.model);
        self.prune(board);
    }

    /// Sizes of what was found beside how stiffly an unknown drive holds the shaft as it is likeliest.
    pub fn hold(&mut self, board: &mut Board) {
        if board.hold_at_last(&self.fit.model) {
            self.fit = along(board, &self.fit.model);
        }
    }

    /// Goes on with a board of other edges of the same recordings. Whether that finds something else.
    pub fn go_on(&mut self, board: &mut Board) -> bool {
        let effects = |fit: &Fit| -> Vec<Effect> {
            let each = fit.model.groups().into_iter();
            each.flat_map(|group| fit.model.effects(group)).collect()
        };
        let before = effects(&self.fit);
        // Of a place of the disc some edges show too little to tell which ones are off.
        let of_place = |effect: &Effect| matches!(effect.carrier, Carrier::Bump(..));
        let terms = &mut self.fit.model.terms;
        terms.retain(|term| !of_place(&term.effect));
        self.settle(board);
        self.bank = Bank::new(board);
        self.add(board);
        let after = effects(&self.fit);
        let known = |effect: &Effect| before.iter().any(|one| board.is_same(one, effect));
        let changed =
            after.len() != before.len() || !after.iter().all(known) || after.iter().any(of_place);
        if changed {
            self.add_in_any_noise(board);
        }
        changed
    }

    /// Adds findings and judges them in noise of any kind, until neither finds anything.
    fn add_in_any_noise(&mut self, board: &mut Board) {
        for trial in 1..=TRIALS {
            if task::find(board, &self.fit) {
                self.bank = Bank::new(board);
                self.fit = board.fit(&self.fit.model);
            }
            self.add(board);
            let judged = jury::judge(board, &mut self.fit, trial < TRIALS);
            self.worth = judged.worth;
            self.noise += judged.noise;
            if !judged.changed {
                break;
            }
            self.bank = Bank::new(board);
        }
    }

    /// Adds findings until nothing is left that is worth its numbers.
    fn add(&mut self, board: &mut Board) {
        // Worked out where something is left that they may explain.
        let mut slopes: Option<Vec<Slopes>> = None;
        // What does not stay beside the fit as it is: candidates, and another declared number.
        let (mut refused, mut fixed) = (Vec::new(), false);
        let (mut findings, mut changes) = (self.fit.model.groups().len(), 0);
        while findings < FINDINGS && changes < CHANGES {
            let mut found = candidates(board, &self.bank, &self.fit);
            found.retain(|one| !refused.contains(&one.effects));
            let most = found.first().map_or(0.0, |best| worth(board, best));
            // A disc is looked for first of all, and where nothing else is left.
            if (most < SURE || self.fit.model.groups().is_empty())
                && let Some(other) = another_disc(board, &self.bank, &self.fit, FINDINGS - findings)
            {
                *board = other;
                self.bank = Bank::new(board);
                self.fit = board.fit(&self.fit.model);
                prune(board, &mut self.fit);
                continue;
            }
            let beside = Beside::of(board, &self.fit);
            let next = beside.next(&found, usize::MAX - 2 - changes);
            // What the twin declares comes first, if it explains as much.
            let least = next.as_ref().map_or(SURE, |next| next.worth - ALIKE);
            let left = next.is_some() || !agreement::is_white(board, &self.fit);
            let slopes_now = left.then(|| slopes.get_or_insert_with(|| correct::all(board)));
            let corrected = slopes_now
                .filter(|_| !fixed)
                .and_then(|slopes| beside.corrected(slopes, least));
            let mut moved = false;
            let before = (board.clone(), self.fit.clone(), findings);
            let from = next.as_ref().map(|next| next.from);
            let from = from.filter(|_| corrected.is_none());
            if let Some((better, fit)) = corrected {
                moved = laws(board) != laws(&better);
                findings += 1;
                *board = better;
                self.fit = fit;
                self.fit_in_noise(board);
            } else if let Some(next) = next {
                let open = |fit: &Fit| fit.model.nuisances().terms.len();
                let is_open = open(&next.fit) > open(&self.fit);
                self.fit = next.fit;
                self.fit_in_noise(board);
                if is_open {
                    changes += 1;
                } else {
                    findings += 1;
                    exchange(board, &mut self.fit);
                }
            } else {
                break;
            }
            moved |= bend(board, &mut self.fit);
            moved |= self.take_other_flank(board);
            if moved {
                self.bank = Bank::new(board);
                slopes = None;
            }
            // What another one has made superfluous.
            self.prune(board);
            // A finding that goes again leaves the noise as it was beside it.
            if board.lost(&self.fit) < before.0.lost(&before.1) {
                refused.clear();
                fixed = false;
                continue;
            }
            (*board, self.fit, findings) = before;
            if moved {
                self.bank = Bank::new(board);
            }
            match from {
                Some(from) => refused.push(found.swap_remove(from).effects),
                None => fixed = true,
            }
            if refused.len() > TRIED {
                break;
            }
        }
        // What does not show goes by the noise as it was found.
        if let Some(slopes) = slopes {
            let plain = board.fit(&self.fit.model.nuisances());
            self.not_identifiable = identify::open(board, &slopes, &plain);
        }
    }

    /// Takes off what is no longer worth its numbers, another disc than the twins give as well.
    fn prune(&mut self, board: &mut Board) {
        if disc::other(board, &self.fit).is_some_and(|other| other.worth < SURE) {
            board.pattern = board.pattern_given();
            self.fit = board.fit_in_noise(&self.fit.model);
        }
        prune(board, &mut self.fit);
    }

    /// Fits what a speed loop saw and the noise to what is left, and all numbers in it.
    fn fit_in_noise(&mut self, board: &mut Board) {
        board.decide_ties(&self.fit.model);
        self.fit = board.fit_in_noise(&self.fit.model);
    }

    /// Takes delays of one flank for less delay of the other where that explains more: the edges look the same but for what goes by when
    /// the shaft passed them. Whether it does.
    fn take_other_flank(&mut self, board: &mut Board) -> bool {
        let mut model = self.fit.model.clone();
        let mut any = false;
        for term in &mut model.terms {
            if let Site::Stamp(on) = &mut term.effect.site
                && let Some(rises) = &mut on.rises
            {
                *rises = !*rises;
                term.sizes.iter_mut().for_each(|size| *size = -*size);
                any = true;
            }
        }
        let mut other = board.clone();
        if !any || !other.go_by(&model) {
            return false;
        }
        let fit = other.fit_in_noise(&model);
        let better = other.lost(&fit) < board.lost(&self.fit) - SURE;
        if better {
            (*board, self.fit) = (other, fit);
        }
        better
    }
}

/// Takes off all that was found where the twins as they are given explain the recordings about as well: two findings may each be what the
/// other one asks for. Whether they do.
pub fn needless(given: &Board, board: &mut Board, found: &mut Found) -> bool {
    if found.fit.model.groups().is_empty() && disc::other(board, &found.fit).is_none() {
        return false;
    }
    let (plain, fit, lost) = agreement::as_given(given, board).at_its_noise(&nuisances(given));
    let needless = lost < board.lost(&found.fit) + SURE;
    if needless {
        (*board, found.fit) = (plain, fit);
        found.bank = Bank::new(board);
        found.worth.clear();
    }
    needless
}

/// A model's fit along another course, in noise that goes by sizes beside that.
fn along(board: &mut Board, model: &Model) -> Fit {
    let fit = board.fit(model);
    board.fit_in_noise(&fit.model)
}

/// Works out the course anew beside what was found, and, as long as that makes the recordings likelier, where an unknown drive has
/// corners and how stiffly it holds the shaft. Whether that is anything else than before.
pub fn bend(board: &mut Board, fit: &mut Fit) -> bool {
    let mut moved = false;
    for _ in 0..COURSES {
        let shifted = board.go_by(&fit.model);
        if shifted {
            *fit = along(board, &fit.model);
        }
        moved |= shifted;
        let mut other = board.clone();
        let bent = other.find_corners(&fit.model);
        if bent {
            other.hold_by_noise(&fit.model);
        }
        if other.hold(&fit.model) | bent {
            let next = along(&mut other, &fit.model);
            if other.lost(&next) >= board.lost(fit) {
                break;
            }
            (*board, *fit) = (other, next);
            moved = true;
        } else if !shifted {
            break;
        }
    }
    moved
}

/// How the shaft of each recording answers.
fn laws(board: &Board) -> Vec<Law> {
    let each = board.benches.iter();
    each.map(|bench| bench.plant.law.clone()).collect()
}

/// Puts each finding of one frequency where it explains most beside the others: what was taken for it while they were still missing may be
/// another site's, or an order's where it is a frequency.
fn exchange(board: &mut Board, fit: &mut Fit) {
    for _ in 0..EXCHANGES {
        let loose = board.is_loose();
        let groups = fit.model.groups();
        let each = groups.into_par_iter().flat_map(|group| {
            let rest = fit.without(group);
            let basis = rest.basis();
            let worth = evidence(board, rest.rss - fit.rss, fit.model.numbers(group));
            let loud = worth > LOUD * fit.rss;
            let rivals = cells::elsewhere(board, &fit.model.effects(group), loud);
            let fitted = rivals.into_par_iter().map(|effects| {
                let (effects, gain) = board.beside(&rest, &basis, &effects);
                let model = with(board, &rest.model, &effects, group);
                let here = evidence(board, gain, cells::numbers(&effects));
                let pushes = effects.iter().any(|effect| effect.site.pushes());
                let least = match loud {
                    _ if pushes && loose => HELD,
                    true => NEARLY,
                    // What is no large part of the noise leaves it as it is.
                    false => 1.0,
                };
                (here / worth, least, model)
            });
            fitted.collect::<Vec<_>>()
        });
        let near = each.filter(|(share, least, _)| share > least);
        let mut near: Vec<(f64, Model)> = near.map(|(share, _, model)| (share, model)).collect();
        near.sort_by(|a, b| b.0.total_cmp(&a.0));
        near.truncate(TRIED);
        let now = board.lost(fit);
        let rivals = near.into_par_iter().map(|(_, model)| {
            let mut other = board.clone();
            if loose {
                other.hold(&model);
            }
            other.at_its_noise(&model)
        });
        let best = rivals.collect::<Vec<_>>().into_iter();
        let best = best.min_by(|a, b| a.2.total_cmp(&b.2));
        match best.filter(|best| best.2 < now - SURE) {
            Some(best) => (*board, *fit, _) = best,
            None => break,
        }
    }
}

/// Takes off a fit what is no longer worth its numbers: groups, and orders of a family.
pub fn prune(board: &Board, fit: &mut Fit) {
    while let Some(model) = dropped(board, fit) {
        *fit = board.fit(&model);
    }
}

/// A model without the first group that is not worth its numbers, or an order of a family that is not; none where all are.
fn dropped(board: &Board, fit: &Fit) -> Option<Model> {
    let terms = &fit.model.terms;
    for group in fit.model.groups() {
        let own = fit.model.only(group);
        let worth = evidence(board, fit.loss(group), fit.model.numbers(group));
        if worth < SURE || !board.can_be(&own) || !board.is_near(&fit.model, group) {
            return Some(fit.model.without(group));
        }
        let own_terms = (0..terms.len()).filter(|at| terms[*at].group == group);
        if let Some(model) = { own_terms.clone() }.find_map(|at| flat(board, fit, at)) {
            return Some(model);
        }
        let order = |term: &Term| {
            let carrier = term.effect.carrier;
            term.effect.site == Site::Torque && matches!(carrier, Carrier::Order(_))
        };
        if own.terms.len() < 2 || !own.terms.iter().all(order) {
            continue;
        }
        // A family has the orders that show, and not those between them.
        let losses = own_terms.map(|at| (fit.loss_of(&|term| term == at), at));
        let least = losses.min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((loss, at)) = least
            && evidence(board, loss, terms[at].effect.sizes()) < 0.0
        {
            let mut model = fit.model.clone();
            model.terms.remove(at);
            return Some(model);
        }
    }
    None
}

/// The model with a term of constant size, if how it goes with time or speed is not worth its number. At a place of a free disc what is
/// constant is the disc's, so that a small power may be all that shows.
fn flat(board: &Board, fit: &Fit, at: usize) -> Option<Model> {
    let effect = &fit.model.terms[at].effect;
    let (Growth::Even(rate) | Growth::Speed(rate)) = effect.growth else {
        return None;
    };
    let number = effect.sizes() + effect.knobs().len() - 1;
    let variance = fit.column(at, number).map(|at| fit.covariance[(at, at)])?;
    let mut model = fit.model.clone();
    model.terms[at].effect.growth = Growth::Constant;
    let is_flat = evidence(board, rate.powi(2) / variance, 1) < 0.0
        && evidence(board, board.fit(&model).rss - fit.rss, 1) < 0.0;
    is_flat.then_some(model)
}
