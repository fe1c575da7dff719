//! How stiffly a drive that nobody declared holds the shaft, where no speed loop shows: open like the noise, and fitted like it.
//!
//! The course is free, so what such a drive does to the mean speed says nothing. A torque that is known, declared or found, moves the shaft
//! by 1 / (J s (s + b)), with b of friction and drive together: slow waves show it.

use super::lsq;
use super::model::{Board, Fit, Model, pushes};
use super::scan::{SURE, evidence};

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
        let before = self.fit(model);
        let cost = self.held_cost(&before);
        let mut best = (self.clone(), before, cost);
        for _ in 0..lsq::ROUNDS {
            let Some(better) = best.0.held_better(&best.1) else {
                break;
            };
            best = better;
        }
        // Where waves of one speed alone show it, it is as good as any torque's phase.
        let sure = evidence(self, cost - best.2, 1) > SURE;
        if sure {
            *self = best.0;
        }
        sure
    }

    /// Twice the negative logarithm of the likelihood, but for a constant: how stiffly a shaft is held bears on what noise makes as well.
    pub(super) fn held_cost(&self, fit: &Fit) -> f64 {
        fit.rss + self.spread()
    }

    /// Whether torques that the twins declare or a model has move the shaft.
    fn is_pushed(&self, model: &Model) -> bool {
        let mut benches = self.benches.iter();
        let mut terms = model.terms.iter();
        benches.any(|bench| bench.declared.is_pushed())
            || terms.any(|term| !term.nuisance && pushes(term.effect.site))
    }

    /// The board with another stiffness that fits better, the fit, and its cost.
    fn held_better(&self, fit: &Fit) -> Option<(Self, Fit, f64)> {
        let each = self.benches.iter();
        let speed = each.fold(0.0, |most: f64, bench| most.max(bench.course.mean()));
        // Of waves of one a turn it changes a thousandth.
        let step = 1e-3 * speed;
        let (mut slope, moved) = (self.rest(&fit.model), self.stiffer(step)?.rest(&fit.model));
        for (slope, moved) in slope.iter_mut().zip(moved) {
            let each = slope.iter_mut().zip(moved);
            each.for_each(|(slope, moved)| *slope = (*slope - moved) / step);
        }
        let slope = self.white(&slope);
        let mut columns: Vec<&[f64]> = fit.columns.iter().map(Vec::as_slice).collect();
        columns.push(&slope);
        let solved = lsq::solve(&columns, &fit.left);
        let (by, cost) = (*solved.sizes.last()?, self.held_cost(fit));
        if lsq::is_settled(
            by,
            solved.covariance[(columns.len() - 1, columns.len() - 1)],
        ) {
            return None;
        }
        lsq::shares(3).find_map(|share| {
            let board = self.stiffer(share * by)?;
            let tried = board.fit(&fit.model);
            let here = board.held_cost(&tried);
            (here < cost).then_some((board, tried, here))
        })
    }

    /// The board with a drive that is stiffer by so much over the inertia, 1/s.
    fn stiffer(&self, by: f64) -> Option<Self> {
        let mut board = self.clone();
        for bench in &mut board.benches {
            // Less than none would drive swings on.
            let least = -bench.plant.law.viscous;
            bench.found.stiffness = (bench.found.stiffness + by).max(least);
        }
        board.found_anew()
    }
}
