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
    /// RMS error of all its edges, rad.
    pub rms_rad: f64,
    /// Standard error of it, rad.
    pub standard_error_rad: f64,
    /// RMS error of edges that err each by itself, rad: what orders that stand far out of the others do not add to.
    pub white_rad: f64,
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
    let modes = modes(&disc, &disc.spectrum(pulled));
    if !learned && of_one_order(&modes) {
        return None;
    }
    let shares = modes.iter().map(|mode| 2.0 * mode.weight / mode.clear);
    let edge_variance = shares.sum::<f64>() / disc.edges as f64;
    let (log_s2, most) = likeliest(&modes)?;
    let s2 = log_s2.exp();
    let (errors_rad, prior) = solved(&disc, &model.left, s2, &|_| true)?;
    let (rms_rad, standard_error_rad) = size(&disc, &errors_rad, &prior);
    Some(Pattern {
        rms_rad,
        standard_error_rad,
        white_rad: s2.sqrt(),
        score: score_of(board, most),
        errors_rad,
        edge_error_rad: edge_variance.sqrt(),
    })
}

/// Errors of the pattern's own orders that white rows have in some parts, and the variance of each order before.
fn solved(
    disc: &Disc<'_>,
    there: &[Vec<f64>],
    s2: f64,
    kept: Kept<'_>,
) -> Option<(Vec<f64>, Vec<f64>)> {
    let whole = Disc::of(disc.board)?.with_classes();
    let pulled = |rows: Vec<Vec<f64>>| whole.own(&whole.folded(rows));
    let prior = whole.prior(&whole.spectrum(pulled(there.to_vec())), s2);
    let mut rows = there.to_vec();
    whole.keep(&mut rows, kept);
    let errors = whole.solved(pulled(rows), &prior, kept);
    Some((disc.own(&errors), prior))
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
        let Some((log_s2, most)) = likeliest(&modes) else {
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

/// RMS error, rad, of edges that err each by itself in a pattern that white rows still have: with the noise and the findings beside it
/// as they are known in the end.
pub fn white_of(disc: &Disc<'_>, there: &[Vec<f64>]) -> Option<f64> {
    let spectrum = disc.spectrum(disc.own(&disc.folded(there.to_vec())));
    let (log_s2, _) = likeliest(&modes(disc, &spectrum))?;
    Some((0.5 * log_s2).exp())
}

/// RMS of a pattern and its standard error, rad. Its errors are means given the recording and the variances that each order has before;
/// what they may be off, order by order, adds to their squares. That variance is itself only as sure as the orders are many that show
/// it, and where few show clearly the means hang on it.
pub fn size(disc: &Disc<'_>, errors_rad: &[f64], prior: &[f64]) -> (f64, f64) {
    let edges = disc.edges as f64;
    let spectrum = disc.spectrum(errors_rad.to_vec());
    let (mut squares, mut variance) = (0.0, 0.0);
    // The information on the logarithm of the variance before, and how the squares go with that.
    let (mut told, mut goes) = (0.0, 0.0);
    for &m in &disc.orders {
        let both = 2.0 * disc.weight(m) / edges;
        let own = spectrum[m].norm_sqr() / edges;
        let off = (disc.clear[m] + prior[m].recip()).recip();
        squares += both * (own + off);
        variance += both * both * off * (2.0 * own + off) / disc.weight(m);
        let kept = (1.0 + prior[m] * disc.clear[m]).recip();
        told += disc.weight(m) * (1.0 - kept).powi(2);
        goes += both * kept * (2.0 * own + off);
    }
    variance += goes * goes / told;
    let rms = squares.sqrt();
    (rms, 0.5 * variance.sqrt() / rms)
}

/// Orders of a pattern that stand far out of the others.
#[must_use]
pub fn far_orders(board: &Board, pattern: &Pattern) -> Option<Vec<usize>> {
    let disc = Disc::of(board)?;
    let spectrum = disc.spectrum(pattern.errors_rad.clone());
    let usual = FAR * pattern.white_rad.powi(2) * disc.edges as f64;
    let far = |m: &usize| spectrum[*m].norm_sqr() > usual;
    Some(disc.orders.iter().copied().filter(far).collect())
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
pub fn comes_again(board: &Board, there: &[Vec<f64>], white_rad: f64) -> Vec<(f64, f64)> {
    let Some(disc) = Disc::of(board) else {
        return Vec::new();
    };
    let early = |part: usize| 2 * part < PARTS;
    let late = |part: usize| 2 * part >= PARTS;
    let ways: [(Kept<'_>, Kept<'_>); 2] = [(&early, &late), (&late, &early)];
    let mut shares = Vec::new();
    for (learned, judged) in ways {
        let Some((errors, _)) = solved(&disc, there, white_rad * white_rad, learned) else {
            continue;
        };
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

/// The variance, as a logarithm, that makes the orders' pulls most likely; and twice the logarithm of their likelihood ratio there.
fn likeliest(modes: &[Mode]) -> Option<(f64, f64)> {
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
    for (steps, step) in [(60, 0.25_f64), (5, 0.05), (5, 0.01)] {
        let around = best.0;
        for number in -steps..=steps {
            let at = step.mul_add(f64::from(number), around);
            let there = likelihood(at);
            if there > best.1 {
                best = (at, there);
            }
        }
    }
    Some(best)
}
