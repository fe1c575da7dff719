//! One search: the best cell is added, all numbers are fitted together, what is no longer worth its numbers is dropped, until nothing
//! changes.

use rayon::prelude::*;

use super::agreement;
use super::cells::{self, Bank};
use super::correct::{self, Slopes};
use super::effect::{Carrier, Effect, Growth, On, Site};
use super::identify;
use super::judge;
use super::jury;
use super::lsq::Basis;
use super::model::{Board, Fit, Model, Term, pushes};
use super::name;
use super::nearby::Left;
use super::pattern::Pattern;
use super::plant::Law;
use super::scan::{self, Candidate};
pub use super::scan::{SURE, evidence};
use super::task;
use crate::mechanism::Mechanism;

/// How often a search goes on in other noise at the most.
const TRIALS: usize = 3;
/// Findings at the most, and changes of a drive that the twins do not declare.
const FINDINGS: usize = 7;
const CHANGES: usize = 16;
/// Part of what a candidate explains that rounding to ticks alone may make.
const SPUR: f64 = 0.25;
/// Candidates that are fitted with everything else until one is worth it.
const TRIED: usize = 4;
/// Part of the best one's evidence that another one has to have to be fitted too.
const NEARLY: f64 = 0.8;
/// Evidence by which a new effect has to be better than a correction of what the twin declares.
const ALIKE: f64 = 10.0;
/// Part of what counts as noise that has to be explained for the noise to be another one without it.
const LOUD: f64 = 0.05;
/// Rounds in which the course and what shifts edges are found, as each bears on the other.
const COURSES: usize = 3;
/// Findings that are put elsewhere at the most, after one has been added.
const EXCHANGES: usize = 4;
/// Orders of a disc that may be as large as they like: what is off the centre, tilted or bent moves all edges of a part of the turn.
const LOW: i64 = 8;

/// What nobody knows of any rig: the mean speed that an open-loop drive holds. Of a disc that the twins do not give, how far edges of a
/// class are off.
#[must_use]
pub fn nuisances(board: &Board) -> Model {
    let mut model = Model::default();
    if !board.disc_given {
        model.add(&cells::classes(board), usize::MAX);
        let edges = board.benches.iter().map(|bench| bench.record.edges).min();
        let orders = (1..=LOW).filter(|order| 16 * order < edges.unwrap_or(0));
        let orders =
            orders.map(|order| Effect::new(Site::Disc(On::ALL), Carrier::Order(order as f64)));
        model.add(&orders.collect::<Vec<_>>(), usize::MAX);
    }
    let steady = board
        .benches
        .iter()
        .any(|bench| bench.is_held() && bench.plant.law.mode.is_none());
    if steady {
        model.add(&[Effect::new(Site::Drive, Carrier::Steady)], usize::MAX);
    }
    if board.undriven {
        model.add(&turns_back(board), usize::MAX);
    }
    model.terms.iter_mut().for_each(|term| term.nuisance = true);
    model
}

/// A drive that the twins do not declare may turn back as suddenly as it likes, which looks like friction; where it does so often, only
/// friction does every time.
fn turns_back(board: &Board) -> Vec<Effect> {
    let several = board.benches.len() > 1;
    let each = board.benches.iter().flat_map(|bench| {
        let at = bench.course.reversals_s.iter();
        at.map(move |at_s| Effect {
            only: several.then_some(bench.place),
            ..Effect::new(Site::Drive, Carrier::Window(*at_s, f64::INFINITY))
        })
    });
    let all: Vec<Effect> = each.collect();
    if all.len() > CHANGES { Vec::new() } else { all }
}

/// Whether the disc is another one than the twins give: all of its edges at once have more evidence than the best cells together. The
/// board with such a pattern.
fn another_disc(board: &Board, bank: &Bank, fit: &Fit, cells: usize) -> Option<Board> {
    let known = board.pattern.as_ref();
    if known.is_some_and(|pattern| !pattern.known) {
        return None;
    }
    let white = board.with_pattern(&board.rest(&fit.model));
    let mut pattern = Pattern::new(&board.benches)?;
    // A place of the disc is a finding of its own.
    pattern.sparse = false;
    let mut worth = pattern.size_up(&board.benches, &white);
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
fn together(board: &Board, bank: &Bank, fit: &Fit, cells: usize, enough: f64) -> f64 {
    let mut fit = fit.clone();
    let mut sum = 0.0;
    for group in 0..cells {
        let found = candidates(board, bank, &fit);
        let best = found.first();
        let Some(best) = best else { break };
        let mut model = fit.model.clone();
        model.add(&best.effects, usize::MAX - 2 - group);
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
    all.sort_by(|a, b| {
        evidence(board, b.gain, b.numbers()).total_cmp(&evidence(board, a.gain, a.numbers()))
    });
    all
}

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
        board.fit_noise(&self.fit.model);
        self.fit = board.fit(&self.fit.model);
        prune(board, &mut self.fit);
    }

    /// Goes on with a board of other edges of the same recordings. Whether that finds something else.
    pub fn go_on(&mut self, board: &mut Board) -> bool {
        let effects = |fit: &Fit| -> Vec<Effect> {
            let each = fit.model.groups().into_iter();
            each.flat_map(|group| fit.model.effects(group)).collect()
        };
        let before = effects(&self.fit);
        let mut model = std::mem::take(&mut self.fit.model);
        // Of a place of the disc some edges show too little to tell which ones are off.
        let of_place = |effect: &Effect| matches!(effect.carrier, Carrier::Bump(..));
        model.terms.retain(|term| !of_place(&term.effect));
        board.fit_noise(&model);
        self.fit = board.fit(&model);
        prune(board, &mut self.fit);
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
        let Self {
            bank,
            fit,
            not_identifiable,
            ..
        } = self;
        // Worked out where something is left that they may explain.
        let mut slopes: Option<Vec<Slopes>> = None;
        let (mut findings, mut changes) = (fit.model.groups().len(), 0);
        while findings < FINDINGS && changes < CHANGES {
            let group = fit.model.unused();
            let found = candidates(board, bank, fit);
            // The best one as fitted with everything else, of those that look nearly as good.
            let most = found
                .first()
                .map_or(0.0, |best| evidence(board, best.gain, best.numbers()));
            let first_or_last = fit.model.groups().is_empty() || most < SURE;
            if let Some(other) = first_or_last
                .then(|| another_disc(board, bank, fit, FINDINGS - findings))
                .flatten()
            {
                *board = other;
                *bank = Bank::new(board);
                *fit = board.fit(&fit.model);
                prune(board, fit);
                continue;
            }
            let basis = fit.basis();
            let precision = board.precision();
            let mut spurs = board.spurs(&fit.model);
            basis.clear(&mut spurs);
            let mut told = found
                .iter()
                .filter(|candidate| candidate.gain > precision)
                .filter(|candidate| !board.undriven || !candidate.effects.iter().any(is_course))
                .filter(|candidate| !is_spur(board, candidate, &basis, &spurs));
            let mut tried: Vec<(f64, Vec<Effect>)> = Vec::new();
            // Those that no machine can have leave it to the next ones.
            for _ in 0..TRIED {
                let few: Vec<&Candidate> = told.by_ref().take(TRIED).collect();
                let worth = |one: &Candidate| evidence(board, one.gain, one.numbers());
                let most = few.first().map_or(0.0, |best| worth(best));
                let few = few.into_par_iter().filter(|candidate| {
                    let here = worth(candidate);
                    here >= 0.7 * SURE && here >= NEARLY * most
                });
                let fitted = few.map(|candidate| {
                    let (effects, gain) = board.beside(fit, &basis, &candidate.effects);
                    (evidence(board, gain, candidate.numbers()), gain, effects)
                });
                let fitted: Vec<(f64, f64, Vec<Effect>)> = fitted.collect();
                let possible = fitted.iter().any(|(_, gain, _)| *gain > 0.0);
                tried = fitted
                    .into_iter()
                    .map(|(worth, _, effects)| (worth, effects))
                    .collect();
                if possible || tried.is_empty() {
                    break;
                }
            }
            let best = best_of(board, fit, tried).map(|(worth, effects)| {
                // What grows, or is no sine, is no row of lines beside each other.
                let mut varied = cells::grown(board, &effects);
                varied.extend(cells::harmonics(board, &effects));
                let grown = varied.into_par_iter().map(|effects| {
                    let (effects, gain) = board.beside(fit, &basis, &effects);
                    (evidence(board, gain, cells::numbers(&effects)), effects)
                });
                let grown = grown.max_by(|a, b| a.0.total_cmp(&b.0));
                match grown {
                    Some((better, grown)) if better > worth + SURE => grown,
                    _ => effects,
                }
            });
            let next = best.and_then(|effects| {
                let numbers = cells::numbers(&effects);
                let as_open = |effects: &[Effect]| {
                    let mut model = fit.model.clone();
                    model.add_open(&left_open(board, effects), usize::MAX - 2 - changes);
                    let next = board.fit(&model);
                    let worth = evidence(board, fit.rss - next.rss, numbers);
                    (worth > SURE).then_some((worth, next))
                };
                if is_open(board, &effects) {
                    return as_open(&effects);
                }
                let drags = board.undriven && effects.iter().all(Effect::is_friction);
                let (group, rest, effects) =
                    joined(&fit.model, group, effects, cells::channels(board));
                let mut model = rest;
                model.add(&effects, group);
                let next = board.fit(&model);
                let worth = evidence(board, fit.rss - next.rss, numbers);
                if drags && !judge::recurs(board, &next, group) {
                    // What a drive that nobody declared did there.
                    return as_open(&effects);
                }
                (worth > SURE && board.can_be(&next.model)).then_some((worth, next))
            });
            // What the twin declares comes first, if it explains as much.
            let least = next.as_ref().map_or(SURE, |(best, _)| best - ALIKE);
            let left = next.is_some() || !agreement::is_white(board, fit);
            let declared = left.then(|| slopes.get_or_insert_with(|| correct::all(board)));
            let told = |gain: f64, columns: &[Vec<f64>]| {
                gain > precision && basis.gain(columns, &spurs) < SPUR * gain
            };
            let corrected =
                declared.and_then(|slopes| correction(board, slopes, fit, group, least, &told));
            if let Some((better, corrected)) = corrected {
                let laws = |board: &Board| -> Vec<Law> {
                    let each = board.benches.iter();
                    each.map(|bench| bench.plant.law.clone()).collect()
                };
                let answers_alike = laws(board) == laws(&better);
                *board = better;
                *fit = corrected;
                board.decide_ties(&fit.model);
                board.fit_noise(&fit.model);
                *fit = board.fit(&fit.model);
                if !answers_alike {
                    *bank = Bank::new(board);
                    slopes = None;
                }
                findings += 1;
            } else if let Some((_, next)) = next {
                let before = fit.model.nuisances().terms.len();
                let open = next.model.nuisances().terms.len() > before;
                board.decide_ties(&next.model);
                board.fit_noise(&next.model);
                *fit = board.fit(&next.model);
                if open {
                    changes += 1;
                } else {
                    findings += 1;
                    exchange(board, fit);
                }
            } else {
                break;
            }
            let mut moved = false;
            for _ in 0..COURSES {
                let shifted = board.go_by(&fit.model);
                if !board.hold(&fit.model) && !shifted {
                    break;
                }
                moved = true;
                *fit = board.fit(&fit.model);
                board.fit_noise(&fit.model);
                *fit = board.fit(&fit.model);
            }
            if moved {
                *bank = Bank::new(board);
                slopes = None;
            }
            // What another one has made superfluous.
            prune(board, fit);
        }
        // What does not show goes by the noise as it was found.
        let plain = board.fit(&fit.model.nuisances());
        if let Some(slopes) = slopes {
            *not_identifiable = identify::open(board, &slopes, &plain);
        }
    }
}

/// Puts each finding of one frequency where it explains most beside the others: what was taken for it while they were still missing may be
/// another site's, or an order's where it is a frequency.
fn exchange(board: &mut Board, fit: &mut Fit) {
    for _ in 0..EXCHANGES {
        let groups = fit.model.groups();
        let each = groups.into_par_iter().flat_map(|group| {
            let rest = fit.without(group);
            let basis = rest.basis();
            let worth = evidence(board, rest.rss - fit.rss, fit.model.numbers(group));
            let loud = worth > LOUD * fit.rss;
            let rivals = cells::elsewhere(board, &fit.model.effects(group), loud);
            let fitted = rivals.into_par_iter().map(|effects| {
                let (effects, gain) = board.beside(&rest, &basis, &effects);
                let mut model = fit.model.without(group);
                if is_open(board, &effects) {
                    model.add_open(&left_open(board, &effects), group);
                } else {
                    model.add(&effects, group);
                }
                (
                    evidence(board, gain, cells::numbers(&effects)) / worth,
                    model,
                )
            });
            fitted.collect::<Vec<_>>()
        });
        let mut near: Vec<(f64, Model)> = each.filter(|(share, _)| *share > NEARLY).collect();
        near.sort_by(|a, b| b.0.total_cmp(&a.0));
        near.truncate(TRIED);
        let now = board.lost(fit);
        let rivals = near
            .into_par_iter()
            .map(|(_, model)| board.at_its_noise(&model));
        let rivals: Vec<(Board, Fit, f64)> = rivals.collect();
        let best = rivals.into_iter().min_by(|a, b| a.2.total_cmp(&b.2));
        match best.filter(|best| best.2 < now - SURE) {
            Some(best) => (*board, *fit, _) = best,
            None => break,
        }
    }
}

/// The declared number that explains most beside a fit, if it has so much evidence: the board beside twins with it, and the fit.
fn correction(
    board: &Board,
    slopes: &[Slopes],
    fit: &Fit,
    free: usize,
    least: f64,
    told: &dyn Fn(f64, &[Vec<f64>]) -> bool,
) -> Option<(Board, Fit)> {
    let basis = fit.basis();
    let mut cleared = fit.clone();
    basis.clear(&mut cleared.left);
    let mut best: Option<(f64, Board, Fit)> = None;
    for candidate in correct::candidates(board, slopes, &cleared, &basis)
        .into_iter()
        .take(TRIED)
    {
        let numbers = candidate.slopes.declared.len();
        let here = evidence(board, candidate.gain, numbers);
        if here < 0.7 * SURE.max(least) {
            break;
        }
        if !told(candidate.gain, &candidate.slopes.white(board)) {
            continue;
        }
        let mut wider = board.clone();
        let effects = wider.correct(candidate.slopes);
        let mut model = fit.model.clone();
        let group = board.group_of(&model, &candidate.slopes.knob, free);
        model.add(&effects, group);
        let (better, tried, gain) = wider.settle(&model, fit);
        // A twin that can't be is none.
        if !better.is_possible() {
            continue;
        }
        let here = evidence(board, gain, numbers);
        if here > least.max(SURE) && best.as_ref().is_none_or(|(most, ..)| here > *most) {
            best = Some((here, better, tried));
        }
    }
    best.map(|(_, board, fit)| (board, fit))
}

/// The best of some effects by their evidence. What only shows in a disc that the twins do not give comes after what shows elsewhere and is
/// about as good. Where a good part of what counts as noise is explained, each is seen beside the noise that it leaves.
fn best_of(
    board: &Board,
    fit: &Fit,
    mut tried: Vec<(f64, Vec<Effect>)>,
) -> Option<(f64, Vec<Effect>)> {
    let late = |effects: &[Effect]| {
        let image = effects.iter().any(|effect| board.is_image(effect));
        if image || is_open(board, effects) {
            ALIKE
        } else {
            0.0
        }
    };
    let worth = |one: &(f64, Vec<Effect>)| one.0 - late(&one.1);
    tried.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
    let most = tried.first()?.0;
    let mut near = tried.clone();
    near.retain(|one| one.0 > NEARLY * most);
    if near.len() > 1 && most > LOUD * fit.rss {
        let group = usize::MAX - 1;
        let each = near.into_par_iter().map(|one| {
            let mut model = fit.model.clone();
            model.add(&one.1, group);
            let (_, _, lost) = board.at_its_noise(&model);
            (lost + late(&one.1), one)
        });
        return each.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, one)| one);
    }
    tried.into_iter().next()
}

/// Whether effects are of what the twins leave open, and so no findings: a drive that they do not declare may change at any instant, and
/// gives way with the speed as friction does where that hardly changes; a disc that they do not give may have any errors.
fn is_open(board: &Board, effects: &[Effect]) -> bool {
    let open_disc = !board.disc_given;
    let drags = board.undriven && board.speed_spread() < cells::SPEEDS;
    if drags && effects.iter().all(Effect::is_friction) {
        return true;
    }
    effects.iter().all(|effect| {
        let changes = pushes(effect.site) && matches!(effect.carrier, Carrier::Window(..));
        board.undriven && changes || open_disc && effect.is_of_disc()
    })
}

/// Whether an effect is an angle that swings more slowly than the shaft turns, as its course does under a drive of which nothing is known.
fn is_course(effect: &Effect) -> bool {
    let slow = matches!(effect.carrier, Carrier::Order(order) if order < 1.0);
    slow && matches!(effect.site, Site::Disc(_))
}

/// Effects of what the twins leave open as they enter: a torque of an unknown drive makes the course, which nothing damps.
fn left_open(board: &Board, effects: &[Effect]) -> Vec<Effect> {
    let each = effects.iter().map(|effect| match effect.site {
        Site::Torque if board.undriven => Effect {
            site: Site::Drive,
            ..*effect
        },
        _ => *effect,
    });
    each.collect()
}

/// Steady effects of edge classes that a finding has in part already are one finding with it, channel by channel: its group, the model
/// without it, and all of its effects. Falls of a channel whose rises it has are another one, of the channel.
fn joined(
    model: &Model,
    group: usize,
    effects: Vec<Effect>,
    channels: u8,
) -> (usize, Model, Vec<Effect>) {
    let Some(other) = joins(model, &effects) else {
        return (group, model.clone(), effects);
    };
    let each = |effects: Vec<Effect>| {
        let each = effects.into_iter();
        each.flat_map(move |effect| by_channel(effect, channels))
    };
    let mut all: Vec<Effect> = each(model.effects(other)).collect();
    let (before, mut apart) = (all.len(), Vec::new());
    for effect in each(effects) {
        if all.iter().any(|other| is_opposite(other, &effect)) {
            apart.push(of_both_ways(effect));
        } else if !all.contains(&effect) {
            all.push(effect);
        }
    }
    if all.len() == before && !apart.is_empty() {
        // All channels alike are no effect.
        if apart.len() == usize::from(channels) {
            apart.remove(0);
        }
        return (group, model.clone(), apart);
    }
    (other, model.without(other), all)
}

/// The finding of a model with which steady effects of edge classes are one.
#[must_use]
pub fn joins(model: &Model, effects: &[Effect]) -> Option<usize> {
    let steady = |effects: &[Effect]| {
        let mut each = effects.iter();
        each.all(|effect| effect.carrier == Carrier::Steady && effect.growth == Growth::Constant)
    };
    let named = name::mechanism(effects);
    if !steady(effects) || named == Mechanism::Unknown {
        return None;
    }
    model.groups().into_iter().find(|other| {
        let own = model.effects(*other);
        steady(&own) && name::mechanism(&own) == named
    })
}

/// Whether one is of the rises and the other of the falls of the same channel: both together are one of them and the channel as a whole.
fn is_opposite(one: &Effect, other: &Effect) -> bool {
    let ways = |effect: &Effect| match effect.site {
        Site::Stamp(on) | Site::Disc(on) => Some((on.channel, on.rises?)),
        _ => None,
    };
    let same_site = std::mem::discriminant(&one.site) == std::mem::discriminant(&other.site);
    match (ways(one), ways(other)) {
        (Some((channel, rises)), Some((other, falls))) => {
            same_site && channel == other && rises != falls
        }
        _ => false,
    }
}

/// The same of rises and falls.
fn of_both_ways(effect: Effect) -> Effect {
    let both = |on| On { rises: None, ..on };
    let site = match effect.site {
        Site::Stamp(on) => Site::Stamp(both(on)),
        Site::Disc(on) => Site::Disc(both(on)),
        other => other,
    };
    Effect { site, ..effect }
}

/// An effect on all channels as one on each.
fn by_channel(effect: Effect, channels: u8) -> Vec<Effect> {
    let each = |site: &dyn Fn(On) -> Site, on: On| match on.channel {
        Some(_) => vec![effect],
        None => (0..channels)
            .map(|channel| {
                let channel = Some(channel);
                let site = site(On { channel, ..on });
                Effect { site, ..effect }
            })
            .collect(),
    };
    match effect.site {
        Site::Stamp(on) => each(&Site::Stamp, on),
        Site::Disc(on) => each(&Site::Disc, on),
        _ => vec![effect],
    }
}

/// Whether rounding to ticks alone, of the course as it is modelled, shows a good part of what a candidate explains.
fn is_spur(board: &Board, candidate: &Candidate, basis: &Basis, spurs: &[f64]) -> bool {
    let columns: Vec<Vec<f64>> = candidate
        .effects
        .iter()
        .flat_map(|effect| board.columns(effect))
        .collect();
    basis.gain(&columns, spurs) > SPUR * candidate.gain
}

/// Takes off a fit what is no longer worth its numbers: groups, and orders of a family.
fn prune(board: &Board, fit: &mut Fit) {
    while let Some(model) = dropped(board, fit) {
        *fit = board.fit(&model);
    }
}

/// A model without the first group that is not worth its numbers, or an order of a family that is not; none where all are.
fn dropped(board: &Board, fit: &Fit) -> Option<Model> {
    let terms = &fit.model.terms;
    for group in fit.model.groups() {
        let own = terms.iter().filter(|term| term.group == group);
        let own = Model {
            terms: own.cloned().collect(),
        };
        let worth = evidence(board, fit.loss(group), fit.model.numbers(group));
        if worth < SURE || !board.can_be(&own) {
            return Some(fit.model.without(group));
        }
        let order = |term: &Term| {
            let carrier = term.effect.carrier;
            term.effect.site == Site::Torque && matches!(carrier, Carrier::Order(_))
        };
        if own.terms.len() < 2 || !own.terms.iter().all(order) {
            continue;
        }
        // A family has the orders that show, and not those between them.
        let places = (0..terms.len()).filter(|at| terms[*at].group == group);
        let loss = |at: usize| fit.loss_of(&|term| term == at);
        let least = places.map(|at| (loss(at), at));
        let least = least.min_by(|a, b| a.0.total_cmp(&b.0));
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
