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
use crate::diagnose::pattern::SMALL;

/// Change of a number's logarithm by which its slope and curvature are taken.
const STEP: f64 = 0.08;
/// Newton's steps at the most, how far one goes, and the gain in twice the log likelihood that is none.
const ROUNDS: usize = 8;
const FARTHEST: f64 = 1.5;
const NO_GAIN: f64 = 0.05;
/// A number that may be so much smaller without a loss in twice the log likelihood is none.
const NOTHING: f64 = 1e-3;
const NO_LOSS: f64 = 1.0;
/// Least curvature over a logarithm: a number is known within some powers of ten at the least.
const FLAT: f64 = 0.2;
/// Loss in twice the log likelihood at the end of a 95 % interval.
const LOSS_95: f64 = 3.84;

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
    /// What rounding to ticks alone makes of stamps, s.
    rounding_s: f64,
    free: Vec<Size>,
}

/// A size of the noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Size {
    Torque,
    /// Of stamps, beside their rounding.
    Stamp,
    Drift,
}

impl Likelihood {
    fn noise(&self, logs: &[f64]) -> Noise {
        let mut noise = self.start;
        for (size, log) in self.free.iter().zip(logs) {
            match size {
                Size::Torque => noise.torque = log.exp(),
                Size::Stamp => noise.stamp_s = self.rounding_s.hypot(log.exp()),
                Size::Drift => noise.drift = log.exp(),
            }
        }
        noise
    }

    /// A size by itself.
    fn size(&self, size: Size) -> f64 {
        match size {
            Size::Torque => self.start.torque,
            Size::Stamp => {
                let beside = self.start.stamp_s.powi(2) - self.rounding_s.powi(2);
                beside.max((0.03 * self.rounding_s).powi(2)).sqrt()
            }
            Size::Drift => self.start.drift,
        }
    }

    /// Sets a size to next to nothing, unless that makes what is seen less likely.
    fn fix_if_nothing(&mut self, size: Size) {
        let logs = |likelihood: &Self| -> Vec<f64> {
            let each = likelihood.free.iter();
            each.map(|size| likelihood.size(*size).ln()).collect()
        };
        let Some(at) = self.free.iter().position(|free| *free == size) else {
            return;
        };
        let there = logs(self);
        let mut less = there.clone();
        less[at] += NOTHING.ln();
        if self.cost(&less) < self.cost(&there) + NO_LOSS {
            self.start = self.noise(&less);
            self.free.remove(at);
        }
    }

    /// Twice the negative logarithm of the likelihood.
    fn cost(&mut self, logs: &[f64]) -> f64 {
        let noise = self.noise(logs);
        self.board.set_noise(noise);
        let benches = &self.board.benches;
        let each = benches.iter().zip(&self.rest);
        let white: Vec<f64> = each.flat_map(|(bench, rest)| bench.white(rest)).collect();
        let scales = benches.iter().flat_map(|bench| {
            let each = bench.scales.iter().zip(&bench.weights);
            each.map(|(scale, weight)| scale * weight)
        });
        let spread: f64 = scales
            .filter(|scale| *scale > 0.0)
            .map(|scale| -2.0 * scale.ln())
            .sum();
        let pattern = self.board.pattern.as_ref();
        let pattern = pattern.filter(|pattern| pattern.size2 > 0.0);
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

/// Twice the negative logarithm of the likelihood of a board's noise, the disc's pattern of its size integrated out.
#[must_use]
pub fn cost(board: &Board) -> f64 {
    let rest = board.rest(&Model::default());
    let mut likelihood = Likelihood {
        rounding_s: 0.0,
        start: board.noise,
        board: board.clone(),
        rest,
        free: Vec::new(),
    };
    likelihood.cost(&[])
}

/// Fits the noise to what a model leaves, the disc's pattern of the board's size integrated out.
#[must_use]
pub fn fit(board: &Board, model: &Model) -> NoiseFound {
    let rest = board.rest(model);
    let mut board = board.clone();
    weigh(&mut board, &rest);
    let ticks = board.benches.iter().map(|bench| bench.record.tick_s);
    let mut likelihood = Likelihood {
        rounding_s: ticks.fold(0.0, f64::max) / 12_f64.sqrt(),
        start: board.noise,
        board,
        rest,
        free: vec![Size::Torque, Size::Stamp, Size::Drift],
    };
    likelihood.fix_if_nothing(Size::Drift);
    let mut at = likelihood.climb();
    // Stamps may be rounded and no more.
    likelihood.start = likelihood.noise(&at);
    let before = likelihood.free.len();
    likelihood.fix_if_nothing(Size::Stamp);
    if likelihood.free.len() < before {
        at = likelihood.climb();
    }
    let here = likelihood.cost(&at);
    let (_, curve) = likelihood.local(&at, here);
    let noise = likelihood.noise(&at);
    let tails = likelihood.tails(&at);
    let errors = errors(&curve, tails);
    let error = |size: Size| {
        let place = likelihood.free.iter().position(|free| *free == size);
        place.map(|at| errors[at])
    };
    let torque = Estimate::of_log(noise.torque, error(Size::Torque).unwrap_or(f64::INFINITY));
    let rounding_s = likelihood.rounding_s;
    let stamp_s = match error(Size::Stamp) {
        Some(error) => {
            let beside = (noise.stamp_s.powi(2) - rounding_s.powi(2)).max(0.0).sqrt();
            Estimate::of_log(beside, error).map(|beside| rounding_s.hypot(beside))
        }
        None => Estimate {
            value: noise.stamp_s,
            ci95: [noise.stamp_s, likelihood.most_stamp_s(&at, here, tails)],
        },
    };
    NoiseFound {
        noise,
        stamp_s,
        torque,
    }
}

impl Likelihood {
    /// Newton's steps from the start to the likeliest sizes; their logarithms.
    fn climb(&mut self) -> Vec<f64> {
        let mut at: Vec<f64> = self.free.iter().map(|size| self.size(*size).ln()).collect();
        let mut here = self.cost(&at);
        for _ in 0..ROUNDS {
            let (slope, curve) = self.local(&at, here);
            // Where it curves the wrong way, the step goes down all the same.
            let parts = curve.symmetric_eigen();
            let mut along = parts.eigenvectors.transpose() * slope;
            for (along, curve) in along.iter_mut().zip(parts.eigenvalues.iter()) {
                *along /= curve.abs().max(FLAT);
            }
            let by = parts.eigenvectors * along;
            let mut share = (FARTHEST / by.amax().max(f64::MIN_POSITIVE)).min(1.0);
            let mut better = None;
            for _ in 0..4 {
                let each = at.iter().zip(by.iter());
                let next: Vec<f64> = each.map(|(at, by)| at - share * by).collect();
                let cost = self.cost(&next);
                if cost < here {
                    better = Some((next, cost));
                    break;
                }
                share *= 0.3;
            }
            let Some((next, cost)) = better else { break };
            let gain = here - cost;
            (at, here) = (next, cost);
            if gain < NO_GAIN {
                break;
            }
        }
        at
    }

    /// The largest error of stamps that is still likely where rounding is the likeliest, s.
    fn most_stamp_s(&mut self, at: &[f64], here: f64, tails: f64) -> f64 {
        let (mut low, mut high) = (0.0, 4.0 * self.rounding_s);
        for _ in 0..8 {
            let middle: f64 = 0.5 * (low + high);
            self.start.stamp_s = self.rounding_s.hypot(middle);
            if self.cost(at) > here + LOSS_95 * tails {
                high = middle;
            } else {
                low = middle;
            }
        }
        self.rounding_s.hypot(high)
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
    let count = curve.nrows();
    let parts = curve.clone().symmetric_eigen();
    let each = (0..count).map(|k| {
        let own = (0..count).map(|way| {
            let share = parts.eigenvectors[(k, way)];
            share * share / parts.eigenvalues[way].max(FLAT)
        });
        (2.0 * tails * own.sum::<f64>()).sqrt()
    });
    each.collect()
}

/// Gives edges that are far out the weight that Huber's function has for them, once and for all.
fn weigh(board: &mut Board, rest: &[Vec<f64>]) {
    let errors = board.pattern.as_ref().map(|pattern| {
        let each = board.benches.iter().zip(rest);
        let white: Vec<f64> = each.flat_map(|(bench, rest)| bench.white(rest)).collect();
        pattern.errors_of(&board.benches, &pattern.fold(&board.benches, &white), SMALL)
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
        let weights: Vec<f64> = weights.collect();
        let each = bench.weights.iter_mut().zip(weights);
        each.for_each(|(all, weight)| *all *= weight);
    }
}
