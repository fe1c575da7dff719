//! How stiffly a drive that nobody declared holds the shaft: open like the noise, and fitted like it.
//!
//! The course is free, so what such a drive does to the mean speed says nothing. A torque that is known, declared or found, moves the shaft
//! by 1 / (J s (s + b)), with b of friction and drive together: slow waves show it.

use super::lsq;
use super::model::{Board, Fit, Model, pushes};
use super::scan::{SURE, evidence};

/// Rounds of re-linearisation at the most.
const ROUNDS: usize = 6;
/// First step over the mean speed: of waves of one a turn it changes so much.
const STEP: f64 = 1e-3;
/// Part of a step that is taken where the whole one does not help, and how often.
const SHORTER: f64 = 0.3;
const SHORTENED: usize = 3;
/// Fall of the sum of squares that is worth another round.
const WORTH: f64 = 1.0;

impl Board {
    /// Sets how stiffly an unknown drive holds the shaft to what fits best beside a model. Whether that is anything else than before.
    pub fn hold(&mut self, model: &Model) -> bool {
        if !self.undriven || !self.is_pushed(model) {
            return false;
        }
        let before = self.fit(model);
        let mut best: Option<(Self, Fit)> = None;
        for _ in 0..ROUNDS {
            let (board, fit) = best.as_ref().map_or((&*self, &before), |(a, b)| (a, b));
            let Some(better) = board.held_better(fit) else {
                break;
            };
            let gain = board.held_cost(fit) - better.0.held_cost(&better.1);
            best = Some(better);
            if gain < WORTH {
                break;
            }
        }
        // Where waves of one speed alone show it, it is as good as any torque's phase.
        let cost = self.held_cost(&before);
        let gain = |best: &(Self, Fit)| cost - best.0.held_cost(&best.1);
        let sure = |best: &(Self, Fit)| evidence(self, gain(best), 1) > SURE;
        let Some((board, _)) = best.filter(sure) else {
            return false;
        };
        *self = board;
        true
    }

    /// Twice the negative logarithm of the likelihood, but for a constant: how stiffly a shaft is held bears on what noise makes as well.
    fn held_cost(&self, fit: &Fit) -> f64 {
        fit.rss + self.spread()
    }

    /// Whether torques that the twins declare or a model has move the shaft.
    fn is_pushed(&self, model: &Model) -> bool {
        let mut benches = self.benches.iter();
        let mut terms = model.terms.iter();
        benches.any(|bench| bench.declared.is_pushed())
            || terms.any(|term| !term.nuisance && pushes(term.effect.site))
    }

    /// The board with another stiffness that fits better, and the fit.
    fn held_better(&self, fit: &Fit) -> Option<(Self, Fit)> {
        let each = self.benches.iter();
        let speed = each.fold(0.0, |most: f64, bench| most.max(bench.course.mean()));
        let step = STEP * speed;
        let moved = self.stiffer(step)?;
        let (rest, other) = (self.rest(&fit.model), moved.rest(&fit.model));
        let slope: Vec<Vec<f64>> = rest
            .iter()
            .zip(&other)
            .map(|(rest, other)| {
                let each = rest.iter().zip(other);
                each.map(|(rest, other)| (rest - other) / step).collect()
            })
            .collect();
        let slope = self.white(&slope);
        let mut columns: Vec<&[f64]> = fit.columns.iter().map(Vec::as_slice).collect();
        columns.push(&slope);
        let solved = lsq::solve(&columns, &fit.left);
        if fit.rss - solved.rss < WORTH {
            return None;
        }
        let mut by = *solved.sizes.last()?;
        for _ in 0..SHORTENED {
            let tried = self.stiffer(by).map(|board| {
                let tried = board.fit(&fit.model);
                (board, tried)
            });
            let cost = self.held_cost(fit);
            if let Some(better) = tried.filter(|(board, tried)| board.held_cost(tried) < cost) {
                return Some(better);
            }
            by *= SHORTER;
        }
        None
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
