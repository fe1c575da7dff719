//! The disc's whole pattern: how likely it is that every edge has an error of its own, and which.
//!
//! With white errors of variance s^2 the pattern is white over the orders m as well. What is left of the residual pulls at order m
//! with z_m, of variance 1 from noise alone and 1 + s^2 l_m with the pattern, l_m being how clearly order m shows through the
//! noise: the logarithm of the likelihood ratio is the sum of |z|^2 g / (1 + g) - ln(1 + g) with g = s^2 l, largest over s. The
//! pattern's mean given the recording solves (A + 1/s^2) e = pull, A being how edges show through the noise: by conjugate gradients,
//! started from g / (1 + g) of what each order pulls (Wiener).

use realfft::num_complex::Complex;

use super::board::{Board, Model, PARTS};
use super::disc_shown::{Disc, FAR, Kept};

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
}

/// Orders up to which one of them may be all that the disc shows.
const FEW: usize = 2;
/// Part of the pattern's squares that makes it one order's.
const ALONE: f64 = 0.9;

/// Score that a pattern would have in what a model leaves; none where one order is all of it, unless a pattern was `learned` before.
#[must_use]
pub fn score(board: &Board, model: &Model, learned: bool) -> Option<f64> {
    let disc = Disc::of(board)?;
    let modes = modes(&disc, &disc.spectrum(pulled(&disc, model)));
    if !learned && of_one_order(&modes) {
        return None;
    }
    Some(score_of(board, likeliest(&modes)?.1))
}

/// The pattern that a model leaves; orders that another mechanism may own are left to it, unless a pattern was `learned` before.
#[must_use]
pub fn pattern(board: &Board, model: &Model, learned: bool) -> Option<Pattern> {
    let disc = Disc::of(board)?;
    let pulled = pulled(&disc, model);
    let spectrum = disc.spectrum(pulled.clone());
    let modes = modes(&disc, &spectrum);
    if !learned && of_one_order(&modes) {
        return None;
    }
    let shares = modes.iter().map(|mode| 2.0 * mode.weight / mode.clear);
    let edge_variance = shares.sum::<f64>() / disc.edges as f64;
    let (log_s2, most, bend) = likeliest(&modes)?;
    let s2 = log_s2.exp();
    Some(Pattern {
        rms_rad: s2.sqrt(),
        standard_error_rad: standard_error(log_s2, bend),
        score: score_of(board, most),
        errors_rad: disc.solved(pulled, &disc.prior(&spectrum, s2), &|_| true),
        edge_error_rad: edge_variance.sqrt(),
    })
}

/// The same where orders that stand far out of the pattern are sizes of their own; 0 where there is nothing.
#[must_use]
pub fn score_of_orders(board: &Board, model: &Model) -> Option<f64> {
    const TIMES: usize = 3;
    let disc = Disc::of(board)?;
    let mut modes = modes(&disc, &disc.spectrum(pulled(&disc, model)));
    let cost = (board.edges() as f64).ln();
    let (mut best, mut apart) = (0.0_f64, 0.0);
    for _ in 0..TIMES {
        let Some((log_s2, most, _)) = likeliest(&modes) else {
            break;
        };
        best = best.max(apart + score_of(board, most).max(0.0));
        let s2 = log_s2.exp();
        let own = |mode: &Mode| mode.squares > FAR * (1.0 + s2 * mode.clear);
        let far = modes.iter().filter(|mode| own(mode));
        let gained: f64 = far
            .map(|mode| 2.0 * mode.weight * (mode.squares - cost))
            .sum();
        if gained == 0.0 {
            break;
        }
        apart += gained;
        modes.retain(|mode| !own(mode));
    }
    Some(best.max(apart))
}

/// How strongly what a model leaves pulls at every edge, in the pattern's own orders.
fn pulled(disc: &Disc<'_>, model: &Model) -> Vec<f64> {
    disc.own(&disc.folded(model.left.clone()))
}

/// What one order makes is a rhythm: others name it.
fn of_one_order(modes: &[Mode]) -> bool {
    let all: f64 = modes.iter().map(|mode| mode.weight * mode.squares).sum();
    let top = modes.iter().map(|mode| mode.squares).fold(0.0, f64::max);
    modes.len() > FEW && top > ALONE * all
}

/// Twice the logarithm of a likelihood ratio less what its one number costs.
fn score_of(board: &Board, likelihood: f64) -> f64 {
    likelihood - (board.edges() as f64).ln()
}

/// Size and its standard error of a pattern that white rows still have, rad: with the noise and the findings beside it as they are
/// known in the end.
pub fn sized(disc: &Disc<'_>, there: &[Vec<f64>]) -> Option<(f64, f64)> {
    let spectrum = disc.spectrum(disc.own(&disc.folded(there.to_vec())));
    let (log_s2, _, bend) = likeliest(&modes(disc, &spectrum))?;
    Some(((0.5 * log_s2).exp(), standard_error(log_s2, bend)))
}

/// Two patterns, one found after the other was taken off.
#[must_use]
pub fn merged(first: Option<Pattern>, second: Option<Pattern>) -> Option<Pattern> {
    match (first, second) {
        (Some(mut first), Some(second)) => {
            for (error, more) in first.errors_rad.iter_mut().zip(&second.errors_rad) {
                *error += more;
            }
            Some(first)
        }
        (first, second) => first.or(second),
    }
}

/// -bend is twice the information on ln s^2.
fn standard_error(log_s2: f64, bend: f64) -> f64 {
    let deviation = if bend < 0.0 {
        (2.0 / -bend).sqrt()
    } else {
        f64::INFINITY
    };
    0.5 * deviation * (0.5 * log_s2).exp()
}

/// The orders' pulls.
fn modes(disc: &Disc<'_>, spectrum: &[Complex<f64>]) -> Vec<Mode> {
    let each = disc.orders.iter().map(|&m| Mode {
        squares: spectrum[m].norm_sqr() / (disc.edges as f64 * disc.clear[m]),
        clear: disc.clear[m],
        weight: disc.weight(m),
    });
    each.collect()
}

/// What a model leaves together with a pattern that was taken off, white.
#[must_use]
pub fn put_back(board: &Board, model: &Model, pattern: &Pattern) -> Vec<Vec<f64>> {
    let Some(disc) = Disc::of(board) else {
        return model.left.clone();
    };
    let mut rows = disc.rows(&pattern.errors_rad);
    for (row, left) in rows.iter_mut().zip(&model.left) {
        for (value, left) in row.iter_mut().zip(left) {
            *value += left;
        }
    }
    rows
}

/// Share of the pattern learned in some of the parts of white rows that comes again in the others, once each way, and its standard
/// error: 1 where it is a disc's.
#[must_use]
pub fn comes_again(board: &Board, there: &[Vec<f64>], rms_rad: f64) -> Vec<(f64, f64)> {
    let Some(disc) = Disc::of(board) else {
        return Vec::new();
    };
    let spectrum = disc.spectrum(disc.own(&disc.folded(there.to_vec())));
    let prior = disc.prior(&spectrum, rms_rad * rms_rad);
    let early = |part: usize| 2 * part < PARTS;
    let late = |part: usize| 2 * part >= PARTS;
    let ways: [(Kept<'_>, Kept<'_>); 2] = [(&early, &late), (&late, &early)];
    let mut shares = Vec::new();
    for (learned, judged) in ways {
        let mut rows = there.to_vec();
        disc.keep(&mut rows, learned);
        let pulled = disc.own(&disc.folded(rows));
        let errors = disc.solved(pulled, &prior, learned);
        let mut foretold = disc.rows(&errors);
        disc.keep(&mut foretold, judged);
        let product = |a: &[Vec<f64>], b: &[Vec<f64>]| -> f64 {
            let rows = a.iter().zip(b);
            rows.map(|(a, b)| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>())
                .sum()
        };
        let power = product(&foretold, &foretold);
        if power > 0.0 {
            shares.push((product(&foretold, there) / power, power.sqrt().recip()));
        }
    }
    shares
}

/// An order's pull.
#[derive(Clone, Copy, Debug)]
struct Mode {
    /// Its square over what noise alone makes of it.
    squares: f64,
    /// How clearly it shows.
    clear: f64,
    /// 1, or 0.5 where it is one number, not two.
    weight: f64,
}

/// The variance, as a logarithm, that makes the orders' pulls most likely; twice the logarithm of their likelihood ratio there, and
/// how it bends.
fn likeliest(modes: &[Mode]) -> Option<(f64, f64, f64)> {
    let likelihood = |log_s2: f64| {
        let s2 = log_s2.exp();
        let each = modes.iter().map(|mode| {
            let g = s2 * mode.clear;
            mode.weight * (mode.squares * g / (1.0 + g) - g.ln_1p())
        });
        2.0 * each.sum::<f64>()
    };
    let middle = {
        let mut ls: Vec<f64> = modes.iter().map(|mode| mode.clear).collect();
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
    Some((best.0, best.1, bend))
}
