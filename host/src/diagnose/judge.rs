//! How well it fits, on all turns and on turns that nothing was fitted on.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::board::{Board, Column, FITTED, Model, PARTS};
use super::diagnosis::{Band, Fit, HeldOut};
use super::disc;
use super::leftover::leftovers;
use super::search::Searched;
use super::spread::{Spread, floor, spread};

/// Sum of squares on the held-out turns from which on a finding can be judged there.
const SHOWS: f64 = 30.0;

/// Part of it that the errors of what was fitted on the turns before may make at the most.
const DOUBT: f64 = 0.05;

/// What is judged: the search as it was concluded, and what came of it.
#[derive(Clone, Copy, Debug)]
pub struct Judged<'a> {
    /// The recordings against the twins as given.
    pub given: &'a Board,
    /// What these leave.
    pub before: &'a Model,
    /// The recordings against the mended twins.
    pub again: &'a Board,
    /// What those leave.
    pub after: &'a Model,
    /// Findings with a name, fitted together.
    pub chosen: &'a Searched,
    /// Columns of what has none.
    pub nameless: &'a [Column],
}

/// RMS on held-out turns with a finding over that without it; none where it can't be judged there.
#[derive(Clone, Debug, Default)]
pub struct HeldRatios {
    /// Of each named finding, in their order.
    pub named: Vec<Option<f64>>,
    /// Of the disc's pattern.
    pub disc: Option<f64>,
    /// Of what has no name.
    pub nameless: Option<f64>,
}

/// The fit of a search, against the twin as it was given, and each finding's part in it on the turns held out.
#[must_use]
pub fn fit(judged: &Judged<'_>) -> (Fit, HeldRatios) {
    let whiteness = |board: &Board, model: &Model| leftovers(board, model).1;
    let ((before_p, after_p), ((was, is), (noise, (mut held_out, ratios)))) = rayon::join(
        || {
            rayon::join(
                || whiteness(judged.given, judged.before),
                || whiteness(judged.again, judged.after),
            )
        },
        || {
            rayon::join(
                || {
                    rayon::join(
                        || spread(judged.given, &judged.before.left, 0..PARTS),
                        || spread(judged.again, &judged.after.left, 0..PARTS),
                    )
                },
                || rayon::join(|| floor(judged.again, 0..PARTS), || held_out(judged)),
            )
        },
    );
    // Noise that is not what a twin declares is guessed; what is left holds all of it.
    let mut benches = judged.again.benches.iter();
    let guessed = benches.any(|bench| bench.declared != Some(bench.noise));
    let floor = |noise: f64, left: f64| Some(if guessed { noise.min(left) } else { noise });
    if let (Some(noise), Some(left)) = (held_out.floor_rad, held_out.rms_after_rad) {
        held_out.floor_rad = floor(noise, left);
    }
    let fit = Fit {
        rms_before_rad: Some(was.fast_rad()),
        rms_after_rad: Some(is.fast_rad()),
        floor_rad: floor(noise.fast_rad(), is.fast_rad()),
        slow: Band {
            rms_before_rad: Some(was.slow_rad()),
            rms_after_rad: Some(is.slow_rad()),
            floor_rad: floor(noise.slow_rad(), is.slow_rad()),
        },
        edge_to_edge: Band {
            rms_before_rad: Some(was.steps_rad()),
            rms_after_rad: Some(is.steps_rad()),
            floor_rad: floor(noise.steps_rad(), is.steps_rad()),
        },
        whiteness_p_before: Some(before_p),
        whiteness_p: Some(after_p),
        held_out,
    };
    (fit, ratios)
}

fn held_out(judged: &Judged<'_>) -> (HeldOut, HeldRatios) {
    let (given, chosen) = (judged.given, judged.chosen);
    let late = FITTED..PARTS;
    let was = spread(given, &judged.before.left, late.clone());
    let noise = floor(given, late.clone());
    let none = HeldOut {
        rms_before_rad: Some(was.fast_rad()),
        rms_after_rad: Some(was.fast_rad()),
        floor_rad: Some(noise.fast_rad()),
        reducible_removed: None,
    };
    let mut ratios = HeldRatios {
        named: vec![None; chosen.found.len()],
        ..HeldRatios::default()
    };
    let columns = &chosen.model.columns;
    // The disc as the turns before show it.
    let known = chosen
        .pattern
        .as_ref()
        .and_then(|_| early_disc(given, columns));
    let board = known.as_ref().unwrap_or(given);
    // What was never there in the turns before can't be foretold.
    let early = board.cut(columns, 0..FITTED);
    let Some(fitted) = board.fit(early) else {
        return (none, ratios);
    };
    let foretold = board.with_sizes(columns, &fitted.sizes);
    let is = spread(board, &foretold.left, late.clone());
    let held_out = HeldOut {
        rms_after_rad: Some(is.fast_rad()),
        reducible_removed: removed(board, chosen, &foretold),
        ..none
    };
    let held = Held { board, noise };
    let mut at = chosen.nuisances;
    let mut own: Vec<std::ops::Range<usize>> = Vec::new();
    for found in &chosen.found {
        own.push(at..at + found.columns.len());
        at += found.columns.len();
    }
    let each = own.into_par_iter();
    ratios.named = each
        .map(|own| held.without(columns, &fitted, own))
        .collect();
    if known.is_some()
        && let Some(fitted) = given.fit(given.cut(columns, 0..FITTED))
    {
        let was = spread(
            given,
            &given.with_sizes(columns, &fitted.sizes).left,
            late.clone(),
        );
        let mark = spread(board, &apart(board, &given.white()), late);
        ratios.disc = Some(ratio(mark, is, was, noise)).filter(|ratio| ratio.is_finite());
    }
    if !judged.nameless.is_empty() {
        let all: Vec<Column> = columns.iter().chain(judged.nameless).cloned().collect();
        ratios.nameless = board
            .fit(board.cut(&all, 0..FITTED))
            .and_then(|fitted| held.without(&all, &fitted, columns.len()..all.len()));
    }
    (held_out, ratios)
}

/// The recordings less the disc's pattern as their early turns show it.
fn early_disc(given: &Board, columns: &[Column]) -> Option<Board> {
    let mut early = given.clone();
    for bench in &mut early.benches {
        let end = bench.part(FITTED - 1).end;
        bench.shorten(end);
    }
    let short = |column: &Column| {
        let parts = column.0.iter().zip(&early.benches);
        let each = parts.map(|(part, bench)| part.as_ref().map(|p| p[..bench.seen.len()].to_vec()));
        Column::of(each)
    };
    let model = early.fit(columns.iter().map(short).collect())?;
    let pattern = disc::pattern(&early, &model, true)?;
    let mut known = given.clone();
    known.take_off(&pattern.errors_rad);
    Some(known)
}

/// Share of what the findings could remove on the held-out turns at best that they did remove.
fn removed(board: &Board, chosen: &Searched, foretold: &Model) -> Option<f64> {
    let late = FITTED..PARTS;
    let columns = &chosen.model.columns;
    if columns.len() == chosen.nuisances {
        return None;
    }
    let nuisances = columns[..chosen.nuisances].to_vec();
    let best = board.fit(board.cut(columns, late.clone()))?;
    let alone = board.fit(board.cut(&nuisances, late.clone()))?;
    let squares = |model: &Model| squares(board, &model.left, late.clone());
    let at_best = squares(&board.with_sizes(columns, &best.sizes));
    let without = squares(&board.with_sizes(&nuisances, &alone.sizes));
    let numbers = (columns.len() - nuisances.len()) as f64;
    let reducible = without - at_best - numbers;
    let lost = squares(foretold) - at_best - numbers;
    (reducible > SHOWS).then(|| (1.0 - lost / reducible).clamp(0.0, 1.0))
}

/// Sum of squares of what is left on some parts.
pub fn squares(board: &Board, left: &[Vec<f64>], parts: std::ops::Range<usize>) -> f64 {
    let each = board.benches.iter().zip(left).map(|(bench, left)| {
        let range = bench.part(parts.start).start..bench.part(parts.end - 1).end;
        left[range].iter().map(|w| w * w).sum::<f64>()
    });
    each.sum()
}

/// Rows less the residual of each recording, white.
fn apart(board: &Board, rows: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let each = rows.iter().zip(&board.benches).map(|(row, bench)| {
        let pairs = row.iter().zip(&bench.white);
        pairs.map(|(row, white)| row - white).collect()
    });
    each.collect()
}

/// The held-out turns and their noise.
struct Held<'a> {
    board: &'a Board,
    noise: Spread,
}

impl Held<'_> {
    /// RMS with some of the columns that were fitted on the early turns over that without them, the others fitted anew: of what is
    /// fast or of what is slow, wherever they stand out more.
    fn without(
        &self,
        columns: &[Column],
        fitted: &Model,
        own: std::ops::Range<usize>,
    ) -> Option<f64> {
        if own.is_empty() {
            return None;
        }
        let late = FITTED..PARTS;
        let rest: Vec<usize> = (0..columns.len()).filter(|i| !own.contains(i)).collect();
        let own: Vec<usize> = own.collect();
        let sizes = &fitted.sizes;
        // The mark that the finding makes.
        let mut alone = DVector::zeros(columns.len());
        own.iter().for_each(|&i| alone[i] = -sizes[i]);
        let with = self.board.with_sizes(columns, sizes);
        let mark = apart(self.board, &self.board.with_sizes(columns, &alone).left);
        if squares(self.board, &mark, late.clone()) < SHOWS {
            return None;
        }
        // What the early turns hardly size foretells nothing.
        let late_on = |i: usize, j: usize| {
            let each = columns[i]
                .0
                .iter()
                .zip(&columns[j].0)
                .zip(&self.board.benches);
            each.map(|((a, b), bench)| match (a, b) {
                (Some(a), Some(b)) => {
                    let late = bench.part(late.start).start..bench.part(late.end - 1).end;
                    a[late.clone()]
                        .iter()
                        .zip(&b[late])
                        .map(|(a, b)| a * b)
                        .sum::<f64>()
                }
                _ => 0.0,
            })
            .sum::<f64>()
        };
        let pairs = own.iter().flat_map(|&i| own.iter().map(move |&j| (i, j)));
        let doubt: f64 = pairs
            .map(|(i, j)| fitted.covariance[(i, j)] * late_on(i, j))
            .sum();
        if doubt > DOUBT * squares(self.board, &mark, late.clone()) {
            return None;
        }
        // Least squares with these held at zero.
        let part = |rows: &[usize]| {
            DMatrix::from_fn(rows.len(), own.len(), |i, j| {
                fitted.covariance[(rows[i], own[j])]
            })
        };
        let held = DVector::from_fn(own.len(), |j, _| sizes[own[j]]);
        let moved = part(&rest) * part(&own).cholesky()?.solve(&held);
        let mut others = DVector::zeros(columns.len());
        for (at, &i) in rest.iter().enumerate() {
            others[i] = sizes[i] - moved[at];
        }
        let without = self.board.with_sizes(columns, &others);
        let shows = spread(self.board, &mark, late.clone());
        let is = spread(self.board, &with.left, late.clone());
        let was = spread(self.board, &without.left, late);
        let ratio = ratio(shows, is, was, self.noise);
        ratio.is_finite().then_some(ratio)
    }
}

/// RMS that is over RMS that was, in the part of the residual in which a mark stands out of the noise most.
fn ratio(mark: Spread, is: Spread, was: Spread, noise: Spread) -> f64 {
    let (mark, noise) = (mark.all_rad(), noise.all_rad());
    let clear = |part: &usize| mark[*part] / noise[*part];
    let part = (0..mark.len()).max_by(|a, b| clear(a).total_cmp(&clear(b)));
    let part = part.unwrap_or(0);
    is.all_rad()[part] / was.all_rad()[part]
}
