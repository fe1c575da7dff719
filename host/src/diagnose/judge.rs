//! What holds on turns that it was not fitted on, and how well.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::effect::{Carrier, Effect, Site, is_exact};
use super::lsq::{self, dot};
use super::model::{Board, Fit};
use super::scan::{SURE, evidence};

/// Blocks that are left out in turn.
const BLOCKS: usize = 4;
/// Share of each recording that is held out for the figures of the fit: its last part.
pub const HELD_OUT: f64 = 0.3;
/// Part of what a finding shows that is most of it: what other turns have to foretell of it, and what of it in one block the others can't
/// foretell.
const MOST: f64 = 0.7;
/// Weight of what all blocks say in a fit to some of them.
const KEPT: f64 = 0.01;

/// Rows of a fit in parts, to fit some and judge on others.
#[derive(Clone, Debug)]
pub struct Parts {
    /// Products of the fit's columns and, as the last one, its target over the rows of each part; what belongs to no turn is in all fits.
    parts: Vec<DMatrix<f64>>,
    always: DMatrix<f64>,
    /// The fit's own numbers as its columns have them: sizes, and no change of the knobs.
    sizes: DVector<f64>,
    of: Vec<(usize, usize)>,
}

/// Rows of each part of each recording in a stacked row, by the shares of what weighs its rows at which parts begin.
fn parts(board: &Board, begin: &[f64], weighs: &dyn Fn(usize) -> f64) -> Vec<Vec<Range<usize>>> {
    let mut all = vec![Vec::new(); begin.len()];
    let mut from = 0;
    for bench in &board.benches {
        let rows = bench.record.len();
        let mut sums = vec![0.0];
        for at in from..from + rows {
            sums.push(sums[at - from] + weighs(at));
        }
        let begins = |part: usize| {
            let share = begin.get(part).unwrap_or(&1.0) * sums[rows];
            from + sums.partition_point(|sum| *sum < share).min(rows)
        };
        for (part, all) in all.iter_mut().enumerate() {
            all.push(begins(part)..begins(part + 1));
        }
        from += rows;
    }
    all
}

/// Shares at which so many parts begin that are alike.
fn alike(count: usize) -> Vec<f64> {
    (0..count).map(|at| at as f64 / count as f64).collect()
}

/// What a group does on turns that no term was fitted on.
#[derive(Clone, Copy, Debug, Default)]
pub struct Foretold {
    /// By how much the sum of squares falls with it.
    pub fall: f64,
    /// By how much it falls on the same turns where all are fitted on all: what the group shows there.
    pub shown: f64,
    /// The turns' sum of squares without it and with it.
    without: f64,
    with: f64,
}

impl Foretold {
    /// RMS with the group over RMS without it.
    pub fn rms_ratio(&self) -> f64 {
        (self.with / self.without.max(f64::MIN_POSITIVE)).sqrt()
    }
}

/// Whether so much of what shows is foretold that it is said.
pub fn foretells(foretold: f64, shown: f64) -> bool {
    foretold >= MOST * shown - SURE
}

/// What a group does on turns that it was not fitted on; none where it comes once, or once along the course, so that nothing foretells it
/// from elsewhere.
pub fn foretold(board: &Board, fit: &Fit, group: usize) -> Option<Foretold> {
    let effects = fit.model.effects(group);
    let declared = |effect: &Effect| matches!(effect.site, Site::Declared(_));
    let once = if effects.iter().any(declared) {
        Parts::blocks(board, fit).only_once(fit, group)
    } else {
        effects.iter().any(comes_once)
    };
    (!once).then(|| Parts::of_group(board, fit, group).foretold(fit, group))
}

/// Whether an effect comes at an instant or goes by the course of the speed.
const fn comes_once(effect: &Effect) -> bool {
    matches!(
        effect.carrier,
        Carrier::Window(..)
            | Carrier::Settling(..)
            | Carrier::Time
            | Carrier::Direction
            | Carrier::Power(_)
            | Carrier::Stribeck(_)
    )
}

/// Whether a group of a fit shows more than once, and is foretold on turns that it was not fitted on.
pub fn recurs(board: &Board, fit: &Fit, group: usize) -> bool {
    let Foretold { fall, shown, .. } = Parts::of_group(board, fit, group).foretold(fit, group);
    foretells(fall, shown) && !Parts::blocks(board, fit).only_once(fit, group)
}

/// The whole order whose sideband a group's order, with its harmonics, may be: a part of each turn that comes and goes, or turns its phase,
/// along the recording shows as an order beside it. Its sizes in each of some blocks have more evidence then.
pub fn sideband_of(board: &Board, fit: &Fit, group: usize) -> Option<f64> {
    let beside = |group: usize| -> Option<Vec<Effect>> {
        let effects = fit.model.effects(group).into_iter();
        let wholes = effects.map(|effect| match effect.carrier {
            Carrier::Order(order) if !is_exact(order) && order.round() > 0.0 => Some(Effect {
                carrier: Carrier::Order(order.round()),
                ..effect
            }),
            _ => None,
        });
        wholes.collect()
    };
    let wholes = beside(group)?;
    let Carrier::Order(whole) = wholes.first()?.carrier else {
        return None;
    };
    // It may have several sidebands.
    let mut near = fit.model.groups();
    near.retain(|other| beside(*other).as_ref() == Some(&wholes));
    let is_near = |term: usize| near.contains(&fit.model.terms[term].group);
    let own = fit.own_of(&is_near);
    // In as many parts an order that slips by less than one turn in a block is not told from the whole one.
    let shown = parts(board, &alike(2 * BLOCKS), &|at| own[at] * own[at]);
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
    let rest = fit.without_some(&is_near);
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
    let numbers = near.iter().map(|group| fit.model.numbers(*group)).sum();
    let own = evidence(board, rest.rss - fit.rss, numbers);
    // What slips by less than a turn is the whole order wherever that explains most of it.
    let slips = board.reach(&wholes[0])[0];
    let slow = fit.model.effects(group).iter().all(|effect| {
        matches!(effect.carrier, Carrier::Order(order) if (order - order.round()).abs() < slips)
    });
    let most = slow && gain > MOST * (rest.rss - fit.rss);
    (most || evidence(board, gain, each.len()) > own).then_some(whole)
}

impl Parts {
    /// Of a fit, by the shares of what weighs its rows at which parts begin.
    fn new(board: &Board, fit: &Fit, begin: &[f64], weighs: &dyn Fn(usize) -> f64) -> Self {
        let target = fit.beside(&|_| true);
        let columns: Vec<&Vec<f64>> = fit.columns.iter().chain([&target]).collect();
        let over = |ranges: &[Range<usize>]| {
            let mut gram = DMatrix::zeros(columns.len(), columns.len());
            for (a, one) in columns.iter().enumerate() {
                for (b, other) in columns[..=a].iter().enumerate() {
                    let each = ranges.iter().cloned();
                    let each = each.map(|range| dot(&one[range.clone()], &other[range]));
                    gram[(a, b)] = each.sum::<f64>();
                    gram[(b, a)] = gram[(a, b)];
                }
            }
            gram
        };
        let sizes = fit.of.iter().map(|(term, number)| {
            let size = fit.model.terms[*term].sizes.get(*number);
            size.copied().unwrap_or(0.0)
        });
        let parts = parts(board, begin, weighs);
        Self {
            parts: parts.iter().map(|ranges| over(ranges)).collect(),
            always: over(std::slice::from_ref(&(board.edges()..target.len()))),
            sizes: DVector::from_iterator(fit.of.len(), sizes),
            of: fit.of.clone(),
        }
    }

    /// Blocks over time.
    pub fn blocks(board: &Board, fit: &Fit) -> Self {
        Self::new(board, fit, &alike(BLOCKS), &|_| 1.0)
    }

    /// Blocks over time in each of which a group shows as much: what shows in slow turns alone is foretold from other slow turns or not
    /// at all.
    pub fn of_group(board: &Board, fit: &Fit, group: usize) -> Self {
        let own = fit.own_of(&|term| fit.model.terms[term].group == group);
        Self::new(board, fit, &alike(BLOCKS), &|at| own[at] * own[at])
    }

    /// The part that is fitted and the part that is held out.
    pub fn held_out(board: &Board, fit: &Fit) -> Self {
        Self::new(board, fit, &[0.0, 1.0 - HELD_OUT], &|_| 1.0)
    }

    /// Numbers as some parts alone have them, of some columns; the others are 0.
    fn fitted(&self, on: impl Fn(usize) -> bool, columns: &[usize]) -> DVector<f64> {
        let count = self.sizes.len();
        let mut gram = self.always.clone();
        let parts = self.parts.iter().enumerate();
        parts
            .filter(|(at, _)| on(*at))
            .for_each(|(_, part)| gram += part);
        // A little of what all parts say, so that what these can't tell stays where it is.
        for &at in columns {
            let all: f64 = self.parts.iter().map(|part| part[(at, at)]).sum();
            gram[(at, at)] += KEPT * all;
            gram[(at, count)] += KEPT * all * self.sizes[at];
        }
        let rows = gram.select_rows(columns);
        let (solved, _) = lsq::normal(
            &rows.select_columns(columns),
            &rows.column(count).into_owned(),
        );
        let mut all = DVector::zeros(count);
        for (&at, size) in columns.iter().zip(&solved) {
            all[at] = *size;
        }
        all
    }

    /// Columns of terms that are asked for.
    fn columns(&self, of: impl Fn(usize) -> bool) -> Vec<usize> {
        (0..self.of.len()).filter(|&at| of(self.of[at].0)).collect()
    }

    /// What a group does on turns that no term was fitted on, each block foretold by the others. What numbers that are about known have to
    /// be without it, a share of it in each block, is of what it does: they may foretell the turns as well, far from where they are known.
    pub fn foretold(&self, fit: &Fit, group: usize) -> Foretold {
        let all = self.columns(|_| true);
        let others = self.columns(|term| fit.model.terms[term].group != group);
        let share = 1.0 / self.parts.len() as f64;
        let lost = |block: usize, sizes: &DVector<f64>| {
            left(&self.parts[block], sizes) + share * left(&self.always, sizes)
        };
        let mut foretold = Foretold::default();
        for block in 0..self.parts.len() {
            let [without, with] = [&others, &all].map(|of| self.fitted(|at| at != block, of));
            let [none, whole] = [&others, &all].map(|of| self.fitted(|_| true, of));
            foretold.fall += lost(block, &without) - lost(block, &with);
            foretold.shown += lost(block, &none) - lost(block, &whole);
            foretold.without += left(&self.parts[block], &without);
            foretold.with += left(&self.parts[block], &with);
        }
        foretold
    }

    /// Whether a group shows in one part of the recordings alone, so that no other part foretells it.
    pub fn only_once(&self, fit: &Fit, group: usize) -> bool {
        let columns = self.columns(|term| fit.model.terms[term].group == group);
        let shown = self.parts.iter().map(|part| {
            let each = columns.iter();
            let each = each.map(|&at| self.sizes[at].powi(2) * part[(at, at)]);
            each.sum::<f64>()
        });
        let most = shown.clone().fold(0.0, f64::max);
        most > MOST * shown.sum::<f64>()
    }

    /// Squares left in the last part: with nuisances alone, with everything fitted before it, and with everything fitted on it.
    pub fn judged(&self, fit: &Fit) -> [f64; 3] {
        let last = self.parts.len() - 1;
        let early = |at: usize| at != last;
        let all = self.columns(|_| true);
        [
            self.fitted(early, &self.nuisances(fit)),
            self.fitted(early, &all),
            self.fitted(|at| at == last, &all),
        ]
        .map(|sizes| left(&self.parts[last], &sizes))
    }

    /// Whether the last part, and what numbers that are about known have to be, gets worse by what was found before it.
    pub fn worse(&self, fit: &Fit) -> bool {
        let last = self.parts.len() - 1;
        let lost = |columns: &[usize]| {
            let sizes = self.fitted(|at| at != last, columns);
            left(&self.parts[last], &sizes) + left(&self.always, &sizes)
        };
        lost(&self.columns(|_| true)) > lost(&self.nuisances(fit))
    }

    /// Columns of what is no finding's.
    fn nuisances(&self, fit: &Fit) -> Vec<usize> {
        let groups = fit.model.groups();
        self.columns(|term| !groups.contains(&fit.model.terms[term].group))
    }
}

/// Sum of squares that numbers leave, by the products of some rows.
fn left(products: &DMatrix<f64>, sizes: &DVector<f64>) -> f64 {
    let by = (-sizes).push(1.0);
    by.dot(&(products * &by)).max(0.0)
}
