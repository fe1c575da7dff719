//! The noise that is likeliest beside an unknown disc, with its intervals.
//!
//! Taking the likeliest disc off and fitting the noise to what is left makes the noise too small, as the disc took some of it. So the
//! disc's errors are integrated out: their quadratic form stays, and the determinant of what the recording says of them is added (H. D.
//! Patterson, R. Thompson, Biometrika 58, 1971).

use nalgebra::{DMatrix, DVector};

use super::Estimate;
use crate::diagnose::filter::Noise;
use crate::diagnose::lsq::dot;
use crate::diagnose::model::{Board, Model};
use crate::diagnose::noise::huber;
use crate::diagnose::pattern::Pattern;

/// Change of a number's logarithm by which its slope and curvature are taken.
const STEP: f64 = 0.08;
/// Newton's steps at the most, how far one goes, and the gain in twice the log likelihood that is none.
const ROUNDS: usize = 6;
const FARTHEST: f64 = 1.0;
const NO_GAIN: f64 = 0.05;
/// A drift that is so much smaller and as likely is none.
const NO_DRIFT: f64 = 1e-3;

/// Noise with its intervals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseFound {
    /// The likeliest.
    pub noise: Noise,
    /// RMS error of a stamp, its tick's rounding included, s.
    pub stamp_s: Estimate,
    /// Density of the acceleration noise, (rad/s^2)^2 s.
    pub torque: Estimate,
}

struct Likelihood {
    board: Board,
    rest: Vec<Vec<f64>>,
    start: Noise,
    drifts: bool,
}

impl Likelihood {
    fn noise(&self, logs: &[f64]) -> Noise {
        Noise {
            torque: logs[0].exp(),
            stamp_s: logs[1].exp(),
            drift: logs.get(2).map_or(self.start.drift, |log| log.exp()),
            ..self.start
        }
    }

    /// Twice the negative logarithm of the likelihood.
    fn cost(&mut self, logs: &[f64]) -> f64 {
        let noise = self.noise(logs);
        let size2 = self.board.pattern.as_ref().map(|pattern| pattern.size2);
        self.board.set_noise(noise);
        let benches = &self.board.benches;
        let each = benches.iter().zip(&self.rest);
        let white: Vec<f64> = each.flat_map(|(bench, rest)| bench.white(rest)).collect();
        let scales = benches.iter().flat_map(|bench| &bench.scales);
        let spread: f64 = scales
            .filter(|scale| **scale > 0.0)
            .map(|scale| -2.0 * scale.ln())
            .sum();
        let pattern = size2.filter(|size2| *size2 > 0.0).and_then(|size2| {
            let mut pattern = Pattern::new(benches, None)?;
            pattern.size2 = size2;
            Some(pattern)
        });
        let (row, volume) = match pattern {
            Some(pattern) => {
                let volume = pattern.log_volume();
                (pattern.taken_off(benches, white), volume)
            }
            None => (white, 0.0),
        };
        dot(&row, &row) + spread + volume
    }

    /// Slopes and curvatures about a place.
    fn local(&mut self, at: &[f64], here: f64) -> (DVector<f64>, DMatrix<f64>) {
        let count = at.len();
        let moved = |by: &[(usize, f64)]| {
            let mut at = at.to_vec();
            by.iter().for_each(|(k, step)| at[*k] += step);
            at
        };
        let sides: Vec<[f64; 2]> = (0..count)
            .map(|k| [STEP, -STEP].map(|step| self.cost(&moved(&[(k, step)]))))
            .collect();
        let slope = DVector::from_fn(count, |k, _| (sides[k][0] - sides[k][1]) / (2.0 * STEP));
        let mut curve = DMatrix::from_fn(count, count, |k, _| {
            (sides[k][0] + sides[k][1] - 2.0 * here) / (STEP * STEP)
        });
        for a in 0..count {
            for b in a + 1..count {
                let both = self.cost(&moved(&[(a, STEP), (b, STEP)]));
                let mixed = (both - sides[a][0] - sides[b][0] + here) / (STEP * STEP);
                curve[(a, b)] = mixed;
                curve[(b, a)] = mixed;
            }
        }
        (slope, curve)
    }
}

/// Fits the noise to what a model leaves, the disc's pattern of the board's size integrated out.
#[must_use]
pub fn fit(board: &Board, model: &Model) -> NoiseFound {
    let rest = board.rest(model);
    let mut board = board.clone();
    weigh(&mut board, &rest);
    let start = board.noise;
    let mut likelihood = Likelihood {
        board,
        rest,
        start,
        drifts: start.drift > 0.0,
    };
    let mut at = vec![start.torque.max(1e-30).ln(), start.stamp_s.ln()];
    if likelihood.drifts {
        let there = likelihood.cost(&at);
        likelihood.start.drift = NO_DRIFT * start.drift;
        if likelihood.cost(&at) > there + 1.0 {
            likelihood.start.drift = start.drift;
            at.push(start.drift.ln());
        }
    }
    let mut here = likelihood.cost(&at);
    let (mut slope, mut curve) = likelihood.local(&at, here);
    for _ in 0..ROUNDS {
        let Some(by) = curve.clone().cholesky().map(|c| c.solve(&slope)) else {
            break;
        };
        let mut share = (FARTHEST / by.amax()).min(1.0);
        let mut better = None;
        for _ in 0..4 {
            let next: Vec<f64> = at
                .iter()
                .zip(by.iter())
                .map(|(at, by)| at - share * by)
                .collect();
            let cost = likelihood.cost(&next);
            if cost < here {
                better = Some((next, cost));
                break;
            }
            share *= 0.3;
        }
        let Some((next, cost)) = better else { break };
        let gain = here - cost;
        (at, here) = (next, cost);
        (slope, curve) = likelihood.local(&at, here);
        if gain < NO_GAIN {
            break;
        }
    }
    let noise = likelihood.noise(&at);
    let errors = errors(&curve, likelihood.tails(&at));
    NoiseFound {
        noise,
        stamp_s: Estimate::of_log(noise.stamp_s, errors[1]),
        torque: Estimate::of_log(noise.torque, errors[0]),
    }
}

impl Likelihood {
    /// Variance of the innovations' squares over that of normal ones: tails make sizes of noise less sure. 1 at the least.
    fn tails(&mut self, at: &[f64]) -> f64 {
        let noise = self.noise(at);
        self.board.set_noise(noise);
        let each = self.board.benches.iter().zip(&self.rest);
        let white: Vec<f64> = each.flat_map(|(bench, rest)| bench.white(rest)).collect();
        let white = match &self.board.pattern {
            Some(pattern) => {
                let mut row = pattern.taken_off(&self.board.benches, white);
                row.truncate(self.board.edges());
                row
            }
            None => white,
        };
        let count = white.len().max(1) as f64;
        let mean = dot(&white, &white) / count;
        let fourth = white.iter().map(|white| white.powi(4)).sum::<f64>() / count;
        (0.5 * (fourth / (mean * mean) - 1.0)).max(1.0)
    }
}

/// Standard errors of the logarithms.
fn errors(curve: &DMatrix<f64>, tails: f64) -> Vec<f64> {
    match curve.clone().cholesky() {
        Some(cholesky) => {
            let inverse = cholesky.inverse();
            let each = (0..curve.nrows()).map(|k| (2.0 * tails * inverse[(k, k)]).sqrt());
            each.collect()
        }
        // What has no curvature is not determined.
        None => vec![f64::INFINITY; curve.nrows()],
    }
}

/// Gives edges that are far out the weight that Huber's function has for them, once and for all.
fn weigh(board: &mut Board, rest: &[Vec<f64>]) {
    let errors = board.pattern.as_ref().map(|pattern| {
        let each = board.benches.iter().zip(rest);
        let white: Vec<f64> = each.flat_map(|(bench, rest)| bench.white(rest)).collect();
        pattern.errors(&board.benches, &white)
    });
    for (bench, rest) in board.benches.iter_mut().zip(rest) {
        let left: Vec<f64> = (0..rest.len())
            .map(|at| rest[at] - errors.as_ref().map_or(0.0, |e| e[bench.record.slot(at)]))
            .collect();
        let white = bench.white(&left);
        let weights = white.iter().map(|white| {
            let square = white * white;
            if square > 0.0 {
                (huber(*white) / square).sqrt()
            } else {
                1.0
            }
        });
        bench.weights = weights.collect();
    }
}
