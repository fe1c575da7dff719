//! What holds on turns that it was not fitted on, and how well.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::effect::{Carrier, Effect, is_exact};
use super::lsq::{self, dot};
use super::model::{Board, Fit};
use super::scan::{SURE, evidence};

/// Blocks that are left out in turn.
const BLOCKS: usize = 4;
/// Share of what a finding shows in one block from which on the others can't foretell it.
const ONCE: f64 = 0.7;
/// Weight of what all blocks say in a fit to some of them.
const KEPT: f64 = 0.01;
/// Part of what a finding shows that other turns have to foretell of it.
const FORETELLS: f64 = 0.6;
/// Blocks in which a whole order may have sizes of its own: an order that slips by less than two turns against it where it shows is not told
/// from it.
const SLIPS: usize = 8;
/// Share of each recording that is held out for the figures of the fit: its last part.
pub const HELD_OUT: f64 = 0.3;

/// Products of a fit's columns and target over some rows.
#[derive(Clone, Debug)]
struct Products {
    gram: DMatrix<f64>,
    right: DVector<f64>,
    square: f64,
}

/// Rows of a fit in parts, to fit some and judge on others.
#[derive(Clone, Debug)]
pub struct Parts {
    /// Products of each part; what belongs to no turn is in all fits.
    parts: Vec<Products>,
    always: Products,
    /// The fit's own numbers as its columns have them: sizes, and no change of the knobs.
    sizes: DVector<f64>,
    of: Vec<(usize, usize)>,
}

/// Rows of each part of each recording, by the shares of what weighs its rows, at which parts end; in a stacked row.
fn parts(
    board: &Board,
    bounds: &[f64],
    weighs: &dyn Fn(usize) -> f64,
) -> Vec<Vec<std::ops::Range<usize>>> {
    let mut all = vec![Vec::new(); bounds.len() - 1];
    let mut from = 0;
    for bench in &board.benches {
        let count = bench.record.len();
        let mut sums = vec![0.0];
        for at in from..from + count {
            sums.push(sums[at - from] + weighs(at));
        }
        let at = |share: f64| {
            let until = share * sums[count];
            from + sums.partition_point(|sum| *sum < until).min(count)
        };
        for (part, pair) in bounds.windows(2).enumerate() {
            all[part].push(at(pair[0])..at(pair[1]));
        }
        from += count;
    }
    all
}

/// What a group does on turns that no term was fitted on.
#[derive(Clone, Copy, Debug, Default)]
pub struct Foretold {
    /// By how much the sum of squares falls with it.
    pub fall: f64,
    /// By how much it falls on the same turns where all are fitted on all: what the group shows there.
    pub shown: f64,
    /// The sum of squares without it.
    without: f64,
}

impl Foretold {
    /// RMS with the group over RMS without it.
    #[must_use]
    pub fn rms_ratio(&self) -> f64 {
        let without = self.without.max(f64::MIN_POSITIVE);
        (1.0 - self.fall / without).max(0.0).sqrt()
    }
}

/// Whether so much of what shows is foretold that it is said.
#[must_use]
pub fn foretells(foretold: f64, shown: f64) -> bool {
    foretold >= FORETELLS * shown - SURE
}

/// Whether a group of a fit shows more than once, and is foretold on turns that it was not fitted on.
#[must_use]
pub fn recurs(board: &Board, fit: &Fit, group: usize) -> bool {
    let Foretold { fall, shown, .. } = Parts::of_group(board, fit, group).foretold(fit, group);
    foretells(fall, shown) && !Parts::blocks(board, fit).only_once(fit, group)
}

/// Bounds of blocks that are alike.
fn bounds(count: usize) -> Vec<f64> {
    (0..=count).map(|at| at as f64 / count as f64).collect()
}

/// The whole order whose sideband a group's order, with its harmonics, may be: a part of each turn that comes and goes, or turns its phase,
/// along the recording shows as an order beside it. Its sizes in each of some blocks have more evidence then.
#[must_use]
pub fn sideband_of(board: &Board, fit: &Fit, group: usize) -> Option<f64> {
    let effects = fit.model.effects(group);
    let wholes = effects.iter().map(|effect| match effect.carrier {
        Carrier::Order(order) if !is_exact(order) && order.round() > 0.0 => Some(Effect {
            carrier: Carrier::Order(order.round()),
            ..*effect
        }),
        _ => None,
    });
    let wholes: Vec<Effect> = wholes.collect::<Option<_>>()?;
    let Carrier::Order(whole) = wholes.first()?.carrier else {
        return None;
    };
    let own = fit.own(group);
    let shown = parts(board, &bounds(SLIPS), &|at| own[at] * own[at]);
    let sizes = wholes.iter().flat_map(|effect| {
        let benches = board.benches.iter();
        let raw: Vec<_> = benches.map(|bench| bench.columns(effect)).collect();
        let sizes = (0..effect.sizes()).map(|size| {
            let each: Vec<Vec<f64>> = raw.iter().map(|raw| raw[size].clone()).collect();
            board.with_pattern(&each)
        });
        sizes.collect::<Vec<_>>()
    });
    let sizes: Vec<Vec<f64>> = sizes.collect();
    let rest = fit.without(group);
    let basis = rest.basis();
    let each = shown.iter().flat_map(|part| {
        let (basis, sizes) = (&basis, sizes.iter());
        sizes.map(move |all| {
            let mut own = vec![0.0; all.len()];
            for rows in part {
                own[rows.clone()].copy_from_slice(&all[rows.clone()]);
            }
            let mut own = board.beside_pattern(own);
            basis.clear(&mut own);
            own
        })
    });
    let each: Vec<Vec<f64>> = each.collect();
    let each: Vec<&[f64]> = each.iter().map(Vec::as_slice).collect();
    let gain = rest.rss - lsq::solve(&each, &rest.left).rss;
    let own = evidence(board, rest.rss - fit.rss, fit.model.numbers(group));
    (evidence(board, gain, each.len()) > own).then_some(whole)
}

impl Parts {
    /// Of a fit: blocks over time, or the part that is fitted and the part that is held out.
    #[must_use]
    fn new(board: &Board, fit: &Fit, bounds: &[f64], weighs: &dyn Fn(usize) -> f64) -> Self {
        let sizes = DVector::from_iterator(
            fit.of.len(),
            fit.of.iter().map(|(term, number)| {
                fit.model.terms[*term]
                    .sizes
                    .get(*number)
                    .copied()
                    .unwrap_or(0.0)
            }),
        );
        let mut target = fit.left.clone();
        for (column, size) in fit.columns.iter().zip(sizes.iter()) {
            if *size != 0.0 {
                target
                    .iter_mut()
                    .zip(column)
                    .for_each(|(target, of)| *target += size * of);
            }
        }
        let over = |ranges: &[std::ops::Range<usize>]| {
            let count = fit.columns.len();
            let product = |a: &[f64], b: &[f64]| {
                ranges
                    .iter()
                    .map(|range| dot(&a[range.clone()], &b[range.clone()]))
                    .sum::<f64>()
            };
            let mut gram = DMatrix::zeros(count, count);
            for a in 0..count {
                for b in 0..=a {
                    gram[(a, b)] = product(&fit.columns[a], &fit.columns[b]);
                    gram[(b, a)] = gram[(a, b)];
                }
            }
            Products {
                gram,
                right: DVector::from_fn(count, |a, _| product(&fit.columns[a], &target)),
                square: product(&target, &target),
            }
        };
        let edges = board.edges();
        Self {
            parts: parts(board, bounds, weighs)
                .iter()
                .map(|ranges| over(ranges))
                .collect(),
            always: over(std::slice::from_ref(&(edges..target.len()))),
            sizes,
            of: fit.of.clone(),
        }
    }

    /// Blocks over time.
    #[must_use]
    pub fn blocks(board: &Board, fit: &Fit) -> Self {
        Self::new(board, fit, &bounds(BLOCKS), &|_| 1.0)
    }

    /// Blocks over time in each of which a group shows as much: what shows in slow turns alone is foretold from other slow turns or not
    /// at all.
    #[must_use]
    pub fn of_group(board: &Board, fit: &Fit, group: usize) -> Self {
        let own = fit.own(group);
        Self::new(board, fit, &bounds(BLOCKS), &|at| own[at] * own[at])
    }

    /// The part that is fitted and the part that is held out.
    #[must_use]
    pub fn held_out(board: &Board, fit: &Fit) -> Self {
        Self::new(board, fit, &[0.0, 1.0 - HELD_OUT, 1.0], &|_| 1.0)
    }

    /// Numbers as some parts alone have them, of some columns; the others are 0.
    fn fitted(&self, on: impl Fn(usize) -> bool, columns: &[usize]) -> DVector<f64> {
        let count = self.sizes.len();
        let mut gram = self.always.gram.clone();
        let mut right = self.always.right.clone();
        for (_, part) in self.parts.iter().enumerate().filter(|(at, _)| on(*at)) {
            gram += &part.gram;
            right += &part.right;
        }
        // A little of what all parts say, so that what these can't tell stays where it is.
        for &at in columns {
            let all: f64 = self.parts.iter().map(|part| part.gram[(at, at)]).sum();
            gram[(at, at)] += KEPT * all;
            right[at] += KEPT * all * self.sizes[at];
        }
        let norms: Vec<f64> = columns
            .iter()
            .map(|&at| gram[(at, at)].sqrt().max(f64::MIN_POSITIVE))
            .collect();
        let some = DMatrix::from_fn(columns.len(), columns.len(), |a, b| {
            let ridge = if a == b { 1e-9 } else { 0.0 };
            gram[(columns[a], columns[b])] / (norms[a] * norms[b]) + ridge
        });
        let of = DVector::from_fn(columns.len(), |a, _| right[columns[a]] / norms[a]);
        let mut all = DVector::zeros(count);
        if let Some(cholesky) = Cholesky::new(some) {
            let solved = cholesky.solve(&of);
            for (a, &at) in columns.iter().enumerate() {
                all[at] = solved[a] / norms[a];
            }
        }
        all
    }

    /// Sum of squares that numbers leave in a part.
    fn left(&self, part: usize, sizes: &DVector<f64>) -> f64 {
        let part = &self.parts[part];
        (part.square - 2.0 * part.right.dot(sizes) + sizes.dot(&(&part.gram * sizes))).max(0.0)
    }

    /// Columns of terms that are asked for.
    fn columns(&self, of: impl Fn(usize) -> bool) -> Vec<usize> {
        (0..self.of.len()).filter(|&at| of(self.of[at].0)).collect()
    }

    /// What a group does on turns that no term was fitted on, each block foretold by the others. A disc of which nothing is known may have
    /// taken the rest.
    #[must_use]
    pub fn foretold(&self, fit: &Fit, group: usize) -> Foretold {
        let all = self.columns(|_| true);
        let others = self.columns(|term| fit.model.terms[term].group != group);
        let left = |columns: &[usize], block: usize, on: &dyn Fn(usize) -> bool| {
            self.left(block, &self.fitted(on, columns))
        };
        let mut foretold = Foretold::default();
        for block in 0..self.parts.len() {
            let elsewhere = |at: usize| at != block;
            let without = left(&others, block, &elsewhere);
            foretold.without += without;
            foretold.fall += without - left(&all, block, &elsewhere);
            foretold.shown += left(&others, block, &|_| true) - left(&all, block, &|_| true);
        }
        foretold
    }

    /// Whether a group shows in one part of the recordings alone, so that no other part foretells it.
    #[must_use]
    pub fn only_once(&self, fit: &Fit, group: usize) -> bool {
        let columns = self.columns(|term| fit.model.terms[term].group == group);
        let shown: Vec<f64> = self
            .parts
            .iter()
            .map(|part| {
                let each = columns.iter();
                each.map(|&at| self.sizes[at].powi(2) * part.gram[(at, at)])
                    .sum()
            })
            .collect();
        let most = shown.iter().copied().fold(0.0, f64::max);
        most > ONCE * shown.iter().sum::<f64>()
    }

    /// Squares left in the held-out part: with nuisances alone, with everything fitted before it, and with everything fitted on it.
    #[must_use]
    pub fn judged(&self, fit: &Fit) -> [f64; 3] {
        let all = self.columns(|_| true);
        let nuisances = self.columns(|term| fit.model.terms[term].nuisance);
        let last = self.parts.len() - 1;
        let none = self.fitted(|at| at != last, &nuisances);
        let early = self.fitted(|at| at != last, &all);
        let late = self.fitted(|at| at == last, &all);
        [
            self.left(last, &none),
            self.left(last, &early),
            self.left(last, &late),
        ]
    }
}
