//! Named parts of a disc that its whole pattern does without.
//!
//! A coarse disc whose edges err each by itself has few orders and few places, of which one may stand out before the pattern is learned.
//! With the pattern known they have no mark of their own: learned anew without them, it leaves as little, and that its edges then err by
//! more is no less likely by as much as their numbers cost.

use super::basis::Basis;
use super::board::Board;
use super::disc::{self, Pattern, merged};
use super::least_squares::squares;
use super::search::{BEYOND, Found, Searched, columns};
use crate::mechanism::Mechanism;

/// Times that what is left of the pattern is looked for; each leaves half of it or so.
const TIMES: usize = 40;

/// Takes the parts off a search that has a pattern, and leaves them to that, if it explains as much without any of them.
pub fn absorb(board: &mut Board, searched: &mut Searched) {
    if let Some((there, absorbed)) = absorbed(board, searched) {
        (*board, *searched) = (there, absorbed);
    }
}

fn absorbed(board: &Board, searched: &Searched) -> Option<(Board, Searched)> {
    let (parts, found): (Vec<Found>, Vec<Found>) =
        searched.found.iter().cloned().partition(is_part);
    if parts.is_empty() {
        return None;
    }
    let nuisances = &searched.model.columns[..searched.nuisances];
    let before = searched.pattern.as_ref()?;
    let most = squares(&searched.model) + BEYOND * parts.len() as f64;
    let each = (board.edges() as f64).ln();
    let numbers = |part: &Found| part.columns.len() + part.hypothesis.searched();
    let cost = |part: &Found| BEYOND + numbers(part) as f64 * each;
    let cost: f64 = parts.iter().map(cost).sum();
    let mut there = board.clone();
    let mut model = there.fit(columns(nuisances, &found))?;
    let mut pattern = searched.pattern.clone();
    for _ in 0..TIMES {
        let more = disc::pattern(&there, &model, true)?;
        there.take_off(&more.errors_rad);
        pattern = merged(pattern, Some(more));
        model = there.fit(columns(nuisances, &found))?;
        if less_likely(board, before, pattern.as_ref()?) > cost {
            return None;
        }
        if squares(&model) < most {
            let absorbed = Searched {
                found,
                pattern,
                model,
                ..searched.clone()
            };
            return Some((there, absorbed));
        }
    }
    None
}

/// By how much less likely it is that edges err as another pattern has it, each by itself: as twice a difference of logarithms.
fn less_likely(board: &Board, before: &Pattern, after: &Pattern) -> f64 {
    let seen = board.benches.first().map(|bench| &bench.seen);
    let own = seen.map_or(0, |seen| seen.edges - seen.classes);
    let square = |pattern: &Pattern| pattern.errors_rad.iter().map(|e| e * e).sum::<f64>();
    own as f64 * (square(after) / square(before)).ln()
}

fn is_part(found: &Found) -> bool {
    let wave = [Mechanism::Eccentricity, Mechanism::DiscTilt];
    let place = matches!(found.hypothesis.bases.first(), Some(Basis::Bump { .. }));
    place || wave.contains(&found.hypothesis.mechanism)
}
