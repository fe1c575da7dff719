//! What happens once: a stretch of time in which the shaft is pushed, a place on the disc that is out of line.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::basis::{Basis, channels};
use super::board::{Bench, Board, Model};
use super::hypothesis::Hypothesis;
use crate::mechanism::Mechanism;

/// Cells of time that a push is looked for in.
const CELLS: usize = 160;
/// Sum of squares over that of noise, from which on it is worth a closer look.
const WORTH: f64 = 25.0;

/// The time in which a recording's shaft is most clearly pushed: white torque noise is what innovations are made of, so a torque is
/// a mean of theirs.
#[must_use]
pub fn loads(board: &Board, model: &Model) -> Vec<Hypothesis> {
    let each = board.benches.iter().zip(&model.left);
    each.filter_map(|(bench, left)| load(bench, left)).collect()
}

fn load(bench: &Bench, left: &[f64]) -> Option<Hypothesis> {
    let seen = &bench.seen;
    let (start, long) = (*seen.times_s.first()?, seen.seconds());
    let (mut sums, mut counts) = ([0.0; CELLS + 1], [0.0; CELLS + 1]);
    for (time, value) in seen.times_s.iter().zip(left) {
        let cell = ((time - start) / long * CELLS as f64) as usize;
        let cell = cell.min(CELLS - 1) + 1;
        sums[cell] += value;
        counts[cell] += 1.0;
    }
    for cell in 1..=CELLS {
        sums[cell] += sums[cell - 1];
        counts[cell] += counts[cell - 1];
    }
    let mean = sums[CELLS] / counts[CELLS];
    let mut best = (WORTH, 0, 0);
    for from in 0..CELLS {
        for until in from + 1..=CELLS {
            let count = counts[until] - counts[from];
            let share = count * (1.0 - count / counts[CELLS]);
            let sum = sums[until] - sums[from] - mean * count;
            if share > 0.0 && sum * sum / share > best.0 {
                best = (sum * sum / share, from, until);
            }
        }
    }
    let time = |cell: usize| start + long * cell as f64 / CELLS as f64;
    // A push into the end has no end.
    let until_s = if best.2 == CELLS {
        f64::INFINITY
    } else {
        time(best.2)
    };
    let from_s = if best.1 == 0 {
        f64::NEG_INFINITY
    } else {
        time(best.1)
    };
    (best.0 > WORTH).then(|| Hypothesis::of(Mechanism::LoadStep, Basis::Load { from_s, until_s }))
}

/// Places of the disc that are most clearly out of line, by kind of edge.
#[must_use]
pub fn defects(board: &Board, model: &Model) -> Vec<Hypothesis> {
    let Some(first) = board.benches.first() else {
        return Vec::new();
    };
    let (edges, classes) = (first.seen.edges as usize, first.seen.classes);
    if edges < 24 || (board.benches.len() > 1 && !board.tied) {
        return Vec::new();
    }
    let pull = pull(board, model);
    let step = TAU / edges as f64;
    let mut kinds: Vec<(Option<usize>, Option<bool>)> = vec![(None, None)];
    if classes > 1 {
        kinds.extend([(None, Some(true)), (None, Some(false))]);
    }
    if channels(classes) > 1 {
        for channel in 0..channels(classes) {
            kinds.extend([None, Some(true), Some(false)].map(|rises| (Some(channel), rises)));
        }
    }
    let of_kind =
        |(channel, rises): (Option<usize>, Option<bool>)| {
            let mut best: Vec<(f64, Hypothesis)> = Vec::new();
            let mask: Vec<f64> = (0..edges)
                .map(|edge| {
                    let change = super::basis::change_of(
                        (edge + first.seen.shift as usize) % classes as usize,
                        classes,
                    );
                    let hit = channel.is_none_or(|c| c == change.channel)
                        && rises.is_none_or(|r| r == change.rises);
                    f64::from(u8::from(hit))
                })
                .collect();
            let masked: Vec<f64> = pull.iter().zip(&mask).map(|(p, m)| p * m).collect();
            for width in [1.0, 2.0, 4.0, 8.0, 16.0, 32.0] {
                if width * 8.0 > edges as f64 {
                    continue;
                }
                let smooth = smoothed(&masked, width);
                let (at, peak) = smooth.iter().copied().enumerate().fold(
                    (0, 0.0),
                    |best: (usize, f64), (at, v)| {
                        if v.abs() > best.1 {
                            (at, v.abs())
                        } else {
                            best
                        }
                    },
                );
                let basis = Basis::Bump {
                    angle_rad: at as f64 * step,
                    width_rad: width * step,
                    channel,
                    rises,
                };
                // The bump's own size is close to that of any other of its kind: no need to know it before it may win.
                best.push((
                    peak / width.sqrt(),
                    Hypothesis::of(Mechanism::LocalDefect, basis),
                ));
            }
            best
        };
    let kinds = kinds.into_par_iter();
    let mut best: Vec<(f64, Hypothesis)> = kinds.flat_map_iter(of_kind).collect();
    best.sort_by(|a, b| b.0.total_cmp(&a.0));
    best.truncate(12);
    best.into_iter().map(|(_, hypothesis)| hypothesis).collect()
}

/// How strongly what is left pulls at every edge of the disc: the gradient of the sum of squares.
#[must_use]
pub fn pull(board: &Board, model: &Model) -> Vec<f64> {
    let edges = board
        .benches
        .first()
        .map_or(0, |bench| bench.seen.edges as usize);
    let mut pull = vec![0.0; edges];
    for (bench, left) in board.benches.iter().zip(&model.left) {
        let mut back = left.clone();
        bench.transposed(&mut back);
        for (at, value) in back.iter().enumerate() {
            pull[bench.seen.edge(at)] += value;
        }
    }
    pull
}

/// Around the turn, with a Gaussian of so many edges.
fn smoothed(values: &[f64], width: f64) -> Vec<f64> {
    let reach = (3.5 * width).ceil() as usize;
    let kernel: Vec<f64> = (0..=reach)
        .map(|d| (-0.5 * (d as f64 / width).powi(2)).exp())
        .collect();
    let count = values.len();
    let before = (count - reach % count) % count;
    let round = values.iter().cycle().skip(before);
    let round: Vec<f64> = round.take(count + 2 * reach).copied().collect();
    let mut sums = values.to_vec();
    for (d, weight) in kernel.iter().enumerate().skip(1) {
        let (after, before) = (&round[reach + d..], &round[reach - d..]);
        for ((sum, after), before) in sums.iter_mut().zip(after).zip(before) {
            *sum += weight * (after + before);
        }
    }
    sums
}
