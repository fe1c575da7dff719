//! How stiffly a drive that nobody declared holds the shaft, where no speed loop shows: open like the noise, and fitted like it.
//!
//! The course is free, so what such a drive does to the mean speed says nothing. A torque that is known, declared or found, moves the shaft
//! by 1 / (J s (s + b)), with b of friction and drive together: slow waves show it. Torque noise shows it too: a held shaft forgets what that made
//! of its speed (G. E. Uhlenbeck, L. S. Ornstein, Physical Review 36, 1930).

use super::disc;
use super::lsq;
use super::model::{Board, Fit, Model};
use super::pattern::Pattern;
use super::scan::{SURE, evidence};

/// Fall of twice the negative logarithm of a likelihood that is none.
const NOTHING: f64 = 0.5;

/// Rates at which a held shaft forgets what torque noise made of its speed that are tried, of the edges' rate.
const FORGETS: [f64; 5] = [0.004, 0.016, 0.06, 0.25, 1.0];

/// Rates between them that are tried about the one that fits best.
const NEARER: usize = 2;

impl Board {
    /// Sets how stiffly an unknown drive holds the shaft to what fits best beside a model. Whether that is anything else than before.
    pub fn hold(&mut self, model: &Model) -> bool {
        if !self.undriven {
            return false;
        }
        if self.is_looped() {
            return self.regain(model);
        }
        if !self.is_pushed(model) {
            return false;
        }
        if self.goes_loose(model) {
            return true;
        }
        let before = self.fit(model);
        let cost = self.held_cost(&before);
        let mut best = (self.clone(), before, cost);
        // Where waves of one speed alone show it, it is as good as any torque's phase; what is held is held as it fits.
        let mut benches = self.benches.iter();
        let is_held = benches.any(|bench| bench.found.stiffness != 0.0);
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

    /// Sets how stiffly an unknown drive holds the shaft to what its noise shows beside a model, where that is sure.
    pub fn hold_by_noise(&mut self, model: &Model) {
        if !self.undriven || self.is_looped() {
            return;
        }
        let each = self.benches.iter();
        let seconds: f64 = each.map(|bench| bench.record.seconds()).sum();
        let rate = self.edges() as f64 / seconds;
        let mut plain = self.clone();
        plain.rounds = 1;
        let each = self.benches.iter().map(|bench| bench.found.stiffness);
        let now = each.fold(0.0, f64::max);
        let held = |share: f64| {
            let mut board = plain.stiffer(share * rate - now)?;
            let cost = board.cost_in_noise(model);
            Some((share, board, cost))
        };
        let Some((_, _, loose)) = held(0.0) else {
            return;
        };
        let mut tried: Vec<(f64, Self, f64)> = FORGETS.into_iter().filter_map(held).collect();
        for _ in 0..NEARER {
            // Best at the end of all rates is what does not move as a shaft does.
            let Some(between) = least(&tried).and_then(held) else {
                return;
            };
            tried.push(between);
            tried.sort_by(|one, other| one.0.total_cmp(&other.0));
        }
        let best = tried
            .into_iter()
            .min_by(|one, other| one.2.total_cmp(&other.2));
        if let Some((_, board, cost)) = best
            && evidence(self, loose - cost, 1) > SURE
        {
            let rounds = self.rounds;
            *self = board;
            self.rounds = rounds;
        }
    }

    /// Takes a shaft for loose that is held by a drive, where that is not worth it any more beside a model: torques that nobody had found yet
    /// may have made it so. Whether it does.
    fn goes_loose(&mut self, model: &Model) -> bool {
        let each = self.benches.iter().map(|bench| bench.found.stiffness);
        let now = each.fold(0.0, f64::max);
        let mut held = self.clone();
        held.rounds = 1;
        let Some(mut loose) = held.stiffer(-now).filter(|_| now > 0.0) else {
            return false;
        };
        let fall = loose.cost_in_noise(model) - held.cost_in_noise(model);
        let goes = evidence(self, fall, 1) <= SURE;
        if goes {
            loose.rounds = self.rounds;
            *self = loose;
        }
        goes
    }

    /// Fits the noise beside a model. Twice the negative logarithm of how likely that makes the recordings, but for a constant.
    fn cost_in_noise(&mut self, model: &Model) -> f64 {
        let fit = self.fit_in_noise(model);
        let volume = self.pattern.as_ref().map_or(0.0, Pattern::log_volume);
        self.held_cost(&fit) + volume
    }

    /// Whether the noise of an unknown drive goes as if nothing held the shaft.
    pub fn loosen(&mut self, loose: bool) {
        let mut board = self.clone();
        for bench in &mut board.benches {
            bench.found.loose = loose;
        }
        if let Some(board) = board.found_anew() {
            *self = board;
        }
    }

    /// Twice the negative logarithm of the likelihood, but for a constant: how stiffly a shaft is held bears on what noise makes as well.
    pub(super) fn held_cost(&self, fit: &Fit) -> f64 {
        fit.rss + self.spread()
    }

    /// A fit whose numbers are as sure as they are beside how stiffly an unknown drive holds the shaft, which turns the phases of torques. What
    /// noise says of that holds as far as a torque's noise is white: no better than to the stiffness itself. Waves at several speeds say more.
    #[must_use]
    pub fn unsure_of_hold(&self, fit: &Fit) -> Fit {
        let mut other = fit.clone();
        let each = self.benches.iter().map(|bench| bench.found.stiffness.abs());
        let size = each.fold(0.0, f64::max);
        let step = self.hold_step();
        let moved = (size > 0.0).then(|| self.stiffer(step)).flatten();
        let Some(moved) = moved else {
            return other;
        };
        let mut columns = fit.columns.clone();
        columns.push(self.slope_to(&moved, &fit.model, step));
        let mut left = fit.left.clone();
        left.push(0.0);
        let own = columns.len() - 1;
        for (at, column) in columns.iter_mut().enumerate() {
            column.push(if at == own { 1.0 / size } else { 0.0 });
        }
        let covariance = lsq::solve(&columns, &left).covariance;
        other.covariance = covariance.view((0, 0), (own, own)).into_owned();
        other
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
        let moved = self.stiffer(step)?;
        let slope = self.slope_to(&moved, &fit.model, step);
        let mut columns: Vec<&[f64]> = fit.columns.iter().map(Vec::as_slice).collect();
        columns.push(&slope);
        let solved = lsq::solve(&columns, &fit.left);
        let variance = solved.covariance[(columns.len() - 1, columns.len() - 1)];
        let spreads = (moved.spread() - self.spread()) / step;
        let by = self.least(solved.sizes.last()? - 0.5 * variance * spreads);
        if variance <= 0.0 || !hopes(by * by / variance) {
            return None;
        }
        let cost = self.held_cost(fit);
        lsq::shares(3).find_map(|share| {
            let board = self.stiffer(share * by)?;
            let tried = board.fit(&fit.model);
            let here = board.held_cost(&tried);
            (here < cost).then_some((board, tried, here))
        })
    }

    /// How white residuals beside a model change with a step to a board whose filter is another one as well, the disc's pattern as it is
    /// here.
    fn slope_to(&self, moved: &Self, model: &Model, step: f64) -> Vec<f64> {
        let (mut here, mut there) = (self.rest(model), moved.rest(model));
        if let Some(errors) = disc::pattern(self, &here) {
            for (at, bench) in self.benches.iter().enumerate() {
                bench.less_errors(&mut here[at], &errors);
                bench.less_errors(&mut there[at], &errors);
            }
        }
        let (mut slope, there) = (self.with_pattern(&here), moved.with_pattern(&there));
        let each = slope.iter_mut().zip(there);
        each.for_each(|(slope, there)| *slope = (*slope - there) / step);
        self.beside_pattern(slope)
    }

    /// A change of stiffness, but for what would drive swings on, 1/s.
    fn least(&self, by: f64) -> f64 {
        let each = self.benches.iter();
        let least = each.map(|bench| -bench.plant.law.viscous - bench.found.stiffness);
        by.max(least.fold(f64::NEG_INFINITY, f64::max))
    }

    /// The board with a drive that is stiffer by so much over the inertia, 1/s.
    fn stiffer(&self, by: f64) -> Option<Self> {
        let mut board = self.clone();
        for bench in &mut board.benches {
            bench.found.stiffness += by;
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
