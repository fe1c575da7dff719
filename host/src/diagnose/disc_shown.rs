//! The disc as recordings show it: how edges and orders pull through the noise, and the errors that explain a pull.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;

use rayon::prelude::*;
use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};

use super::bench::Bench;
use super::board::{Board, Column, PARTS};

/// Which parts of the recordings count.
pub type Kept<'a> = &'a dyn Fn(usize) -> bool;

/// Edges that a pattern needs.
const EDGES_LEAST: usize = 4;

/// Squares over those of the pattern and noise from which on an order stands far out of it.
pub const FAR: f64 = 12.0;

/// Steps of the conjugate gradients at the most.
const STEPS: usize = 60;
/// Squares that they may leave.
const NEAR: f64 = 0.3;

/// The disc as the recordings show it.
pub struct Disc<'a> {
    pub board: &'a Board,
    pub edges: usize,
    classes: usize,
    /// Orders that are the pattern's.
    pub orders: Vec<usize>,
    /// How clearly each order shows.
    pub clear: Vec<f64>,
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
}

impl<'a> Disc<'a> {
    pub fn of(board: &'a Board) -> Option<Self> {
        let first = board.benches.first()?;
        let edges = first.seen.edges as usize;
        let classes = first.seen.classes as usize;
        let lines = edges / classes;
        if edges < EDGES_LEAST
            || (board.benches.len() > 1 && !board.tied)
            || first.seen.turns() < 3.0
        {
            return None;
        }
        let mut planner = RealFftPlanner::<f64>::new();
        let mut disc = Self {
            board,
            edges,
            classes,
            orders: Vec::new(),
            clear: Vec::new(),
            forward: planner.plan_fft_forward(edges),
            inverse: planner.plan_fft_inverse(edges),
        };
        disc.clear = board.clear.get_or_init(|| disc.clearness()).clone();
        // What is the same for all edges of a class has names of its own.
        let own = |order: usize| {
            order != 0 && (lines == 0 || !order.is_multiple_of(lines)) && 2 * order <= edges
        };
        disc.orders = (0..disc.clear.len())
            .filter(|order| own(*order) && disc.clear[*order] > 0.0)
            .collect();
        Some(disc)
    }

    /// The same with what all edges of a class have among the orders: it has names of its own, but the errors of the other orders carry
    /// it along, and nothing can be solved for beside it as long as it is not known.
    #[must_use]
    pub fn with_classes(mut self) -> Self {
        let shown = (1..self.clear.len()).filter(|order| self.clear[*order] > 0.0);
        self.orders = shown.collect();
        self
    }

    /// From edge to edge there and back is one number, not two.
    pub fn weight(&self, order: usize) -> f64 {
        if 2 * order == self.edges { 0.5 } else { 1.0 }
    }

    pub fn spectrum(&self, mut row: Vec<f64>) -> Vec<Complex<f64>> {
        let mut output = self.forward.make_output_vec();
        let _ = self.forward.process(&mut row, &mut output);
        output
    }

    /// What orders of the pattern's own make of a row, each times a weight.
    pub fn weighted(&self, row: &[f64], weight: &dyn Fn(usize) -> f64) -> Vec<f64> {
        let spectrum = self.spectrum(row.to_vec());
        let mut kept = vec![Complex::new(0.0, 0.0); spectrum.len()];
        for &m in &self.orders {
            kept[m] = spectrum[m] * (weight(m) / self.edges as f64);
        }
        let mut output = self.inverse.make_output_vec();
        let _ = self.inverse.process(&mut kept, &mut output);
        output
    }

    /// Without the orders that are not the pattern's.
    pub fn own(&self, row: &[f64]) -> Vec<f64> {
        self.weighted(row, &|_| 1.0)
    }

    /// Errors of the edges as rows of the recordings, white.
    pub fn rows(&self, errors: &[f64]) -> Vec<Vec<f64>> {
        let benches = self.board.benches.iter();
        benches
            .map(|bench| {
                let seen = &bench.seen;
                let error = |at| {
                    if shows(bench, at) {
                        errors[seen.edge(at)]
                    } else {
                        0.0
                    }
                };
                bench.whitened((0..seen.len()).map(error).collect())
            })
            .collect()
    }

    /// Zero outside of some parts.
    pub fn keep(&self, rows: &mut [Vec<f64>], kept: &dyn Fn(usize) -> bool) {
        for (bench, row) in self.board.benches.iter().zip(rows) {
            for part in (0..PARTS).filter(|part| !kept(*part)) {
                row[bench.part(part)].fill(0.0);
            }
        }
    }

    /// A column's rows, nothing where it does not show.
    pub fn whole(&self, column: &Column) -> Vec<Vec<f64>> {
        let parts = column.0.iter().zip(&self.board.benches);
        parts
            .map(|(part, bench)| match part {
                Some(part) => part.to_vec(),
                None => vec![0.0; bench.seen.len()],
            })
            .collect()
    }

    /// How strongly rows pull at every edge.
    pub fn folded(&self, rows: Vec<Vec<f64>>) -> Vec<f64> {
        let mut pull = vec![0.0; self.edges];
        for (bench, mut row) in self.board.benches.iter().zip(rows) {
            bench.transposed(&mut row);
            for (at, value) in row.iter().enumerate().filter(|(at, _)| shows(bench, *at)) {
                pull[bench.seen.edge(at)] += value;
            }
        }
        pull
    }

    /// Variance of each order: that of the white pattern, and as found where an order stands far out of it, as low orders do.
    pub fn prior(&self, pulled: &[Complex<f64>], s2: f64) -> Vec<f64> {
        let each = pulled.iter().zip(&self.clear);
        each.map(|(pulled, clear)| {
            let z2 = pulled.norm_sqr() / (self.edges as f64 * clear);
            if *clear > 0.0 && z2 > FAR * (1.0 + s2 * clear) {
                z2 / clear
            } else {
                s2
            }
        })
        .collect()
    }

    /// The errors that solve (A + 1/s^2) e = pull, with A of some parts alone and the variance s^2 of each order.
    pub fn solved(
        &self,
        pulled: Vec<f64>,
        prior: &[f64],
        kept: &dyn Fn(usize) -> bool,
    ) -> Vec<f64> {
        let share = (0..PARTS).filter(|part| kept(*part)).count() as f64 / PARTS as f64;
        let weight = |m: usize| (share * self.clear[m] + 1.0 / prior[m]).recip();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut errors = vec![0.0; self.edges];
        let mut left = pulled;
        let mut nearer = self.weighted(&left, &weight);
        let mut way = nearer.clone();
        let mut size = dot(&left, &nearer);
        for _ in 0..STEPS {
            if size < NEAR {
                break;
            }
            let mut rows = self.rows(&way);
            self.keep(&mut rows, kept);
            let mut answer = self.own(&self.folded(rows));
            let own = self.weighted(&way, &|m| 1.0 / prior[m]);
            for (answer, own) in answer.iter_mut().zip(own) {
                *answer += own;
            }
            let far = size / dot(&way, &answer);
            for at in 0..self.edges {
                errors[at] += far * way[at];
                left[at] -= far * answer[at];
            }
            nearer = self.weighted(&left, &weight);
            let now = dot(&left, &nearer);
            let turn = now / size;
            size = now;
            for (way, nearer) in way.iter_mut().zip(&nearer) {
                *way = nearer + turn * *way;
            }
        }
        errors
    }

    /// How clearly each order shows: the answer of the pull to one edge of each kind, over the orders.
    fn clearness(&self) -> Vec<f64> {
        let mut clear = vec![0.0; self.edges / 2 + 1];
        let tried = [self.edges / 3, self.edges / 3 + self.edges / 2];
        for start in tried {
            for class in 0..self.classes {
                let one = (start / self.classes * self.classes + class) % self.edges;
                let mut alone = vec![0.0; self.edges];
                alone[one] = 1.0;
                let mut answer = self.folded(self.rows(&alone));
                answer.rotate_left(one);
                for (sum, value) in clear.iter_mut().zip(self.spectrum(answer)) {
                    *sum += value.re / (tried.len() * self.classes) as f64;
                }
            }
        }
        // Few edges were tried; how clearly edges show in the mean is known exactly.
        let mut mean = 0.0;
        for bench in &self.board.benches {
            let each = bench.whitener().precisions().into_iter().enumerate();
            mean += each
                .filter(|(at, _)| shows(bench, *at))
                .map(|(_, precision)| precision)
                .sum::<f64>()
                / self.edges as f64;
        }
        let tried_mean = clear.iter().sum::<f64>() / clear.len() as f64;
        if tried_mean > 0.0 {
            clear
                .iter_mut()
                .for_each(|clear| *clear *= mean / tried_mean);
        }
        self.slow_orders(&mut clear);
        clear
    }

    /// Low orders are slow enough to be lost in the shaft's own wander: they show by so little of what the highest do that edges tried
    /// one by one do not say by how much, nor even its sign. Each is tried by itself until both ways agree.
    fn slow_orders(&self, clear: &mut [f64]) {
        const ALIKE: f64 = 0.1;
        const IN_A_ROW: usize = 4;
        let mut agreed = 0;
        for (order, clear) in clear.iter_mut().enumerate().skip(1) {
            let wave = |shift: f64| -> Vec<f64> {
                let angle = |edge| TAU * (order * edge) as f64 / self.edges as f64;
                (0..self.edges)
                    .map(|edge| (angle(edge) + shift).cos())
                    .collect()
            };
            let waves = [wave(0.0), wave(FRAC_PI_2)];
            let squares =
                |wave: &Vec<f64>| -> f64 { self.rows(wave).iter().flatten().map(|w| w * w).sum() };
            let shown = waves.par_iter().map(squares).sum::<f64>() / self.edges as f64;
            let alike = (*clear / shown - 1.0).abs() < ALIKE;
            agreed = if alike { agreed + 1 } else { 0 };
            *clear = shown;
            if agreed == IN_A_ROW {
                break;
            }
        }
    }
}

/// Whether an edge counts: near a standstill few edges would outweigh all others, and the shaft's own way there is rough.
fn shows(bench: &Bench, at: usize) -> bool {
    const SLOW: f64 = 0.2;
    bench.seen.speeds[at].abs() >= SLOW * bench.mean_speed
}
