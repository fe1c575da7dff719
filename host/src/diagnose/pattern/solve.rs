//! Errors of a disc's edges that fit best, and what they leave.
//!
//! With N unknown errors e of variance s^2 beside a model, the least of |W (r - P e)|^2 + |e|^2 / s^2 over e is had by conjugate
//! gradients, as each product is one run of the filter there and back (M. R. Hestenes, E. Stiefel, J. Res. NBS 49, 1952). The
//! normal matrix of the mean turn is the preconditioner. Of a disc with few edges the normal matrix itself is worked out and factorised
//! (Cholesky), which costs less than some of those solutions.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;
use realfft::RealFftPlanner;

use super::Pattern;
use crate::diagnose::bench::Bench;
use crate::diagnose::filter::SIDE_BY_SIDE;
use crate::diagnose::lsq::{add, dot};
use crate::diagnose::scan::spectrum;

/// Steps of conjugate gradients at the most.
const STEPS: usize = 40;
/// Edges a turn up to which the normal matrix is worked out: a column of it costs as much as a step of conjugate gradients.
const MATRIX: usize = 256;
/// Part of the first residual that is small enough.
pub const SMALL: f64 = 1e-5;
/// Part of what a pattern leaves of a row that is: of products of such rows it is the square of that.
pub const CLEAR: f64 = 1e-3;
/// What is as small as numbers allow: of what a fit leaves small parts count.
pub const SMALLER: f64 = 1e-9;

/// A disc's normal matrix without its prior, and of which benches in which noise: others have another one.
pub type Normal = (DMatrix<f64>, f64);

impl Pattern {
    fn normal(&self, benches: &[Bench], mark: f64) -> Normal {
        let count = self.edges;
        let mut ones = vec![vec![0.0; count]; count];
        (0..count).for_each(|edge| ones[edge][edge] = 1.0);
        let some = ones.par_chunks(SIDE_BY_SIDE);
        let some = some.map(|ones| self.fold_rows(benches, &self.unfold_rows(benches, ones)));
        let columns: Vec<Vec<f64>> = some.flatten().collect();
        let both = |a: usize, b: usize| 0.5 * (columns[a][b] + columns[b][a]);
        (DMatrix::from_fn(count, count, both), mark)
    }

    /// The factorised normal matrix with the prior, where there are few edges.
    fn factor(&self, benches: &[Bench]) -> Option<&Cholesky<f64, Dyn>> {
        if self.edges > MATRIX {
            return None;
        }
        let mark = benches.iter().map(Bench::mark).sum();
        let (normal, of) = self.normal.get_or_init(|| self.normal(benches, mark));
        if *of != mark {
            return None;
        }
        let factor = self.sized.get_or_init(|| {
            let mut matrix = normal.clone();
            // The prior is the same around the disc.
            let mut one = vec![0.0; self.edges];
            one[0] = 1.0;
            let prior = self.over_prior(&one);
            for column in 0..self.edges {
                for row in 0..self.edges {
                    matrix[(row, column)] += prior[(row + self.edges - column) % self.edges];
                }
            }
            Cholesky::new(matrix)
        });
        factor.as_ref()
    }

    /// What is known of each edge of the grid alone, 1/rad^2: less beside a gap; none worked out where there are many.
    pub fn known_of_each(&self, benches: &[Bench]) -> Option<Vec<f64>> {
        self.factor(benches)?;
        let (normal, _) = self.normal.get()?;
        Some(normal.diagonal().iter().copied().collect())
    }

    /// Score of each edge of the grid: what one rad of its error adds.
    pub fn fold(&self, benches: &[Bench], white: &[f64]) -> Vec<f64> {
        self.fold_rows(benches, &[white.to_vec()]).swap_remove(0)
    }

    /// The same of some rows.
    fn fold_rows(&self, benches: &[Bench], white: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut folds = vec![vec![0.0; self.edges]; white.len()];
        let mut from = 0;
        for bench in benches {
            let until = from + bench.record.len();
            let own = white.iter().map(|white| white[from..until].to_vec());
            let scores = bench.score_rows(own.collect());
            for (fold, scores) in folds.iter_mut().zip(scores) {
                for (at, score) in scores.into_iter().enumerate() {
                    fold[bench.record.slot(at)] += score;
                }
            }
            from = until;
        }
        folds
    }

    /// Errors of the grid's edges as angles of each edge, white, in a row.
    pub fn unfold(&self, benches: &[Bench], errors: &[f64]) -> Vec<f64> {
        self.unfold_rows(benches, &[errors.to_vec()]).swap_remove(0)
    }

    /// The same of some errors.
    fn unfold_rows(&self, benches: &[Bench], errors: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut all = vec![Vec::new(); errors.len()];
        for bench in benches {
            let raw = errors.iter().map(|errors| bench.record.shown(errors));
            let white = bench.white_rows(raw.collect());
            let each = all.iter_mut().zip(white);
            each.for_each(|(all, white)| all.extend(white));
        }
        all
    }

    /// The errors that fit a white row best, as closely as numbers allow.
    pub fn closest(&self, benches: &[Bench], white: &[f64]) -> Vec<f64> {
        self.errors_of(benches, &self.fold(benches, white), SMALLER)
    }

    /// The same of a folded score, until a part of it is left.
    pub fn errors_of(&self, benches: &[Bench], fold: &[f64], small: f64) -> Vec<f64> {
        let all = vec![(fold.to_vec(), 0.0)];
        self.errors_of_rows(benches, all, small).swap_remove(0)
    }

    /// The same of some folded scores, each with the square of its row, until a part of what is left of that or, of no row, of the score is
    /// left.
    pub(super) fn errors_of_rows(
        &self,
        benches: &[Bench],
        folds: Vec<(Vec<f64>, f64)>,
        small: f64,
    ) -> Vec<Vec<f64>> {
        if self.size2 <= 0.0 {
            return vec![vec![0.0; self.edges]; folds.len()];
        }
        let each = folds.into_iter();
        if let Some(factor) = self.factor(benches) {
            let each = each.map(|(fold, _)| factor.solve(&DVector::from_vec(fold)));
            return each.map(|solved| solved.as_slice().to_vec()).collect();
        }
        let mut all: Vec<Descent> = each
            .map(|(fold, whole)| Descent::new(self, fold, whole))
            .collect();
        for _ in 0..STEPS {
            let open = all.iter_mut().filter(|row| row.is_open(small));
            let mut open: Vec<&mut Descent> = open.collect();
            if open.is_empty() {
                break;
            }
            let steps: Vec<Vec<f64>> = open.iter().map(|row| row.step.clone()).collect();
            let mut products = self.fold_rows(benches, &self.unfold_rows(benches, &steps));
            for (row, product) in open.iter_mut().zip(&mut products) {
                add(product, 1.0, &self.over_prior(&row.step));
                row.go(self, product);
            }
        }
        all.into_iter().map(|row| row.errors).collect()
    }

    /// What one rad at each edge adds to a sum of squares that is least over errors of edges, from what it is beside these errors. Together,
    /// edges of one place say each error over the prior, and that exactly: their own sum is a small difference.
    pub fn scores(&self, benches: &[Bench], errors: &[f64], beside: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut hits = vec![0.0; self.edges];
        let mut off = self.over_prior(errors);
        for (bench, scores) in benches.iter().zip(beside) {
            for (at, score) in scores.iter().enumerate() {
                hits[bench.record.slot(at)] += 1.0;
                off[bench.record.slot(at)] -= score;
            }
        }
        let each = benches.iter().zip(beside).map(|(bench, scores)| {
            let each = scores.iter().enumerate();
            let each = each.map(|(at, score)| (bench.record.slot(at), score));
            each.map(|(slot, score)| score + off[slot] / hits[slot])
                .collect()
        });
        each.collect()
    }

    /// A white row without what a pattern explains of it, and the pattern's errors over the prior's root behind it: products of such rows are
    /// those beside a pattern that is fitted with them.
    pub fn taken_off(&self, benches: &[Bench], white: Vec<f64>) -> Vec<f64> {
        self.taken_off_rows(benches, vec![white], SMALLER)
            .swap_remove(0)
    }

    /// The same of some rows, with errors until a part of their score is left.
    pub fn taken_off_rows(
        &self,
        benches: &[Bench],
        mut white: Vec<Vec<f64>>,
        small: f64,
    ) -> Vec<Vec<f64>> {
        let folds = self.fold_rows(benches, &white);
        let wholes = white.iter().map(|white| dot(white, white));
        let folds = folds.into_iter().zip(wholes).collect();
        let errors = self.errors_of_rows(benches, folds, small);
        let shown = self.unfold_rows(benches, &errors);
        for ((white, shown), errors) in white.iter_mut().zip(shown).zip(errors) {
            add(white, -1.0, &shown);
            white.extend(self.over_root(&errors).into_iter().map(|over| -over));
        }
        white
    }

    /// The same of rows that are themselves of the disc, given as errors of its edges: what the pattern leaves of them is small, and is
    /// worked out as such.
    pub fn taken_off_disc(
        &self,
        benches: &[Bench],
        errors: &[Vec<f64>],
        small: f64,
    ) -> Vec<Vec<f64>> {
        let folds = errors.iter().map(|own| {
            let fold = self.over_prior(own);
            let whole = dot(own, &fold);
            (fold, whole)
        });
        let folds = folds.collect();
        let kept = self.errors_of_rows(benches, folds, small);
        let mut white = self.unfold_rows(benches, &kept);
        for ((white, errors), kept) in white.iter_mut().zip(errors).zip(&kept) {
            let rest = kept.iter().zip(errors);
            let rest: Vec<f64> = rest.map(|(kept, error)| kept - error).collect();
            white.extend(self.over_root(&rest));
        }
        white
    }

    /// Errors over the prior's variance.
    fn over_prior(&self, errors: &[f64]) -> Vec<f64> {
        self.times(errors, |order| self.prior(order).recip())
    }

    /// Errors over the root of the prior's variance.
    fn over_root(&self, errors: &[f64]) -> Vec<f64> {
        self.times(errors, |order| match self.prior(order) {
            prior if prior > 0.0 => prior.sqrt().recip(),
            _ => 0.0,
        })
    }

    /// A row divided by about the normal matrix with the prior.
    fn divided(&self, row: &[f64]) -> Vec<f64> {
        let mut divided = self.turn.divided(row);
        if !self.low.is_empty() {
            // The mean turn has the size alone: what orders may have on top comes by what they are worth.
            let more = self.times(row, |order| {
                let worth = self.worth[order];
                (worth + self.prior(order).recip()).recip() - (worth + self.size2.recip()).recip()
            });
            add(&mut divided, 1.0, &more);
        }
        divided
    }

    /// A row whose waves of each order are so many times as large.
    fn times(&self, row: &[f64], by: impl Fn(usize) -> f64) -> Vec<f64> {
        if self.low.is_empty() {
            let by = by(0);
            return row.iter().map(|value| by * value).collect();
        }
        let mut spectrum = spectrum(row.to_vec());
        for (order, value) in spectrum.iter_mut().enumerate() {
            *value *= by(order) / self.edges as f64;
        }
        // The ends are real, up to digits.
        spectrum[0].im = 0.0;
        if self.edges.is_multiple_of(2) {
            spectrum[self.edges / 2].im = 0.0;
        }
        let back = RealFftPlanner::new().plan_fft_inverse(self.edges);
        let mut times = back.make_output_vec();
        let _ = back.process(&mut spectrum, &mut times);
        times
    }
}

/// Errors on the way to those that fit a folded score best, by conjugate gradients.
struct Descent {
    errors: Vec<f64>,
    rest: Vec<f64>,
    step: Vec<f64>,
    /// Square of the rest over the preconditioner, and at the start.
    square: f64,
    start: f64,
    /// Square of the row whose score it was, less what the errors explain of it; 0 of no row.
    left: f64,
}

impl Descent {
    fn new(pattern: &Pattern, rest: Vec<f64>, whole: f64) -> Self {
        let step = pattern.divided(&rest);
        let start = dot(&rest, &step);
        Self {
            errors: vec![0.0; rest.len()],
            rest,
            step,
            square: start,
            start,
            left: whole,
        }
    }

    /// Whether more than a part is left.
    fn is_open(&self, small: f64) -> bool {
        let whole = if self.left > 0.0 {
            self.left
        } else {
            self.start
        };
        let least = SMALLER * SMALLER * self.start;
        self.square > f64::max(small * small * whole, least)
    }

    /// Goes on by the step, whose product with the normal matrix this is.
    fn go(&mut self, pattern: &Pattern, product: &[f64]) {
        let along = self.square / dot(&self.step, product);
        self.left = f64::max(self.left - along * self.square, 0.0);
        add(&mut self.errors, along, &self.step);
        add(&mut self.rest, -along, product);
        let divided = pattern.divided(&self.rest);
        let next = dot(&self.rest, &divided);
        let by = next / self.square;
        self.square = next;
        let each = self.step.iter_mut().zip(divided);
        each.for_each(|(step, of)| *step = of + by * *step);
    }
}
