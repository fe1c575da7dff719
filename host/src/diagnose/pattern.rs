//! The disc's own pattern: an unknown error of each edge of the grid, small beside a known size, that every turn repeats.
//!
//! With N unknown errors e of variance s^2 beside a model, the least of |W (r - P e)|^2 + |e|^2 / s^2 over e is had by conjugate
//! gradients, as each product is one run of the filter there and back (M. R. Hestenes, E. Stiefel, J. Res. NBS 49, 1952). Of few edges a
//! turn the normal matrix itself, as it was in about the same noise, is the preconditioner; of many, on a shaft that turns evenly, it is
//! diagonal over orders. The size s is the one of most evidence.

use std::sync::Arc;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;
use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};

use super::bench::Bench;
use super::effect::{Carrier, Effect, On, Site};
use super::lsq::dot;

/// Orders at which what a turn's pattern is worth is worked out exactly.
const NODES: usize = 24;
/// Steps of conjugate gradients at the most.
const STEPS: usize = 40;
/// Part of the first residual that is small enough.
const SMALL: f64 = 1e-4;
/// Edges a turn up to which the normal matrix itself is worked out.
const DENSE: usize = 1024;
/// Factor by which what an order is worth may change before that is done anew.
const CHANGED: f64 = 10.0;

/// A pattern of a size.
#[derive(Clone)]
pub struct Pattern {
    /// Edges a turn.
    pub edges: usize,
    /// Variance of an edge's error, rad^2.
    pub size2: f64,
    /// What a pattern of unit size of each order is worth, sum of squares.
    worth: Vec<f64>,
    /// The normal matrix, of about the present noise, and what orders were worth then.
    normal: Option<Arc<(DMatrix<f64>, Vec<f64>)>>,
    /// The same with the pattern's size, decomposed.
    factor: Option<Arc<Cholesky<f64, Dyn>>>,
    forward: Arc<dyn RealToComplex<f64>>,
    back: Arc<dyn ComplexToReal<f64>>,
}

impl std::fmt::Debug for Pattern {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Pattern")
            .field("edges", &self.edges)
            .field("size2", &self.size2)
            .finish_non_exhaustive()
    }
}

impl Pattern {
    /// Of recordings of one disc, of unknown size; `before` is the same in another noise.
    #[must_use]
    pub fn new(benches: &[Bench], before: Option<&Self>) -> Option<Self> {
        let edges = usize::try_from(benches.first()?.record.edges).ok()?;
        let mut planner = RealFftPlanner::new();
        let mut pattern = Self {
            edges,
            size2: 0.0,
            worth: Vec::new(),
            normal: None,
            factor: None,
            forward: planner.plan_fft_forward(edges),
            back: planner.plan_fft_inverse(edges),
        };
        let orders = edges / 2 + 1;
        let nodes: Vec<(f64, f64)> = (0..NODES.min(orders - 1))
            .map(|node| {
                let share = node as f64 / (NODES.min(orders - 1).max(2) - 1) as f64;
                let order = ((orders as f64 - 1.0).powf(share)).round().max(1.0);
                let effect = Effect::new(Site::Disc(On::ALL), Carrier::Order(order));
                let squares: f64 = benches
                    .iter()
                    .map(|bench| {
                        let columns = bench.columns(&effect);
                        columns
                            .iter()
                            .map(|column| {
                                let white = bench.white(column);
                                dot(&white, &white)
                            })
                            .sum::<f64>()
                    })
                    .sum();
                (order.ln(), (squares / edges as f64).max(1e-300).ln())
            })
            .collect();
        pattern.worth = (0..orders)
            .map(|order| {
                if order == 0 {
                    1e-300
                } else {
                    between(&nodes, (order as f64).ln()).exp()
                }
            })
            .collect();
        let kept = before.and_then(|before| before.normal.clone());
        pattern.normal = match kept.filter(|kept| alike(&kept.1, &pattern.worth)) {
            Some(kept) => Some(kept),
            None if edges <= DENSE => {
                let rows = (0..edges).into_par_iter().map(|edge| {
                    let mut one = vec![0.0; edges];
                    one[edge] = 1.0;
                    pattern.fold(benches, &pattern.unfold(benches, &one))
                });
                let rows: Vec<Vec<f64>> = rows.collect();
                let matrix = DMatrix::from_fn(edges, edges, |row, column| {
                    0.5 * (rows[row][column] + rows[column][row])
                });
                Some(Arc::new((matrix, pattern.worth.clone())))
            }
            None => None,
        };
        Some(pattern)
    }

    /// Sets the variance of an edge's error, rad^2.
    pub fn set_size(&mut self, size2: f64) {
        self.size2 = size2;
        self.factor = None;
        if size2 > 0.0 {
            self.decompose();
        }
    }

    /// Decomposes the normal matrix for the present size.
    fn decompose(&mut self) {
        self.factor = self.normal.as_ref().and_then(|normal| {
            let (matrix, worth) = &**normal;
            let scale = self.worth.iter().sum::<f64>() / worth.iter().sum::<f64>();
            let mut matrix = matrix * scale;
            for at in 0..self.edges {
                matrix[(at, at)] += self.size2.recip();
            }
            Cholesky::new(matrix).map(Arc::new)
        });
    }

    /// Score of each edge of the grid: what one rad of its error adds.
    #[must_use]
    pub fn fold(&self, benches: &[Bench], white: &[f64]) -> Vec<f64> {
        let mut fold = vec![0.0; self.edges];
        let mut from = 0;
        for bench in benches {
            let until = from + bench.record.len();
            for (at, score) in bench.score(&white[from..until]).into_iter().enumerate() {
                fold[bench.record.slot(at)] += score;
            }
            from = until;
        }
        fold
    }

    /// Errors of the grid's edges as angles of each edge, white, in a row.
    fn unfold(&self, benches: &[Bench], errors: &[f64]) -> Vec<f64> {
        let each: Vec<Vec<f64>> = benches
            .iter()
            .map(|bench| {
                let raw: Vec<f64> = (0..bench.record.len())
                    .map(|at| errors[bench.record.slot(at)])
                    .collect();
                bench.white(&raw)
            })
            .collect();
        each.concat()
    }

    /// A row divided by the normal matrix: by itself, or over orders by what each is worth.
    fn divided(&self, row: &[f64]) -> Vec<f64> {
        if let Some(factor) = &self.factor {
            let row = DVector::from_column_slice(row);
            return factor.solve(&row).as_slice().to_vec();
        }
        let mut row = row.to_vec();
        let mut spectrum = self.forward.make_output_vec();
        if self.forward.process(&mut row, &mut spectrum).is_err() {
            return row;
        }
        for (value, worth) in spectrum.iter_mut().zip(&self.worth) {
            *value *= 1.0 / (worth + self.size2.recip()) / self.edges as f64;
        }
        self.real(spectrum)
    }

    fn real(&self, mut spectrum: Vec<Complex<f64>>) -> Vec<f64> {
        spectrum[0].im = 0.0;
        if self.edges.is_multiple_of(2)
            && let Some(last) = spectrum.last_mut()
        {
            last.im = 0.0;
        }
        let mut row = self.back.make_output_vec();
        if self.back.process(&mut spectrum, &mut row).is_err() {
            row.fill(0.0);
        }
        row
    }

    /// Sets the size to the one of most evidence, and returns that: twice the logarithm of the likelihood over that without a pattern.
    pub fn size_up(&mut self, benches: &[Bench], white: &[f64]) -> f64 {
        let mut fold = self.fold(benches, white);
        let mut spectrum = self.forward.make_output_vec();
        if self.forward.process(&mut fold, &mut spectrum).is_err() {
            return 0.0;
        }
        // Each order has two numbers; of unit-norm waves the score is the transform over sqrt(N).
        let powers: Vec<(f64, f64)> = spectrum
            .iter()
            .zip(&self.worth)
            .skip(1)
            .map(|(value, worth)| (value.norm_sqr() / self.edges as f64, *worth))
            .collect();
        let evidence = |size2: f64| -> f64 {
            powers
                .iter()
                .map(|(power, worth)| {
                    2.0 * (power / (worth + size2.recip())) - 2.0 * (worth * size2).ln_1p()
                })
                .sum()
        };
        let mut best = (0.0, 0.0);
        for step in 0..90 {
            let size2 = 10_f64.powf(-22.0 + 0.2 * f64::from(step));
            let here = evidence(size2);
            if here > best.1 {
                best = (size2, here);
            }
        }
        self.set_size(best.0);
        best.1
    }

    /// Twice the logarithm by which the recordings narrow the errors: of what the likelihood has for errors that are integrated out.
    #[must_use]
    pub fn log_volume(&self) -> f64 {
        let each = (1..self.worth.len()).map(|order| {
            let numbers = if 2 * order == self.edges { 1.0 } else { 2.0 };
            numbers * (self.worth[order] * self.size2).ln_1p()
        });
        each.sum()
    }

    /// Variance of a wave of unit size of an order, as prior and recordings leave it, rad^2.
    #[must_use]
    pub fn variance(&self, order: usize) -> f64 {
        let worth = self.worth.get(order).copied().unwrap_or(0.0);
        if self.size2 > 0.0 {
            1.0 / (worth + self.size2.recip())
        } else {
            0.0
        }
    }

    /// The errors that fit a white row best.
    #[must_use]
    pub fn errors(&self, benches: &[Bench], white: &[f64]) -> Vec<f64> {
        let mut errors = vec![0.0; self.edges];
        if self.size2 <= 0.0 {
            return errors;
        }
        let mut rest = self.fold(benches, white);
        let start = dot(&rest, &self.divided(&rest));
        let mut step = self.divided(&rest);
        let mut square = start;
        for _ in 0..STEPS {
            if square.is_nan() || square <= SMALL * SMALL * start {
                break;
            }
            let mut product = self.fold(benches, &self.unfold(benches, &step));
            product
                .iter_mut()
                .zip(&step)
                .for_each(|(product, of)| *product += of / self.size2);
            let along = square / dot(&step, &product);
            for at in 0..self.edges {
                errors[at] += along * step[at];
                rest[at] -= along * product[at];
            }
            let divided = self.divided(&rest);
            let next = dot(&rest, &divided);
            let by = next / square;
            square = next;
            step.iter_mut()
                .zip(divided)
                .for_each(|(step, of)| *step = of + by * *step);
        }
        errors
    }

    /// A white row without what a pattern explains of it, and the pattern's errors over its size behind it: products of such rows are
    /// those beside a pattern that is fitted with them.
    #[must_use]
    pub fn taken_off(&self, benches: &[Bench], mut white: Vec<f64>) -> Vec<f64> {
        let errors = self.errors(benches, &white);
        let shown = self.unfold(benches, &errors);
        white
            .iter_mut()
            .zip(shown)
            .for_each(|(white, of)| *white -= of);
        let size = self.size2.sqrt();
        white.extend(
            errors
                .iter()
                .map(|error| if size > 0.0 { -error / size } else { 0.0 }),
        );
        white
    }
}

/// Whether orders are worth about the same, but for a common factor.
fn alike(one: &[f64], other: &[f64]) -> bool {
    let ratios = one
        .iter()
        .zip(other)
        .skip(1)
        .map(|(one, other)| one / other);
    let (least, most) = ratios.fold((f64::INFINITY, 0.0_f64), |(least, most), ratio| {
        (least.min(ratio), most.max(ratio))
    });
    most < CHANGED * least
}

/// A value between nodes, straight; the ends go on.
fn between(nodes: &[(f64, f64)], at: f64) -> f64 {
    if nodes.len() < 2 {
        return nodes.first().map_or(-690.0, |node| node.1);
    }
    let next = nodes
        .partition_point(|(x, _)| *x <= at)
        .clamp(1, nodes.len() - 1);
    let ((x0, y0), (x1, y1)) = (nodes[next - 1], nodes[next]);
    if x1 > x0 {
        y0 + (y1 - y0) * ((at - x0) / (x1 - x0)).clamp(0.0, 1.0)
    } else {
        y0
    }
}
