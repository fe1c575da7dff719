//! How stiffly a drive that nobody declared holds the shaft, where no speed loop shows: open like the noise, and fitted like it.
//!
//! The course is free, so what such a drive does to the mean speed says nothing. A torque that is known, declared or found, moves the shaft
//! by 1 / (J s (s + b)), with b of friction and drive together: waves at several speeds show it. Torque noise shows it too: a held shaft
//! forgets what that made of its speed (G. E. Uhlenbeck, L. S. Ornstein, Physical Review 36, 1930). But that goes by the noise's being
//! white, which nobody knows: noise that forgets at a rate says b to that rate itself and no better.

use rayon::prelude::*;

use super::lsq::{self, Solution};
use super::model::{Board, Fit, Model};
use super::pattern::Pattern;
use super::plant::Hold;
use super::scan::{SURE, evidence};

/// Fall of twice the negative logarithm of a likelihood that is none, and its rise at a standard error.
const NOTHING: f64 = 0.5;
const ONE_SIGMA: f64 = 1.0;

/// Rates at which a held shaft forgets what torque noise made of its speed that are tried, of the edges' rate, and the ratio of those that
/// are slower.
const FORGETS: [f64; 5] = [0.004, 0.016, 0.06, 0.25, 1.0];
const SLOWER: f64 = 0.25;

/// Rates between them that are tried about the one that fits best.
const NEARER: usize = 2;

/// Rates that are tried about one that was found, of it.
const ABOUT: [f64; 4] = [0.0, 0.7, 1.0, 1.4];

impl Board {
    /// Sets how stiffly an unknown drive holds the shaft to what fits best beside a model. Whether that is anything else than before.
    pub fn hold(&mut self, model: &Model) -> bool {
        if !self.undriven {
            return false;
        }
        if self.is_looped() {
            return self.regain(model);
        }
        let now = self.hold_now();
        if !self.is_pushed(model) {
            // Without waves it is as noise says.
            let as_noise =
                (now.stiffness != now.forgets).then(|| self.stiffer(now.forgets - now.stiffness));
            let other = as_noise.flatten();
            let moved = other.is_some();
            *self = other.unwrap_or_else(|| self.clone());
            return moved;
        }
        let forgets = self.forget(model);
        forgets | self.hold_by_waves(model)
    }

    /// Whether nothing says yet how stiffly an unknown drive holds the shaft.
    pub fn is_loose(&self) -> bool {
        self.undriven && !self.is_looped() && self.hold_now().stiffness == 0.0
    }

    /// Sets how stiffly an unknown drive holds the shaft to what is likeliest beside a model with torques, however little that says: their
    /// sizes and phases go by it. Whether that is anything else than before.
    pub fn hold_at_last(&mut self, model: &Model) -> bool {
        if !self.undriven || self.is_looped() || !self.is_pushed(model) {
            return false;
        }
        let before = self.hold_now();
        if before.stiffness == 0.0 {
            let open = self.hold_likelier(model, NOTHING);
            let benches = self.benches.iter_mut();
            benches.for_each(|bench| bench.found.hold.open = open);
        }
        self.hold_by_waves(model);
        self.hold_now() != before
    }

    /// Sets how stiffly an unknown drive holds the shaft to what waves say. Whether that is anything else than before.
    fn hold_by_waves(&mut self, model: &Model) -> bool {
        let before = self.fit(model);
        let cost = self.held_cost(&before);
        let mut best = (self.clone(), before, cost);
        // Where nothing shows that the shaft is held, waves have to be sure of it; what is held is held as it fits.
        let is_held = self.hold_now().stiffness != 0.0;
        let sure = |fall: f64| (is_held && fall > NOTHING) || evidence(self, fall, 1) > SURE;
        for _ in 0..lsq::ROUNDS {
            let hopes = |more: f64| sure(cost - best.2 + 2.0 * more) && more > NOTHING;
            let Some(better) = best.0.held_better(&best.1, hopes) else {
                break;
            };
            best = better;
        }
        let sure = sure(cost - best.2);
        if sure {
            *self = best.0;
        }
        sure
    }

    /// Sets how fast an unknown drive forgets noise to what that shows beside a model, and how stiffly it holds the shaft to the same, where
    /// noise is sure of it.
    pub fn hold_by_noise(&mut self, model: &Model) {
        if self.undriven && !self.is_looped() {
            self.hold_likelier(model, SURE + (self.edges() as f64).ln());
        }
    }

    /// The same where noise makes it likelier by more than some fall of twice the negative logarithm. By how much it may be off, 1/s.
    fn hold_likelier(&mut self, model: &Model, least_fall: f64) -> f64 {
        let held = |rate: f64| {
            let (board, cost) = self.forgetting(rate, model)?;
            Some((rate, board, cost))
        };
        let Some((_, _, loose)) = held(0.0) else {
            return 0.0;
        };
        // What forgets less than once in a recording does not show.
        let (rate, longest) = (self.edge_rate(), self.seconds());
        let slower = std::iter::successors(Some(SLOWER * FORGETS[0]), |share| Some(SLOWER * share));
        let slower = slower.take_while(|share| share * rate * longest > 1.0);
        let mut rates: Vec<f64> = FORGETS
            .into_iter()
            .chain(slower)
            .map(|share| share * rate)
            .collect();
        rates.sort_by(f64::total_cmp);
        let tried = rates.into_par_iter().filter_map(held);
        let mut tried: Vec<_> = tried.collect();
        let mut inside = true;
        for _ in 0..NEARER {
            // Best at the end of all rates is what does not move as a shaft does.
            let between = least(&tried).and_then(held);
            inside = between.is_some();
            let Some(between) = between else {
                break;
            };
            tried.push(between);
            tried.sort_by(|one, other| one.0.total_cmp(&other.0));
        }
        let costs = tried.iter().map(|(_, _, cost)| *cost);
        let lowest = costs.fold(loose, f64::min);
        let open = tried
            .iter()
            .filter(|(_, _, cost)| *cost < lowest + ONE_SIGMA);
        let open = open.fold(0.0, |most: f64, (rate, ..)| most.max(*rate));
        let best = tried
            .into_iter()
            .min_by(|one, other| one.2.total_cmp(&other.2));
        if let Some((_, board, cost)) = best
            && inside
            && loose - cost > least_fall
        {
            let rounds = self.rounds;
            *self = board;
            self.rounds = rounds;
        }
        open
    }

    /// Sets how fast an unknown drive forgets noise anew beside a model: torques that nobody had found yet may have made it so. Whether that is
    /// anything else than before.
    fn forget(&mut self, model: &Model) -> bool {
        let now = self.hold_now().forgets;
        let most = self.edge_rate();
        let each = ABOUT.par_iter().map(|share| {
            let tried = now > 0.0 && share * now < most;
            tried.then(|| self.forgetting(share * now, model)).flatten()
        });
        let mut each = each.collect::<Vec<_>>().into_iter();
        let mut next = || each.next().flatten();
        let (Some(loose), less, Some(same), more) = (next(), next(), next(), next()) else {
            return false;
        };
        let others = [less, more].into_iter().flatten();
        let other = others.min_by(|one, other| one.1.total_cmp(&other.1));
        let least = other.as_ref().map_or(same.1, |other| other.1.min(same.1));
        let other = if evidence(self, loose.1 - least, 1) <= SURE {
            Some(loose.0)
        } else {
            other
                .filter(|other| other.1 < same.1 - NOTHING)
                .map(|other| other.0)
        };
        let Some(mut other) = other else {
            return false;
        };
        other.rounds = self.rounds;
        *self = other;
        true
    }

    /// The board with a drive that forgets noise so fast, in the noise that fits beside a model, and twice the negative logarithm of how likely
    /// that makes the recordings, but for a constant. Where waves don't say how stiffly it holds the shaft, it does so as fast.
    fn forgetting(&self, rate: f64, model: &Model) -> Option<(Self, f64)> {
        let mut board = self.clone();
        board.rounds = 1;
        for bench in &mut board.benches {
            let hold = &mut bench.found.hold;
            if rate <= 0.0 || hold.stiffness == hold.forgets {
                hold.stiffness = rate;
            }
            hold.forgets = rate;
        }
        let mut board = board.found_anew()?;
        let fit = board.fit_in_noise(model);
        let volume = board.pattern.as_ref().map_or(0.0, Pattern::log_volume);
        let cost = fit.rss + board.spread() + volume;
        Some((board, cost))
    }

    /// How the drive holds the shaft, of all recordings alike.
    fn hold_now(&self) -> Hold {
        let first = self.benches.first();
        first.map_or_else(Hold::default, |bench| bench.found.hold)
    }

    /// Whether the noise of an unknown drive goes as if nothing held the shaft.
    pub fn loosen(&mut self, loose: bool) {
        let mut board = self.clone();
        for bench in &mut board.benches {
            bench.found.hold.loose = loose;
        }
        if let Some(board) = board.found_anew() {
            *self = board;
        }
    }

    /// Twice the negative logarithm of how likely waves make a stiffness, beside what noise says of it, but for a constant.
    fn held_cost(&self, fit: &Fit) -> f64 {
        fit.rss + self.unlike_noise().map_or(0.0, |(off, _)| off * off)
    }

    /// By how much the stiffness is another one than noise says, and what a change of it by 1/s adds to that: of what noise is sure of.
    fn unlike_noise(&self) -> Option<(f64, f64)> {
        let hold = self.hold_now();
        let open = hold.open.max(hold.forgets);
        (open > 0.0).then(|| (hold.stiffness / open - hold.forgets / open, 1.0 / open))
    }

    /// A fit whose numbers are as sure as they are beside how stiffly an unknown drive holds the shaft, which turns the phases of torques.
    #[must_use]
    pub fn unsure_of_hold(&self, fit: &Fit) -> Fit {
        let mut other = fit.clone();
        let hold = self.hold_now();
        if hold.stiffness == 0.0 && hold.open == 0.0 {
            return other;
        }
        // A torque goes by the square root of 1 + (b / w)^2: near 0 its slope says nothing of what a standard error of b does.
        let (mut step, own) = (self.hold_step(), fit.columns.len());
        for _ in 0..2 {
            let Some(moved) = self.stiffer(step) else {
                break;
            };
            let solved = self.beside_hold(fit, &moved, step);
            other.covariance = solved.covariance.view((0, 0), (own, own)).into_owned();
            step = solved.covariance[(own, own)].sqrt().max(step);
        }
        other
    }

    /// Numbers of a fit with the stiffness as the last one, beside a board that is stiffer by a step.
    fn beside_hold(&self, fit: &Fit, moved: &Self, step: f64) -> Solution {
        let (mut slope, there) = (self.rest(&fit.model), moved.rest(&fit.model));
        for (slope, there) in slope.iter_mut().zip(there) {
            let each = slope.iter_mut().zip(there);
            each.for_each(|(slope, there)| *slope = (*slope - there) / step);
        }
        let mut columns = fit.columns.clone();
        columns.push(self.beside_pattern(self.with_pattern(&slope)));
        let mut left = fit.left.clone();
        if let Some((off, by)) = self.unlike_noise() {
            columns.iter_mut().for_each(|column| column.push(0.0));
            if let Some(last) = columns.last_mut().and_then(|own| own.last_mut()) {
                *last = by;
            }
            left.push(-off);
        }
        lsq::solve(&columns, &left)
    }

    /// A step of the stiffness, 1/s: of waves of one a turn it changes a thousandth.
    fn hold_step(&self) -> f64 {
        let each = self.benches.iter();
        1e-3 * each.fold(0.0, |most: f64, bench| most.max(bench.course.mean()))
    }

    /// Whether torques that the twins declare or a model has move the shaft.
    fn is_pushed(&self, model: &Model) -> bool {
        let mut benches = self.benches.iter();
        let mut terms = model.terms.iter();
        benches.any(|bench| bench.declared.is_pushed())
            || terms.any(|term| !term.nuisance && term.effect.site.pushes())
    }

    /// The board with another stiffness that fits better, the fit, and its cost, where by about how much it would fall gives hope.
    fn held_better(&self, fit: &Fit, hopes: impl Fn(f64) -> bool) -> Option<(Self, Fit, f64)> {
        let step = self.hold_step();
        let solved = self.beside_hold(fit, &self.stiffer(step)?, step);
        let own = fit.columns.len();
        let variance = solved.covariance[(own, own)];
        let by = self.least(*solved.sizes.last()?);
        if variance <= 0.0 || !hopes(by * by / variance) {
            return None;
        }
        let cost = self.held_cost(fit);
        lsq::shares(3).find_map(|share| {
            // What is held again before the next edge does not move as a shaft does.
            let board = self.stiffer(share * by)?;
            let moves = board.hold_now().stiffness < self.edge_rate();
            let board = Some(board).filter(|_| moves)?;
            let tried = board.fit(&fit.model);
            let here = board.held_cost(&tried);
            (here < cost).then_some((board, tried, here))
        })
    }

    /// A change of stiffness, but for what would drive swings on, 1/s.
    fn least(&self, by: f64) -> f64 {
        let each = self.benches.iter();
        let least = each.map(|bench| -bench.plant.law.viscous - bench.found.hold.stiffness);
        by.max(least.fold(f64::NEG_INFINITY, f64::max))
    }

    /// Edges in a second.
    fn edge_rate(&self) -> f64 {
        let each = self.benches.iter();
        let seconds: f64 = each.map(|bench| bench.record.seconds()).sum();
        self.edges() as f64 / seconds
    }

    /// The board with a drive that is stiffer by so much over the inertia, 1/s.
    fn stiffer(&self, by: f64) -> Option<Self> {
        let mut board = self.clone();
        for bench in &mut board.benches {
            bench.found.hold.stiffness += by;
        }
        board.found_anew()
    }
}

/// Where the cost of shares, ever larger, is least by the parabola of its least one and those beside it.
fn least(tried: &[(f64, Board, f64)]) -> Option<f64> {
    let costs = tried.iter().map(|(_, _, cost)| *cost);
    let at = costs
        .enumerate()
        .min_by(|one, other| one.1.total_cmp(&other.1))?
        .0;
    let [one, two, three] = tried.get(at.checked_sub(1)?..at + 2)? else {
        return None;
    };
    let [one, two, three] = [one, two, three].map(|(share, _, cost)| (share.ln(), *cost));
    let slope = |a: (f64, f64), b: (f64, f64)| (b.1 - a.1) / (b.0 - a.0);
    let (before, after) = (slope(one, two), slope(two, three));
    let middle = |a: (f64, f64), b: (f64, f64)| 0.5 * (a.0 + b.0);
    let (from, until) = (middle(one, two), middle(two, three));
    Some((from - before * (until - from) / (after - before)).exp())
}
