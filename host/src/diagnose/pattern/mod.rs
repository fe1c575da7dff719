//! The disc's own pattern: an unknown error of each edge of the grid, small beside a known size, that every turn repeats.
//!
//! With N unknown errors e of variance s^2 beside a model, the least of |W (r - P e)|^2 + |e|^2 / s^2 over e is had by conjugate
//! gradients, as each product is one run of the filter there and back (M. R. Hestenes, E. Stiefel, J. Res. NBS 49, 1952). The
//! normal matrix of the mean turn is the preconditioner. Of a disc with few edges the normal matrix itself is worked out and factorised
//! (Cholesky), which costs less than some of those solutions. The size s is that of most evidence.

use std::sync::{Arc, OnceLock};

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;
use realfft::{RealFftPlanner, RealToComplex};

use super::bench::Bench;
use super::effect::{Carrier, Effect, On, Site};
use super::filter::SIDE_BY_SIDE;
use super::lsq::dot;
use super::mean_turn::MeanTurn;

/// Orders at which what a turn's pattern is worth is worked out exactly.
const NODES: usize = 24;
/// Steps of conjugate gradients at the most.
const STEPS: usize = 40;
/// Size of an edge's error to begin with and at the most, as a part of a pitch: edges keep their order.
pub const LARGE: f64 = 0.3;
/// A size that is none, rad; rounds in which it is found, and the change of its square's logarithm that is none.
const SMALLEST: f64 = 1e-10;
/// Orders that are too few for a middle one.
const FEW: usize = 8;
const SIZED: usize = 20;
const SAME: f64 = 0.02;
/// Edges a turn up to which the normal matrix is worked out: a column of it costs as much as a step of conjugate gradients.
const MATRIX: usize = 128;
/// Share of the change before that a change is taken for at the most.
const FADES: f64 = 0.8;
/// Part of the first residual that is small enough, and what is as small as numbers allow.
const SMALL: f64 = 1e-5;
const SMALLER: f64 = 1e-9;

/// A pattern of a size.
#[derive(Clone)]
pub struct Pattern {
    /// Edges a turn.
    pub edges: usize,
    /// Variance of an edge's error, rad^2.
    pub size2: f64,
    /// Whether a few edges may be all that is off.
    pub sparse: bool,
    /// Whether that is how well the twins know their disc, and not what fits best.
    pub known: bool,
    /// What a pattern of unit size of each order is worth, sum of squares.
    worth: Vec<f64>,
    forward: Arc<dyn RealToComplex<f64>>,
    turn: MeanTurn,
    /// The normal matrix of few edges, and with the size.
    normal: OnceLock<Normal>,
    sized: OnceLock<Option<Cholesky<f64, Dyn>>>,
}

/// A disc's normal matrix without its prior.
#[derive(Clone)]
struct Normal {
    matrix: DMatrix<f64>,
    /// Of which benches in which noise.
    mark: f64,
}

impl Normal {
    fn of(pattern: &Pattern, benches: &[Bench]) -> Self {
        let count = pattern.edges;
        let mut ones = vec![vec![0.0; count]; count];
        (0..count).for_each(|edge| ones[edge][edge] = 1.0);
        let some = ones.par_chunks(SIDE_BY_SIDE);
        let some = some.map(|ones| pattern.fold_rows(benches, &pattern.unfold_rows(benches, ones)));
        let columns: Vec<Vec<f64>> = some.flatten().collect();
        let matrix = DMatrix::from_fn(count, count, |a, b| 0.5 * (columns[a][b] + columns[b][a]));
        Self {
            matrix,
            mark: Self::mark(benches),
        }
    }

    /// Other benches, or the same in another noise, have another one.
    fn mark(benches: &[Bench]) -> f64 {
        benches.iter().map(Bench::mark).sum()
    }
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
    /// Of recordings of one disc, without a size.
    #[must_use]
    pub fn new(benches: &[Bench]) -> Option<Self> {
        let edges = usize::try_from(benches.first()?.record.edges).ok()?;
        let mut planner = RealFftPlanner::new();
        Some(Self {
            edges,
            size2: 0.0,
            sparse: true,
            known: false,
            worth: Self::worths(benches, edges),
            forward: planner.plan_fft_forward(edges),
            turn: MeanTurn::new(benches, edges),
            normal: OnceLock::new(),
            sized: OnceLock::new(),
        })
    }

    /// One of the same size, of recordings with other edges of the disc.
    #[must_use]
    pub fn along(&self, benches: &[Bench]) -> Option<Self> {
        let mut pattern = Self::new(benches)?;
        pattern.known = self.known;
        pattern.sparse = self.sparse;
        pattern.set_size(self.size2);
        Some(pattern)
    }

    /// Works out anew what orders are worth: in another noise, or of other recordings.
    pub fn weigh(&mut self, benches: &[Bench]) {
        self.worth = Self::worths(benches, self.edges);
        self.turn = MeanTurn::new(benches, self.edges);
        self.normal = OnceLock::new();
        self.set_size(self.size2);
    }

    /// The factorised normal matrix with the prior, where there are few edges.
    fn factor(&self, benches: &[Bench]) -> Option<&Cholesky<f64, Dyn>> {
        if self.edges > MATRIX {
            return None;
        }
        let normal = self.normal.get_or_init(|| Normal::of(self, benches));
        if normal.mark != Normal::mark(benches) {
            return None;
        }
        let factor = self.sized.get_or_init(|| {
            let mut matrix = normal.matrix.clone();
            (0..self.edges).for_each(|at| matrix[(at, at)] += self.size2.recip());
            Cholesky::new(matrix)
        });
        factor.as_ref()
    }

    fn worths(benches: &[Bench], edges: usize) -> Vec<f64> {
        let orders = edges / 2 + 1;
        let count = NODES.min(orders - 1);
        let nodes = (0..count).into_par_iter().map(|node| {
            let share = node as f64 / (count.max(2) - 1) as f64;
            let order = ((orders as f64 - 1.0).powf(share)).round().max(1.0);
            let effect = Effect::new(Site::Disc(On::ALL), Carrier::Order(order));
            let columns = benches.iter().flat_map(|bench| {
                let columns = bench.columns(&effect);
                let square = |column: &Vec<f64>| {
                    let white = bench.white(column);
                    dot(&white, &white)
                };
                columns.iter().map(square).collect::<Vec<_>>()
            });
            let worth = columns.sum::<f64>() / edges as f64;
            (order.ln(), worth.max(1e-300).ln())
        });
        let nodes: Vec<(f64, f64)> = nodes.collect();
        let at = |order: usize| match order {
            0 => 1e-300,
            _ => between(&nodes, (order as f64).ln()).exp(),
        };
        (0..orders).map(at).collect()
    }

    /// Of a disc whose errors are known but for a variance, rad^2.
    #[must_use]
    pub fn known(benches: &[Bench], size2: f64) -> Option<Self> {
        let mut pattern = Self::new(benches)?;
        pattern.known = true;
        pattern.set_size(size2);
        Some(pattern)
    }

    fn set_size(&mut self, size2: f64) {
        self.size2 = size2;
        self.sized = OnceLock::new();
        self.turn.set_size(size2);
    }

    /// Score of each edge of the grid: what one rad of its error adds.
    #[must_use]
    pub fn fold(&self, benches: &[Bench], white: &[f64]) -> Vec<f64> {
        let rows = [white.to_vec()];
        self.fold_rows(benches, &rows).swap_remove(0)
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
        let rows = [errors.to_vec()];
        self.unfold_rows(benches, &rows).swap_remove(0)
    }

    /// The same of some errors.
    fn unfold_rows(&self, benches: &[Bench], errors: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut all = vec![Vec::new(); errors.len()];
        for bench in benches {
            let raw = errors.iter().map(|errors| {
                let slots = (0..bench.record.len()).map(|at| bench.record.slot(at));
                slots.map(|slot| errors[slot]).collect()
            });
            let white = bench.white_rows(raw.collect());
            let each = all.iter_mut().zip(white);
            each.for_each(|(all, white)| all.extend(white));
        }
        all
    }

    /// Sets the size to the one of most orders, and returns its evidence: twice the logarithm of the likelihood over that without a
    /// pattern. A few orders that stand out do not make it larger: they are told as what they are.
    pub fn size_up(&mut self, benches: &[Bench], white: &[f64]) -> f64 {
        let fold = self.fold(benches, white);
        let worth_of = |own: &Self| {
            dot(&fold, &own.errors_of(benches, fold.clone(), SMALL)) - own.log_volume()
        };
        if self.known {
            return worth_of(self);
        }
        let most = (LARGE * std::f64::consts::TAU / self.edges as f64).powi(2);
        let start2 = if self.size2 > 0.0 {
            (4.0 * self.size2).min(most)
        } else {
            most
        };
        // Few orders that stand out are told from the others; few edges that do are in all orders.
        let (mut best2, mut best) = (0.0, 0.0);
        let ways = [Self::middle, Self::mean];
        for of in &ways[..if self.sparse { 2 } else { 1 }] {
            let mut size2 = start2;
            let mut before = 0.0;
            for _ in 0..SIZED {
                self.set_size(size2);
                let errors = self.errors_of(benches, fold.clone(), SMALL);
                let next = of(&self.powers(&errors)).clamp(SMALLEST * SMALLEST, most);
                let change = (next / size2).ln();
                // Changes that shrink alike add up to this (A. C. Aitken, Proc. R. Soc. Edinburgh 46, 1926).
                let share: f64 = if before == 0.0 { 0.0 } else { change / before };
                let whole = if share > 0.0 {
                    change / (1.0 - share.min(FADES))
                } else {
                    change
                };
                before = if share > 0.0 { 0.0 } else { change };
                size2 = (size2 * whole.exp()).min(most);
                if whole.abs() < SAME || size2 <= SMALLEST * SMALLEST {
                    break;
                }
            }
            self.set_size(size2);
            let worth = worth_of(self);
            if worth > best {
                (best2, best) = (size2, worth);
            }
        }
        self.set_size(best2);
        best
    }

    /// Of each order how much of it the recordings settle, its numbers, and its power as the errors have it.
    fn powers(&self, errors: &[f64]) -> Vec<[f64; 3]> {
        let mut row = errors.to_vec();
        let mut spectrum = self.forward.make_output_vec();
        if self.forward.process(&mut row, &mut spectrum).is_err() {
            return Vec::new();
        }
        let each = self.settled().zip(&spectrum[1..]).enumerate();
        each.map(|(at, (settled, value))| {
            let numbers = self.numbers(at + 1);
            [
                settled / numbers,
                numbers,
                value.norm_sqr() / self.edges as f64,
            ]
        })
        .collect()
    }

    /// Mean variance of an edge's error over the orders as far as the recordings settle them.
    fn mean(powers: &[[f64; 3]]) -> f64 {
        let each = powers.iter();
        let (settled, power) = each.fold((0.0, 0.0), |sum, [share, numbers, power]| {
            (sum.0 + numbers * share, sum.1 + numbers * power)
        });
        power / f64::max(settled, f64::MIN_POSITIVE)
    }

    /// Variance of an edge's error that is the middle one over the orders that the recordings settle; of few orders the mean.
    fn middle(powers: &[[f64; 3]]) -> f64 {
        let clear = powers.iter().filter(|[share, ..]| *share > 0.5);
        let mut clear: Vec<f64> = clear.map(|[share, _, power]| power / share).collect();
        if clear.len() < FEW {
            return Self::mean(powers);
        }
        let middle = clear.len() / 2;
        let (_, middle, _) = clear.select_nth_unstable_by(middle, f64::total_cmp);
        *middle / std::f64::consts::LN_2
    }

    /// Of each order how much of its numbers the recordings settle.
    fn settled(&self) -> impl Iterator<Item = f64> + '_ {
        (1..self.worth.len()).map(|order| {
            let shown = self.worth[order] * self.size2;
            self.numbers(order) * shown / (1.0 + shown)
        })
    }

    /// Numbers of an order.
    const fn numbers(&self, order: usize) -> f64 {
        if 2 * order == self.edges { 1.0 } else { 2.0 }
    }

    /// Twice the logarithm by which the recordings narrow the errors: of what the likelihood has for errors that are integrated out.
    #[must_use]
    pub fn log_volume(&self) -> f64 {
        let each = (1..self.worth.len())
            .map(|order| self.numbers(order) * (self.worth[order] * self.size2).ln_1p());
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
        self.errors_of(benches, self.fold(benches, white), SMALL)
    }

    /// The same, as closely as numbers allow.
    #[must_use]
    pub fn closest(&self, benches: &[Bench], white: &[f64]) -> Vec<f64> {
        self.errors_of(benches, self.fold(benches, white), SMALLER)
    }

    /// The same of a folded score, until a part of it is left.
    fn errors_of(&self, benches: &[Bench], fold: Vec<f64>, small: f64) -> Vec<f64> {
        self.errors_of_rows(benches, vec![fold], small)
            .swap_remove(0)
    }

    /// The same of some folded scores.
    fn errors_of_rows(&self, benches: &[Bench], folds: Vec<Vec<f64>>, small: f64) -> Vec<Vec<f64>> {
        if self.size2 <= 0.0 {
            return vec![vec![0.0; self.edges]; folds.len()];
        }
        if let Some(factor) = self.factor(benches) {
            let each = folds.into_iter();
            let each = each.map(|fold| factor.solve(&DVector::from_vec(fold)));
            return each.map(|solved| solved.as_slice().to_vec()).collect();
        }
        let each = folds.into_iter();
        let mut all: Vec<Descent> = each.map(|fold| Descent::new(&self.turn, fold)).collect();
        for _ in 0..STEPS {
            let mut open: Vec<&mut Descent> =
                all.iter_mut().filter(|row| row.is_open(small)).collect();
            if open.is_empty() {
                break;
            }
            let steps: Vec<Vec<f64>> = open.iter().map(|row| row.step.clone()).collect();
            let mut products = self.fold_rows(benches, &self.unfold_rows(benches, &steps));
            for (row, product) in open.iter_mut().zip(&mut products) {
                product
                    .iter_mut()
                    .zip(&row.step)
                    .for_each(|(product, of)| *product += of / self.size2);
                row.go(&self.turn, product);
            }
        }
        all.into_iter().map(|row| row.errors).collect()
    }

    /// What one rad at each edge adds, as errors of edges say it, to a sum of squares that is least over them: of those of one place
    /// together each error over the size's square.
    #[must_use]
    pub fn scores(&self, benches: &[Bench], errors: &[f64]) -> Vec<Vec<f64>> {
        let mut hits = vec![0.0; self.edges];
        for bench in benches {
            (0..bench.record.len()).for_each(|at| hits[bench.record.slot(at)] += 1.0);
        }
        let of_bench = |bench: &Bench| {
            let slots = (0..bench.record.len()).map(|at| bench.record.slot(at));
            slots
                .map(|slot| errors[slot] / self.size2 / hits[slot])
                .collect()
        };
        benches.iter().map(of_bench).collect()
    }

    /// A white row without what a pattern explains of it, and the pattern's errors over its size behind it: products of such rows are
    /// those beside a pattern that is fitted with them.
    #[must_use]
    pub fn taken_off(&self, benches: &[Bench], white: Vec<f64>) -> Vec<f64> {
        self.taken_off_rows(benches, vec![white]).swap_remove(0)
    }

    /// The same of some rows.
    #[must_use]
    pub fn taken_off_rows(&self, benches: &[Bench], white: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        self.without(benches, white, SMALL)
    }

    /// The same as closely as numbers allow: of what a fit leaves small parts count.
    #[must_use]
    pub fn closely_taken_off(&self, benches: &[Bench], white: Vec<f64>) -> Vec<f64> {
        self.without(benches, vec![white], SMALLER).swap_remove(0)
    }

    fn without(&self, benches: &[Bench], mut white: Vec<Vec<f64>>, small: f64) -> Vec<Vec<f64>> {
        let folds = self.fold_rows(benches, &white);
        let errors = self.errors_of_rows(benches, folds, small);
        let shown = self.unfold_rows(benches, &errors);
        let size = self.size2.sqrt();
        for ((white, shown), errors) in white.iter_mut().zip(shown).zip(errors) {
            white
                .iter_mut()
                .zip(shown)
                .for_each(|(white, of)| *white -= of);
            let over = |error: f64| if size > 0.0 { -error / size } else { 0.0 };
            white.extend(errors.into_iter().map(over));
        }
        white
    }

    /// The same of rows that are themselves of the disc, given as errors of its edges: what the pattern leaves of them is small, and is
    /// worked out as such.
    #[must_use]
    pub fn taken_off_disc(&self, benches: &[Bench], errors: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let over = |errors: &Vec<f64>| errors.iter().map(|error| error / self.size2).collect();
        let folds: Vec<Vec<f64>> = errors.iter().map(over).collect();
        let kept = self.errors_of_rows(benches, folds, SMALL);
        let mut white = self.unfold_rows(benches, &kept);
        let size = self.size2.sqrt();
        for ((white, errors), kept) in white.iter_mut().zip(errors).zip(&kept) {
            let rest = errors.iter().zip(kept);
            white.extend(rest.map(|(error, kept)| (kept - error) / size));
        }
        white
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
}

impl Descent {
    fn new(turn: &MeanTurn, rest: Vec<f64>) -> Self {
        let step = turn.divided(&rest);
        let start = dot(&rest, &step);
        Self {
            errors: vec![0.0; rest.len()],
            rest,
            step,
            square: start,
            start,
        }
    }

    /// Whether more than a part of the start is left.
    fn is_open(&self, small: f64) -> bool {
        self.square > small * small * self.start
    }

    /// Goes on by the step, whose product with the normal matrix this is.
    fn go(&mut self, turn: &MeanTurn, product: &[f64]) {
        let along = self.square / dot(&self.step, product);
        let errors = self.errors.iter_mut().zip(&self.step);
        errors.for_each(|(error, step)| *error += along * step);
        let rest = self.rest.iter_mut().zip(product);
        rest.for_each(|(rest, product)| *rest -= along * product);
        let divided = turn.divided(&self.rest);
        let next = dot(&self.rest, &divided);
        let by = next / self.square;
        self.square = next;
        self.step
            .iter_mut()
            .zip(divided)
            .for_each(|(step, of)| *step = of + by * *step);
    }
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
