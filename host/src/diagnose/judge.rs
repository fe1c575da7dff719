//! How well it fits, on all turns and on turns that nothing was fitted on.

use super::board::{Board, Column, FITTED, Model, PARTS};
use super::diagnosis::{Fit, HeldOut};
use super::disc::pattern_in;
use super::search::Searched;

/// Sums over the edges of some parts.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    white: f64,
    rad: f64,
    floor: f64,
    count: f64,
}

impl Sums {
    fn rms(self, sum: f64) -> f64 {
        (sum / self.count.max(1.0)).sqrt()
    }
}

/// RMS of what a model leaves, rad.
#[must_use]
pub fn rms_rad(board: &Board, model: &Model) -> f64 {
    let sums = sums(board, model, 0..PARTS);
    sums.rms(sums.rad)
}

/// The fit of a search, against the twin as it was given.
#[must_use]
pub fn fit(board: &Board, before: &Model, searched: &Searched, whiteness: (f64, f64)) -> Fit {
    let all = 0..PARTS;
    let (was, is) = (
        sums(board, before, all.clone()),
        sums(board, &searched.model, all),
    );
    Fit {
        rms_before_rad: was.rms(was.rad),
        rms_after_rad: is.rms(is.rad),
        floor_rad: is.rms(is.floor),
        whiteness_p_before: whiteness.0,
        whiteness_p: whiteness.1,
        held_out: held_out(board, before, searched),
    }
}

fn held_out(board: &Board, before: &Model, searched: &Searched) -> HeldOut {
    let late = FITTED..PARTS;
    let was = sums(board, before, late.clone());
    let none = HeldOut {
        rms_before_rad: was.rms(was.rad),
        rms_after_rad: was.rms(was.rad),
        floor_rad: was.rms(was.floor),
        reducible_removed: None,
    };
    let columns = &searched.model.columns;
    // The disc's pattern as some turns show it.
    let without_pattern = |parts: std::ops::Range<usize>| {
        let mut board = board.clone();
        let rest = board.with_sizes(columns, &searched.model.sizes);
        let pattern = searched.pattern.as_ref();
        let pattern = pattern.and_then(|_| pattern_in(&board, &rest, parts));
        if let Some(pattern) = &pattern {
            board.take_off(&pattern.errors_rad);
        }
        (board, pattern.map_or(0.0, |pattern| pattern.numbers))
    };
    if columns.is_empty() && searched.pattern.is_none() {
        return none;
    }
    let (first, _) = without_pattern(0..FITTED);
    let (second, of_pattern) = without_pattern(late.clone());
    let nuisances: Vec<Column> = columns[..searched.nuisances].to_vec();
    // What was never there in the turns before can't be foretold.
    let (Some(fitted), Some(best)) = (
        first.fit(board.cut(columns, 0..FITTED)),
        second.fit(board.cut(columns, late.clone())),
    ) else {
        return none;
    };
    let alone = board.fit(board.cut(&nuisances, late.clone()));
    let of = |board: &Board, columns: &[Column], sizes: &nalgebra::DVector<f64>| {
        sums(board, &board.with_sizes(columns, sizes), late.clone())
    };
    let is = of(&first, columns, &fitted.sizes);
    let at_best = of(&second, columns, &best.sizes);
    let without = alone.map(|alone| of(board, &nuisances, &alone.sizes));
    let numbers = (columns.len() - searched.nuisances) as f64 + of_pattern;
    let reducible = without.map_or(0.0, |without| without.white - at_best.white - numbers);
    let lost = is.white - at_best.white - numbers;
    HeldOut {
        rms_after_rad: is.rms(is.rad),
        floor_rad: is.rms(is.floor),
        reducible_removed: (reducible > 30.0).then(|| (1.0 - lost / reducible).clamp(0.0, 1.0)),
        ..none
    }
}

fn sums(board: &Board, model: &Model, parts: std::ops::Range<usize>) -> Sums {
    let mut sums = Sums::default();
    for (bench, left) in board.benches.iter().zip(&model.left) {
        let range = bench.part(parts.start).start..bench.part(parts.end - 1).end;
        let edges = bench.deviations().zip(left).enumerate();
        for (at, (deviation, white)) in edges.skip(range.start).take(range.len()) {
            let Some(deviation) = deviation.filter(|_| !bench.seen.follows(at)) else {
                continue;
            };
            sums.white += white * white;
            sums.rad += (white * deviation).powi(2);
            sums.floor += deviation * deviation;
            sums.count += 1.0;
        }
    }
    sums
}
