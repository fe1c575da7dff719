//! Whether what is left, made white with fitted levels, is white in every other respect: spread by stamps is.

use realfft::RealFftPlanner;

use super::super::basis::change_of;
use super::super::board::Board;
use super::levels::Levels;

/// Bands of the spectrum, and how far their mean power may be off, in standard deviations and at all.
const BANDS: usize = 60;
const DEVIATIONS: f64 = 7.0;
const OFF: f64 = 0.25;
/// Power of a line that noise does not reach.
const LINE: f64 = 22.0;
/// Share that repeats, of the squares that noisier stamps explain.
const SHARE: f64 = 0.2;

/// Whether it is: no band louder than others, no lines, nothing that repeats each turn, of all edges or of rises against falls.
#[must_use]
pub fn is_flat(board: &Board, levels: &Levels) -> bool {
    let gain = levels.gain();
    board
        .benches
        .iter()
        .zip(&levels.white)
        .all(|(bench, white)| {
            let seen = &bench.seen;
            let squares = (2.0 * white.len() as f64 * gain).sqrt();
            let rises: Vec<f64> = white
                .iter()
                .enumerate()
                .map(|(at, w)| {
                    if change_of(seen.class(at), seen.classes).rises {
                        *w
                    } else {
                        -w
                    }
                })
                .collect();
            let level = seen.classes < 2 || even(&rises, squares);
            level
                && even(white, squares)
                && !repeats(white, usize::try_from(seen.edges).unwrap_or(0), squares)
        })
}

/// Whether the spectrum of a row has no band and no line that stands out.
fn even(white: &[f64], squares: f64) -> bool {
    let count = white.len() & !1;
    if count < 8 * BANDS {
        return true;
    }
    let forward = RealFftPlanner::<f64>::new().plan_fft_forward(count);
    let mut input = white[..count].to_vec();
    let mut output = forward.make_output_vec();
    if forward.process(&mut input, &mut output).is_err() {
        return true;
    }
    let sum: f64 = white[..count].iter().map(|w| w * w).sum();
    let powers: Vec<f64> = output[1..count / 2]
        .iter()
        .map(|x| x.norm_sqr() / sum)
        .collect();
    let lines: f64 = powers.iter().filter(|p| **p > LINE).map(|p| 2.0 * p).sum();
    let off = powers.chunks(powers.len() / BANDS + 1).any(|band| {
        // A line is no band.
        let mean = band.iter().map(|p| p.min(LINE)).sum::<f64>() / band.len() as f64;
        (mean - 1.0).abs() > OFF && (mean - 1.0).abs() * (band.len() as f64).sqrt() > DEVIATIONS
    });
    !off && lines < SHARE * squares
}

/// Whether a good part of a row is the same one turn later.
fn repeats(white: &[f64], turn: usize, squares: f64) -> bool {
    if turn == 0 || white.len() < 3 * turn {
        return false;
    }
    let pairs = white.iter().zip(&white[turn..]);
    let both: f64 = pairs.map(|(a, b)| a * b).sum();
    let count = (white.len() - turn) as f64;
    both > 6.0 * count.sqrt() && both > SHARE * squares
}
