//! How much of what has no name comes again: a shape that one half of the turns foretells in the other.
//!
//! The edges' pattern is learned from one half of each recording and taken off the other, and the other way round. The fall of the sum
//! of squares, over all that stands above noise, is the part that a table of the disc would take away; the rest goes by another clock.

use super::board::Board;
use super::disc::{comes_again, white_of};
use super::disc_shown::Disc;

/// A share and its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repeats {
    /// 0 to 1.
    pub share: f64,
    /// Its standard error.
    pub standard_error: f64,
}

/// The share of white rows, above noise, that comes again each turn; none where nothing stands above noise.
#[must_use]
pub fn repeats(board: &Board, left: &[Vec<f64>]) -> Option<Repeats> {
    let squares: f64 = left.iter().flatten().map(|w| w * w).sum();
    let count = left.iter().map(Vec::len).sum::<usize>() as f64;
    let above = squares - count;
    if above <= (2.0 * count).sqrt() {
        return None;
    }
    let none = Repeats {
        share: 0.0,
        standard_error: (2.0 * count).sqrt() / above,
    };
    let Some(white_rad) = Disc::of(board).and_then(|disc| white_of(&disc, left)) else {
        return Some(none);
    };
    // A half foretells with a share s of its power p, give or take 1/sqrt(p): the squares fall by p (2 s - 1).
    let halves = comes_again(board, left, white_rad);
    let (mut fall, mut variance) = (0.0, 0.0);
    for (share, error) in halves {
        let power = error.powi(-2);
        fall += power * (2.0 * share - 1.0);
        variance += 4.0 * power;
    }
    let share = (fall / above).clamp(0.0, 1.0);
    Some(Repeats {
        share,
        standard_error: variance.sqrt().max((2.0 * count).sqrt() * share) / above,
    })
}
