//! What is too large for a linear model: recordings held against the twins with it, and linear about those.
//!
//! A mark goes with the size of what makes it only while that is small. A drive that drifts by two parts in a hundred turns so far from
//! its twin that a speed step passes elsewhere, and what a linear model leaves of that looks like more of the kind, or like nothing
//! that is known. Simulated with it, the twin leaves little; with the mark of its own size put on top again, that is the residual of a
//! linear model about the right place (Gauss and Newton's).

use super::basis::Basis;
use super::board::{Board, Column, Model};
use super::estimate::{Estimate, estimates};
use super::least_squares::squares;
use super::mended;
use super::prepare;
use super::rests::{far, rests};
use super::run::Recorded;
use super::search::{Found, Searched};
use super::shortened::{common, longer};

/// Times that twins are simulated, and standard errors that are no move any more.
const TIMES: usize = 6;
const NEAR: f64 = 0.3;
/// Part of what is beyond noise that may be left of it.
const PART: f64 = 0.3;
/// Standard deviations of one edge that the mark has at the least: what is smaller is linear.
const LARGE: f64 = 100.0;

/// The recordings linear about twins that have the strongest finding, where that leaves far less; none where it does not.
#[must_use]
pub fn about(rig: &[Recorded], given: &Board, searched: &Searched) -> Option<Board> {
    let pushes = |one: &&Found| one.hypothesis.bases.iter().all(|basis| pushes(*basis));
    let strongest = searched.found.iter().filter(pushes);
    let strongest = strongest.max_by(|a, b| a.score.total_cmp(&b.score))?;
    let alone = alone(given, strongest)?;
    let beyond = |model: &Model| squares(model) - given.edges() as f64;
    let before = beyond(&alone.model);
    if beyond(&given.fit(given.nuisances())?) < LARGE * LARGE {
        return None;
    }
    let mut numbers = estimates(given, &alone);
    let mut board = given.clone();
    for _ in 0..TIMES {
        let (twins, _) = mended::twins(rig, given, None, &numbers);
        let mut next = prepare::board(&mended::with_twins(rig, &twins)).ok()?;
        let both = common(given, &next)?;
        if longer(given, &both) || longer(&next, &both) {
            return None;
        }
        for (bench, known) in next.benches.iter_mut().zip(&given.benches) {
            bench.set_noise(known.noise);
        }
        let rests = rests(&next, &alone, &numbers)?;
        let moved = far(&numbers, &rests);
        put_on_top(&mut next, &numbers);
        board = next;
        for (number, rest) in numbers.iter_mut().zip(rests) {
            rest.add_to(&board, number);
        }
        if moved < NEAR {
            break;
        }
    }
    let columns = numbers
        .iter()
        .flat_map(|one| one.hypothesis.columns(&board));
    let after = board.fit(board.nuisances().into_iter().chain(columns).collect())?;
    (beyond(&after) < PART * before).then_some(board)
}

/// Whether it moves the shaft: what the disc and the capture do to edges is linear.
const fn pushes(basis: Basis) -> bool {
    matches!(
        basis,
        Basis::TorqueOrder { .. }
            | Basis::TorqueTone { .. }
            | Basis::Load { .. }
            | Basis::Drift
            | Basis::Warming { .. }
            | Basis::Coulomb
            | Basis::Viscous
            | Basis::Drag
            | Basis::Stribeck { .. }
    )
}

/// One finding by itself.
fn alone(board: &Board, found: &Found) -> Option<Searched> {
    let nuisances = board.nuisances();
    let count = nuisances.len();
    let columns = found.hypothesis.columns(board);
    let all = nuisances.into_iter().chain(columns.iter().cloned());
    Some(Searched {
        model: board.fit(all.collect())?,
        found: vec![Found {
            columns,
            rivals: Vec::new(),
            ..found.clone()
        }],
        pattern: None,
        nuisances: count,
        left: 0.0,
        passing: 0.0,
    })
}

/// Puts the marks of findings on top of what twins that have them leave.
fn put_on_top(board: &mut Board, numbers: &[Estimate]) {
    for number in numbers {
        let columns: Vec<Column> = number.hypothesis.raw_columns(board);
        for (at, bench) in board.benches.iter_mut().enumerate() {
            for (column, size) in columns.iter().zip(&number.sizes) {
                let mark = column.0[at].iter().flatten();
                let angles = bench.seen.angles.iter_mut();
                angles
                    .zip(mark)
                    .for_each(|(angle, mark)| *angle += size * mark);
            }
        }
    }
    for bench in &mut board.benches {
        bench.set_noise(bench.noise);
    }
    board.forget();
}
