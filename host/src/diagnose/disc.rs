//! The disc's whole pattern: how likely it is that every edge has an error of its own, and which.
//!
//! With white errors of variance s^2 the pattern is white over the orders m as well. What is left of the residual pulls at order m
//! with z_m, of variance 1 from noise alone and 1 + s^2 l_m with the pattern, l_m being how clearly order m shows through the
//! noise: the logarithm of the likelihood ratio is the sum of |z|^2 g / (1 + g) - ln(1 + g) with g = s^2 l, largest over s. The
//! pattern's mean given the recording is g / (1 + g) of what each order pulls (Wiener).

use std::ops::Range;

use realfft::RealFftPlanner;
use realfft::num_complex::Complex;

use super::board::{Board, Model, PARTS};
use super::scan::pull;

/// A pattern and how likely it is.
#[derive(Clone, Debug)]
pub struct Pattern {
    /// RMS error, rad.
    pub rms_rad: f64,
    /// Standard error of it, rad.
    pub standard_error_rad: f64,
    /// Twice the logarithm of the likelihood ratio, less Schwarz's cost of its one number.
    pub score: f64,
    /// Error of each edge, rad.
    pub errors_rad: Vec<f64>,
    /// Standard error of each of them, rad.
    pub edge_error_rad: f64,
    /// How many numbers the recordings settle of it.
    pub numbers: f64,
}

/// Edges that a pattern needs.
const EDGES_LEAST: usize = 4;

/// The pattern that a model leaves; orders that another mechanism may own are left to it.
#[must_use]
pub fn pattern(board: &Board, model: &Model) -> Option<Pattern> {
    pattern_in(board, model, 0..PARTS)
}

/// The same, going by some parts of the recordings only.
#[must_use]
pub fn pattern_in(board: &Board, model: &Model, parts: Range<usize>) -> Option<Pattern> {
    let first = board.benches.first()?;
    let edges = first.seen.edges as usize;
    let lines = edges / first.seen.classes as usize;
    if edges < EDGES_LEAST || (board.benches.len() > 1 && !board.tied) || first.seen.turns() < 3.0 {
        return None;
    }
    let mut planner = RealFftPlanner::<f64>::new();
    let forward = planner.plan_fft_forward(edges);
    let spectrum = |mut row: Vec<f64>| -> Vec<Complex<f64>> {
        let mut output = forward.make_output_vec();
        let _ = forward.process(&mut row, &mut output);
        output
    };
    let clear = clearness(board, edges, &parts, &spectrum);
    let pulled = spectrum(pull(board, model, parts));
    // What is the same for all edges of a class has names of its own.
    let own = |order: usize| {
        order != 0 && (lines == 0 || !order.is_multiple_of(lines)) && 2 * order <= edges
    };
    // From edge to edge there and back is one number, not two.
    let weight = |order: usize| if 2 * order == edges { 0.5 } else { 1.0 };
    let orders: Vec<usize> = (0..pulled.len())
        .filter(|order| own(*order) && clear[*order] > 0.0)
        .collect();
    let modes: Vec<(f64, f64, f64)> = orders
        .iter()
        .map(|&m| {
            let z2 = pulled[m].norm_sqr() / (edges as f64 * clear[m]);
            (z2, clear[m], weight(m))
        })
        .collect();
    let likelihood = |log_s2: f64| {
        let s2 = log_s2.exp();
        let each = modes.iter().map(|(z2, l, weight)| {
            let g = s2 * l;
            weight * (z2 * g / (1.0 + g) - g.ln_1p())
        });
        2.0 * each.sum::<f64>()
    };
    let middle = {
        let mut ls: Vec<f64> = modes.iter().map(|mode| mode.1).collect();
        ls.sort_by(f64::total_cmp);
        -ls.get(ls.len() / 2)?.ln()
    };
    let mut best = (middle, f64::NEG_INFINITY);
    for step in -60..=60 {
        let at = middle + 0.25 * f64::from(step);
        let there = likelihood(at);
        if there > best.1 {
            best = (at, there);
        }
    }
    let side = 0.1;
    let bend =
        (likelihood(best.0 - side) - 2.0 * best.1 + likelihood(best.0 + side)) / (side * side);
    let s2 = best.0.exp();
    let mut shrunk: Vec<Complex<f64>> = vec![Complex::new(0.0, 0.0); pulled.len()];
    let (mut edge_variance, mut numbers) = (0.0, 0.0);
    for &m in &orders {
        let g = s2 * clear[m];
        shrunk[m] = pulled[m] * (g / (1.0 + g) / clear[m] / edges as f64);
        numbers += 2.0 * weight(m) * g / (1.0 + g);
        edge_variance += 2.0 * weight(m) / (clear[m] * edges as f64);
    }
    let inverse = planner.plan_fft_inverse(edges);
    let mut errors_rad = inverse.make_output_vec();
    let _ = inverse.process(&mut shrunk, &mut errors_rad);
    // -bend is twice the information on ln s^2.
    let deviation = if bend < 0.0 {
        (2.0 / -bend).sqrt()
    } else {
        f64::INFINITY
    };
    Some(Pattern {
        rms_rad: s2.sqrt(),
        standard_error_rad: 0.5 * deviation * s2.sqrt(),
        score: best.1 - (board.edges() as f64).ln(),
        errors_rad,
        edge_error_rad: edge_variance.sqrt(),
        numbers,
    })
}

/// How clearly each order shows: the answer of the pull to one edge of each kind, over the orders.
fn clearness(
    board: &Board,
    edges: usize,
    parts: &Range<usize>,
    spectrum: &dyn Fn(Vec<f64>) -> Vec<Complex<f64>>,
) -> Vec<f64> {
    let classes = board.benches[0].seen.classes as usize;
    let mut clear = vec![0.0; edges / 2 + 1];
    let tried = [edges / 3, edges / 3 + edges / 2];
    for start in tried {
        for class in 0..classes {
            let one = (start / classes * classes + class) % edges;
            let mut answer = vec![0.0; edges];
            for bench in &board.benches {
                let seen = &bench.seen;
                let mut row: Vec<f64> = (0..seen.len())
                    .map(|at| if seen.edge(at) == one { 1.0 } else { 0.0 })
                    .collect();
                row = bench.whitened(row);
                bench.cut(&mut row, parts);
                bench.transposed(&mut row);
                for (at, value) in row.iter().enumerate() {
                    answer[(seen.edge(at) + edges - one) % edges] += value;
                }
            }
            for (sum, value) in clear.iter_mut().zip(spectrum(answer)) {
                *sum += value.re / (tried.len() * classes) as f64;
            }
        }
    }
    clear
}
