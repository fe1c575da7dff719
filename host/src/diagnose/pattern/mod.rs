//! The disc's own pattern: an unknown error of each edge of the grid, small beside a known size, that every turn repeats. The size is that
//! of most evidence.

mod solve;

use std::f64::consts::TAU;
use std::sync::OnceLock;

use nalgebra::{Cholesky, Dyn};
use rayon::prelude::*;

use super::bench::Bench;
use super::edges::median;
use super::effect::{Carrier, Effect, On, Site};
use super::lsq::dot;
use super::mean_turn::MeanTurn;
use super::scan::spectrum;
use super::spread::Spread;
use solve::Normal;
pub use solve::{CLEAR, SMALL, SMALLER};

/// Orders at which what a turn's pattern is worth is worked out exactly.
const NODES: usize = 24;
/// Orders at which what is left open of them is.
const SOLVED: usize = 10;
/// Size of an edge's error to begin with and at the most, as a part of a pitch: edges keep their order.
pub const LARGE: f64 = 0.3;
/// Square of a size that is none, rad^2.
const SMALLEST2: f64 = 1e-10 * 1e-10;

/// A pattern of a size.
#[derive(Clone, Debug)]
pub struct Pattern {
    /// Edges a turn.
    pub edges: usize,
    /// Variance of an edge's error, rad^2, and what waves of unit size of orders 0, 1, .. have on top; empty where they have nothing.
    pub size2: f64,
    low: Vec<f64>,
    /// Whether a few edges may be all that is off.
    pub sparse: bool,
    /// Whether that is how well the twins know their disc, and not what fits best.
    pub known: bool,
    /// What a pattern of unit size of each order is worth, sum of squares.
    worth: Vec<f64>,
    turn: MeanTurn,
    /// The normal matrix of few edges, and with the size.
    normal: OnceLock<Normal>,
    sized: OnceLock<Option<Cholesky<f64, Dyn>>>,
}

impl Pattern {
    /// Of recordings of one disc, without a size.
    pub fn new(benches: &[Bench]) -> Option<Self> {
        let edges = usize::try_from(benches.first()?.record.edges).ok()?;
        Some(Self {
            edges,
            size2: 0.0,
            low: Vec::new(),
            sparse: true,
            known: false,
            worth: Self::worths(benches, edges),
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
        pattern.low.clone_from(&self.low);
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

    fn worths(benches: &[Bench], edges: usize) -> Vec<f64> {
        let nodes = nodes(edges, NODES).into_par_iter().map(|order| {
            let order = order as f64;
            let effect = Effect::new(Site::Disc(On::ALL), Carrier::Order(order));
            let white = benches
                .iter()
                .flat_map(|bench| bench.white_rows(bench.columns(&effect).to_vec()));
            let worth = white.map(|white| dot(&white, &white)).sum::<f64>() / edges as f64;
            (order.ln(), worth.max(1e-300).ln())
        });
        let nodes: Vec<(f64, f64)> = nodes.collect();
        through(&nodes, edges)
    }

    /// Of a disc whose errors are known so well.
    pub fn known(benches: &[Bench], spread: &Spread) -> Option<Self> {
        let mut pattern = Self::new(benches)?;
        pattern.known = true;
        let edge2 = spread.edge_rad.powi(2);
        if !spread.waves_rad.is_empty() {
            let variances = spread.variances(pattern.edges).into_iter();
            pattern.low = variances.map(|variance| variance - edge2).collect();
        }
        pattern.set_size(edge2.max(SMALLEST2));
        Some(pattern)
    }

    fn set_size(&mut self, size2: f64) {
        self.size2 = size2;
        self.sized = OnceLock::new();
        self.turn.set_size(size2);
    }

    /// Sets the size to the one of most orders, and returns its evidence: twice the logarithm of the likelihood over that without a
    /// pattern. A few orders that stand out do not make it larger: they are told as what they are.
    pub fn size_up(&mut self, benches: &[Bench], white: &[f64]) -> f64 {
        let fold = self.fold(benches, white);
        let worth_of =
            |own: &Self| dot(&fold, &own.errors_of(benches, &fold, SMALL)) - own.log_volume();
        if self.known {
            return worth_of(self);
        }
        let most = (LARGE * TAU / self.edges as f64).powi(2);
        let start2 = match self.size2 {
            size2 if size2 > 0.0 => (4.0 * size2).min(most),
            _ => most,
        };
        // Few orders that stand out are told from the others; few edges that do are in all orders.
        let (mut best2, mut best) = (0.0, 0.0);
        let ways = [Self::middle, Self::mean];
        for of in &ways[..if self.sparse { 2 } else { 1 }] {
            self.set_size(start2);
            self.settle(most, |own| {
                of(&own.powers(&own.errors_of(benches, &fold, SMALL)))
            });
            let worth = worth_of(self);
            if worth > best {
                (best2, best) = (self.size2, worth);
            }
        }
        self.set_size(best2);
        best
    }

    /// Sets the size's square, up to the most, to the one that the errors have with it.
    fn settle(&mut self, most: f64, next: impl Fn(&Self) -> f64) {
        let mut before = 0.0;
        // Twenty rounds bound the time.
        for _ in 0..20 {
            let change = (next(self).clamp(SMALLEST2, most) / self.size2).ln();
            // Changes that shrink alike add up to this (A. C. Aitken, Proc. R. Soc. Edinburgh 46, 1926), of shares up to 0.8.
            let share: f64 = if before == 0.0 { 0.0 } else { change / before };
            let whole;
            (whole, before) = match share > 0.0 {
                true => (change / (1.0 - share.min(0.8)), 0.0),
                false => (change, change),
            };
            self.set_size((self.size2 * whole.exp()).min(most));
            // A change of a fiftieth is none.
            if whole.abs() < 0.02 || self.size2 <= SMALLEST2 {
                break;
            }
        }
    }

    /// Of each order how much of it the recordings settle, its numbers, and its power as the errors have it.
    fn powers(&self, errors: &[f64]) -> Vec<[f64; 3]> {
        let spectrum = spectrum(errors.to_vec());
        let each = self.settled().zip(&spectrum[1..]).enumerate();
        each.map(|(at, (settled, value))| {
            let (numbers, power) = (self.numbers(at + 1), value.norm_sqr());
            [settled / numbers, numbers, power / self.edges as f64]
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
        let clear: Vec<f64> = clear.map(|[share, _, power]| power / share).collect();
        // Of few orders the middle one is any.
        if clear.len() < 8 {
            return Self::mean(powers);
        }
        median(clear).unwrap_or_default() / std::f64::consts::LN_2
    }

    /// Variance of a wave of unit size of an order before any recording, rad^2.
    fn prior(&self, order: usize) -> f64 {
        self.size2 + self.low.get(order).copied().unwrap_or(0.0)
    }

    /// Of each order how much of its numbers the recordings settle.
    fn settled(&self) -> impl Iterator<Item = f64> + '_ {
        (1..self.worth.len()).map(|order| {
            let shown = self.worth[order] * self.prior(order);
            self.numbers(order) * shown / (1.0 + shown)
        })
    }

    /// Numbers of an order.
    const fn numbers(&self, order: usize) -> f64 {
        if 2 * order == self.edges { 1.0 } else { 2.0 }
    }

    /// Twice the logarithm by which the recordings narrow the errors: of what the likelihood has for errors that are integrated out.
    pub fn log_volume(&self) -> f64 {
        let each = (1..self.worth.len())
            .map(|order| self.numbers(order) * (self.worth[order] * self.prior(order)).ln_1p());
        each.sum()
    }

    /// Variances of a wave of unit size of orders 0, 1, .., as prior and recordings leave them beside all other orders, rad^2.
    pub fn variances(&self, benches: &[Bench]) -> Vec<f64> {
        if self.size2 <= 0.0 {
            return vec![0.0; self.edges / 2 + 1];
        }
        let orders = nodes(self.edges, SOLVED);
        // Of marks that are not there nothing is known, and nobody asks.
        let mut seen = vec![0.0; self.edges];
        for bench in benches {
            (0..bench.record.len()).for_each(|at| seen[bench.record.slot(at)] = 1.0);
        }
        let wave = |order: &usize| -> Vec<f64> {
            let each = seen.iter().enumerate().map(|(edge, seen)| {
                let turns = (order * edge % self.edges) as f64 / self.edges as f64;
                seen * (turns * TAU).cos()
            });
            let wave: Vec<f64> = each.collect();
            let size = dot(&wave, &wave).sqrt().max(f64::MIN_POSITIVE);
            wave.into_iter().map(|value| value / size).collect()
        };
        let waves: Vec<Vec<f64>> = orders.iter().map(wave).collect();
        let folds = waves.iter().map(|wave| (wave.clone(), 0.0));
        let solved = self.errors_of_rows(benches, folds.collect(), SMALL);
        let each = orders.iter().zip(waves.iter().zip(&solved));
        let nodes = each.map(|(order, (wave, solved))| {
            let variance = dot(wave, solved).max(f64::MIN_POSITIVE);
            ((*order as f64).ln(), variance.ln())
        });
        through(&nodes.collect::<Vec<_>>(), self.edges)
    }

    /// About the variance of a wave of unit size of an order, as prior and recordings leave it, rad^2.
    pub fn variance(&self, order: usize) -> f64 {
        let worth = self.worth.get(order).copied().unwrap_or(0.0);
        if self.size2 > 0.0 {
            1.0 / (worth + self.prior(order).recip())
        } else {
            0.0
        }
    }
}

/// Some orders of a disc with so many edges, each by about the same factor more than the one before.
fn nodes(edges: usize, most: usize) -> Vec<usize> {
    let orders = edges / 2;
    let count = most.min(orders);
    let each = (0..count).map(|node| {
        let share = node as f64 / (count.max(2) - 1) as f64;
        (orders as f64).powf(share).round().max(1.0) as usize
    });
    each.collect()
}

/// Values of all orders of a disc with so many edges through logarithms of some orders and of theirs.
fn through(nodes: &[(f64, f64)], edges: usize) -> Vec<f64> {
    let at = |order: usize| match order {
        0 => 1e-300,
        _ => between(nodes, (order as f64).ln()).exp(),
    };
    (0..=edges / 2).map(at).collect()
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
