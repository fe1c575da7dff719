//! Gains of a speed loop that nobody declared: open like the noise, and fitted like it.

use crate::diagnose::diagnosis::LearnedLoop;
use crate::diagnose::lsq;
use crate::diagnose::model::{Board, Fit, Model};
use crate::twin::Gains;

impl Board {
    /// Whether a speed loop that the twins do not declare drives the shaft.
    pub fn is_looped(&self) -> bool {
        let mut benches = self.benches.iter();
        benches.any(|bench| bench.found.speed_loop.is_some())
    }

    /// That loop, for a report.
    pub fn learned_loop(&self) -> Option<LearnedLoop> {
        let bench = self.benches.first()?;
        let own = bench.found.speed_loop.as_ref()?.own;
        let inertia = bench.twin.shaft.inertia_or_one();
        Some(LearnedLoop {
            f_hz: own.rate_hz,
            kp_n_m_s: inertia * own.gains.kp,
            ki_n_m: inertia * own.gains.ki,
        })
    }

    /// Sets the gains of that loop to those that fit best beside a model. Whether they are others than before.
    pub fn regain(&mut self, model: &Model) -> bool {
        let before = self.fit(model);
        let Some(by) = self.gains_beside(&before) else {
            return false;
        };
        let cost = before.rss + self.spread();
        let better = lsq::shares(3).find_map(|share| {
            let mut board = self.clone();
            let loops = board.benches.iter_mut().map(|bench| &mut bench.found);
            for own in loops.filter_map(|found| found.speed_loop.as_mut()) {
                own.own.gains.kp += share * by.kp;
                own.own.gains.ki += share * by.ki;
            }
            let board = board.found_anew()?;
            let fit = board.fit(model);
            (fit.rss + board.spread() < cost).then_some(board)
        });
        if let Some(board) = better {
            *self = board;
            return true;
        }
        false
    }

    /// By how much other gains fit best beside a fit; none where that is nothing.
    fn gains_beside(&self, fit: &Fit) -> Option<Gains> {
        let unit = |kp: f64, ki: f64| {
            let each = self.benches.iter().map(|bench| {
                let own = bench.found.speed_loop.as_ref();
                let own =
                    own.map(|own| bench.sampled(own.own.rate_hz, &own.push(Gains { kp, ki })));
                own.unwrap_or_else(|| vec![0.0; bench.record.len()])
            });
            self.white(&each.collect::<Vec<Vec<f64>>>())
        };
        let (kp, ki) = (unit(1.0, 0.0), unit(0.0, 1.0));
        let mut columns: Vec<&[f64]> = fit.columns.iter().map(Vec::as_slice).collect();
        columns.extend([&*kp, &*ki]);
        let solved = lsq::solve(&columns, &fit.left);
        let [.., kp, ki] = solved.sizes[..] else {
            return None;
        };
        let variance = |at: usize| solved.covariance[(at, at)];
        let count = columns.len();
        let settled =
            lsq::is_settled(kp, variance(count - 2)) && lsq::is_settled(ki, variance(count - 1));
        (!settled).then_some(Gains { kp, ki })
    }
}
