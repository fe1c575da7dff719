//! What was concluded, put into the twins, simulated, and fitted once more: the numbers are those of the simulation.

use super::basis::Basis;
use super::board::{Board, Column, Model};
use super::conclude::Conclusion;
use super::diagnosis::Fit;
use super::estimate::{Estimate, estimates};
use super::judge;
use super::leftover::leftovers;
use super::mended::{Mended, listed};
use super::prepare;
use super::run::{DiagnoseError, Recorded};
use super::search::{Found, Searched};
use crate::twin::{Errors, Twin};

/// A conclusion with its numbers.
#[derive(Debug)]
pub struct Settled {
    /// The recordings against the twins as they were given, in the noise that was found.
    pub given: Board,
    /// What the twins as given leave.
    pub before: Model,
    /// What the mended twins leave.
    pub after: Model,
    /// What was concluded.
    pub concluded: Conclusion,
    /// Marks of the named findings, in their order.
    pub marks: Vec<Mark>,
    /// Numbers of the named findings, in their order.
    pub estimates: Vec<Estimate>,
    /// The disc's pattern.
    pub pattern: Option<super::disc::Pattern>,
    /// The twins with the findings in them.
    pub twins: Vec<Twin>,
    /// The whole of e where the disc was learned edge by edge.
    pub error_lists: Vec<Option<Vec<f64>>>,
    /// How well it fits.
    pub fit: Fit,
    class_names: &'static [&'static str],
}

/// Settles.
///
/// # Errors
/// [`DiagnoseError`] where a mended twin can't be run.
pub fn settle(
    rig: &[Recorded],
    given: &Board,
    board: Board,
    searched: Searched,
    concluded: Conclusion,
) -> Result<Settled, DiagnoseError> {
    let mut searched = searched;
    searched.pattern = searched.pattern.filter(|_| concluded.pattern);
    let mut given = given.clone();
    for (bench, found) in given.benches.iter_mut().zip(&board.benches) {
        bench.set_noise(found.noise);
    }
    let before = given
        .fit(given.nuisances())
        .unwrap_or_else(|| Model::none(&given));
    let chosen = chosen(&board, &searched, &concluded);
    let mut numbers = estimates(&board, &chosen);
    let marks = marks(&board, &chosen);
    let mended = |numbers: &[Estimate]| mended(rig, &given, &chosen, numbers);
    // Against the mended twins only small rests are left of the sizes.
    let mut again = board;
    if !numbers.is_empty() {
        for _ in 0..2 {
            let rig = recorded(rig, &mended(&numbers).0);
            let Ok(mut next) = prepare::board(&rig) else {
                break;
            };
            // Edges are compared one by one, so the mended twin has to go wherever the given one goes.
            let mut pairs = next.benches.iter().zip(&again.benches);
            if pairs.any(|(next, again)| next.seen.len() != again.seen.len()) {
                break;
            }
            for (bench, found) in next.benches.iter_mut().zip(&again.benches) {
                bench.set_noise(found.noise);
            }
            let Some(rests) = rests(&next, &chosen) else {
                break;
            };
            let moved = far(&numbers, &rests);
            for (number, rest) in numbers.iter_mut().zip(rests) {
                for (size, rest) in number.sizes.iter_mut().zip(rest) {
                    *size += rest;
                }
            }
            again = next;
            if moved < 0.3 {
                break;
            }
        }
    }
    let (twins, error_lists) = mended(&numbers);
    let after = again
        .fit(again.nuisances())
        .unwrap_or_else(|| Model::none(&again));
    let whiteness = (leftovers(&given, &before).1, leftovers(&again, &after).1);
    let fit = Fit {
        rms_after_rad: judge::rms_rad(&again, &after),
        ..judge::fit(&given, &before, &chosen, whiteness)
    };
    let class_names = rig
        .first()
        .map_or(&[][..], |one| one.plan.kind.class_names());
    Ok(Settled {
        given,
        before,
        after,
        pattern: searched.pattern.clone(),
        concluded,
        estimates: numbers,
        marks,
        twins,
        error_lists,
        fit,
        class_names,
    })
}

/// What a finding makes of the recording that shows it best.
#[derive(Debug)]
pub struct Mark {
    /// Recording.
    pub bench: usize,
    /// Its first pattern.
    pub basis: Basis,
    /// Angles, rad.
    pub angles: Vec<f64>,
    /// The same, white.
    pub white: Vec<f64>,
    /// What all findings leave, white.
    pub left: Vec<f64>,
}

/// Marks of everything found.
fn marks(board: &Board, chosen: &Searched) -> Vec<Mark> {
    let mut at = chosen.nuisances;
    let each = chosen.found.iter().map(|found| {
        let sizes = &chosen.model.sizes.as_slice()[at..at + found.columns.len()];
        at += found.columns.len();
        let raw: Vec<Column> = found
            .hypothesis
            .bases
            .iter()
            .flat_map(|basis| board.raw_columns(*basis))
            .collect();
        let sum = |columns: &[Column], bench: usize| {
            let mut sum = vec![0.0; board.benches[bench].seen.len()];
            for (column, size) in columns.iter().zip(sizes) {
                for (sum, value) in sum.iter_mut().zip(column.0[bench].iter().flatten()) {
                    *sum += size * value;
                }
            }
            sum
        };
        let power = |bench: usize| {
            sum(&found.columns, bench)
                .iter()
                .map(|w| w * w)
                .sum::<f64>()
        };
        let bench = (0..board.benches.len())
            .max_by(|a, b| power(*a).total_cmp(&power(*b)))
            .unwrap_or(0);
        Mark {
            bench,
            basis: found.hypothesis.bases[0],
            angles: sum(&raw, bench),
            white: sum(&found.columns, bench),
            left: chosen.model.left[bench].clone(),
        }
    });
    each.collect()
}

impl Settled {
    /// Names of the edge classes.
    #[must_use]
    pub const fn class_names(&self) -> &'static [&'static str] {
        self.class_names
    }
}

/// The search with what was concluded in place of what was found.
fn chosen(board: &Board, searched: &Searched, concluded: &Conclusion) -> Searched {
    let nuisances: Vec<Column> = searched.model.columns[..searched.nuisances].to_vec();
    let found: Vec<Found> = concluded
        .named
        .iter()
        .map(|name| {
            let old = &searched.found[name.number];
            let columns = if old.hypothesis == name.hypothesis {
                old.columns.clone()
            } else {
                name.hypothesis.columns(board)
            };
            Found {
                hypothesis: name.hypothesis.clone(),
                columns,
                score: name.score,
                rivals: Vec::new(),
            }
        })
        .collect();
    let own = found.iter().flat_map(|f| f.columns.iter());
    let all: Vec<Column> = nuisances.iter().chain(own).cloned().collect();
    match board.fit(all) {
        Some(model) => Searched {
            found,
            model,
            ..searched.clone()
        },
        None => searched.clone(),
    }
}

/// What is left of each finding's sizes against mended twins.
fn rests(board: &Board, chosen: &Searched) -> Option<Vec<Vec<f64>>> {
    let mut columns = board.nuisances();
    let mut at = columns.len();
    let mut ranges = Vec::new();
    for found in &chosen.found {
        let own = found.hypothesis.columns(board);
        // One that does not show was left out of the fit.
        let own = if own.len() == found.columns.len() {
            own
        } else {
            found.columns.clone()
        };
        ranges.push(at..at + own.len());
        at += own.len();
        columns.extend(own);
    }
    let model = board.fit(columns)?;
    let sizes = model.sizes.as_slice();
    Some(
        ranges
            .into_iter()
            .map(|range| sizes[range].to_vec())
            .collect(),
    )
}

/// Largest rest in standard errors.
fn far(numbers: &[Estimate], rests: &[Vec<f64>]) -> f64 {
    let each = numbers.iter().zip(rests).flat_map(|(number, rest)| {
        let rest = rest.iter().enumerate();
        rest.map(|(i, rest)| rest.abs() / number.covariance[(i, i)].sqrt())
            .collect::<Vec<_>>()
    });
    each.fold(0.0, f64::max)
}

/// Twins with estimates in them, and the lists of errors where the disc needs one.
fn mended(
    rig: &[Recorded],
    given: &Board,
    searched: &Searched,
    numbers: &[Estimate],
) -> (Vec<Twin>, Vec<Option<Vec<f64>>>) {
    let (mut twins, mut lists) = (Vec::new(), Vec::new());
    for (number, one) in rig.iter().enumerate() {
        let edges = one.track.edges as usize;
        let mut mended = Mended {
            twin: one.twin.clone(),
            errors_rad: Vec::new(),
            edges,
            classes: one.track.classes as usize,
        };
        let mut bases = numbers.iter().flat_map(|n| &n.hypothesis.bases);
        if let Some(pattern) = &searched.pattern {
            mended.errors_rad.clone_from(&pattern.errors_rad);
        } else if bases.any(|basis| listed(*basis)) {
            mended.errors_rad = vec![0.0; edges];
        }
        for estimate in numbers {
            mended.add(estimate, number, rig.len());
        }
        let list = (!mended.errors_rad.is_empty()).then(|| {
            let known = &given.benches[number].seen.errors;
            let sum = known
                .iter()
                .zip(&mended.errors_rad)
                .map(|(known, more)| known + more);
            sum.collect::<Vec<f64>>()
        });
        if let Some(list) = &list {
            // Of a wheel recorded with one edge of each tooth the other goes along.
            let each = (one.twin.encoder.grid_edges() as usize / edges).max(1);
            mended.twin.errors = Errors {
                list_rad: list.iter().flat_map(|e| vec![*e; each]).collect(),
                ..Errors::default()
            };
        }
        twins.push(mended.twin);
        lists.push(list);
    }
    (twins, lists)
}

/// The recordings with other twins.
fn recorded(rig: &[Recorded], twins: &[Twin]) -> Vec<Recorded> {
    let each = rig.iter().zip(twins).map(|(one, twin)| Recorded {
        twin: twin.clone(),
        ..one.clone()
    });
    each.collect()
}
