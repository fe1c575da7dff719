//! Torques at whole orders, told from the disc by what the speed does to them.

use rayon::prelude::*;

use super::{Estimate, disc};
use crate::diagnose::effect::{Carrier, Effect, Site};
use crate::diagnose::model::{Board, Fit, Model};
use crate::diagnose::search::{self, SURE};

/// Torques at whole orders that are tried in their own noise.
const TRIED: usize = 3;
/// Torques at whole orders at the most.
const TORQUES: usize = 6;

/// A torque at a whole order of the shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrderTorque {
    /// Cycles a turn.
    pub order: f64,
    /// Amplitude over the inertia, rad/s^2.
    pub size: Estimate,
    /// Phase of the sine, rad.
    pub phase_rad: f64,
}

/// Adds the torques that are worth their numbers beside a disc of any pattern, each in the noise and with the stiffness that it leaves, at
/// the orders at which one shows or the disc seems to have most: speed that changes tells them from it.
pub fn find(board: &mut Board, model: &Model) -> Fit {
    let mut fit = held(board, model);
    for group in 0..TORQUES {
        let mut orders = search::torque_orders(board, &fit);
        orders.extend(disc::strongest(board, &fit));
        orders.retain(|order| *order < disc::lines(board));
        orders.sort_unstable();
        orders.dedup();
        let tried = orders.into_iter().filter_map(|order| {
            let effect = Effect::new(Site::Torque, Carrier::Order(order as f64));
            let mut terms = fit.model.terms.iter();
            if terms.any(|term| term.effect == effect) {
                return None;
            }
            let next = board.fit(&fit.model.with(&[effect], group));
            let worth = search::evidence(board, fit.rss - next.rss, effect.sizes());
            (worth > 0.0).then_some((worth, next.model))
        });
        let mut tried: Vec<(f64, Model)> = tried.collect();
        tried.sort_by(|a, b| b.0.total_cmp(&a.0));
        tried.truncate(TRIED);
        let tried = tried.into_par_iter().map(|(_, model)| {
            let mut other = board.clone();
            let fit = held(&mut other, &model);
            (other.lost(&fit), other, fit)
        });
        let tried: Vec<(f64, Board, Fit)> = tried.collect();
        let best = tried.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        match best.filter(|best| best.0 < board.lost(&fit) - SURE) {
            Some(best) => (_, *board, fit) = best,
            None => break,
        }
    }
    search::prune(board, &mut fit);
    if board.hold_at_last(&fit.model) {
        fit = board.fit_in_noise(&fit.model);
    }
    fit
}

/// A model beside noise, corners and stiffness as they are likeliest, as each bears on the others.
fn held(board: &mut Board, model: &Model) -> Fit {
    let (other, mut fit, _) = board.at_its_noise(model);
    *board = other;
    search::bend(board, &mut fit);
    fit
}

/// The torques of a fit. Where it does not show how stiffly a drive holds the shaft, that may damp them: hardly one damps waves of one a
/// turn by more than the square root of a half.
pub fn sized(fit: &Fit, loose: bool) -> Vec<OrderTorque> {
    let place = |term: usize| {
        let mut of = fit.of.iter();
        of.position(|(own, number)| *own == term && *number == 0)
    };
    let terms = fit.model.terms.iter().enumerate();
    let each = terms.filter_map(|(at, term)| {
        let Effect {
            site: Site::Torque,
            carrier: Carrier::Order(order),
            ..
        } = term.effect
        else {
            return None;
        };
        let [cos, sin] = term.sizes[..] else {
            return None;
        };
        let first = place(at)?;
        let variance = |a: usize, b: usize| fit.covariance[(first + a, first + b)];
        let size = cos.hypot(sin);
        let [c, s] = [cos / size, sin / size];
        let along = c * c * variance(0, 0) + 2.0 * c * s * variance(0, 1) + s * s * variance(1, 1);
        let mut estimate = Estimate::normal(size, along.max(0.0).sqrt());
        if loose {
            estimate.ci95[1] *= order.recip().hypot(1.0);
        }
        Some(OrderTorque {
            order,
            size: estimate,
            // a sin(n angle + phase) is a sin(phase) cos(n angle) + a cos(phase) sin(n angle).
            phase_rad: cos.atan2(sin),
        })
    });
    each.collect()
}
