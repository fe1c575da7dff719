//! Looks for what is missing, one mechanism after another, until what is left is noise.

use super::absorbed::absorb;
use super::anew::anew;
use super::basis::Basis;
use super::best::best;
use super::board::{Board, Column, Model};
use super::class_parts::{choice_beside_disc, other_choice};
use super::conclude::crowd;
use super::disc::{self, Pattern, merged};
use super::disc_parts::disc_parts;
use super::friction_terms::other_terms;
use super::hypothesis::Hypothesis;
use super::least_squares::squares;
use super::pairs::pair;
use super::propose::propose;
use super::scan::{defects, loads};
use super::sift::{beside_disc, no_disc, passes};
use super::weigh::Shelf;
use crate::mechanism::Mechanism;

/// Mechanisms at the most.
const MOST: usize = 12;
/// What a finding must explain beyond what its numbers cost, so that noise and the small errors of a linear model seldom give one.
pub const BEYOND: f64 = 60.0;
/// The same for what is tried whatever the residual shows, at no place that was searched for, and seen in one place of a recording:
/// five standard errors.
const AT_ONCE: f64 = 20.0;
/// Edges of a disc whose whole pattern must be worth two of its rhythms.
const FINE: f64 = 40.0;
/// Part of the score of anything else that more of a pattern that was learned must have.
const MORE: f64 = 0.9;
/// How much larger noise is that makes a pattern of its own.
const GROWN: f64 = 1.03;
/// Times that errors of all edges of a class are chosen anew, and terms of friction.
const CHOICES: usize = 8;
/// Times that what is left of the disc's pattern is looked for.
const PATTERNS: usize = 4;
/// Times that the search starts anew with the noise that it found.
const ROUNDS: usize = 3;

/// A mechanism that was found.
#[derive(Clone, Debug)]
pub struct Found {
    /// It.
    pub hypothesis: Hypothesis,
    /// Its columns.
    pub columns: Vec<Column>,
    /// What it explains beyond its cost.
    pub score: f64,
    /// Others in its place, with theirs, best first.
    pub rivals: Vec<(Hypothesis, f64)>,
}

/// What a search came to.
#[derive(Clone, Debug)]
pub struct Searched {
    /// Mechanisms, in the order in which they were found.
    pub found: Vec<Found>,
    /// The disc's pattern, if it lacks one.
    pub pattern: Option<Pattern>,
    /// All of them fitted together; columns of no finding come first.
    pub model: Model,
    /// How many those are.
    pub nuisances: usize,
    /// Strongest rhythm left, over what noise reaches.
    pub left: f64,
    /// Score of a pattern of the disc that is there for a while only; 0 where there is none.
    pub passing: f64,
}

/// Whether a pattern of the disc was learned from these recordings before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Learned {
    Never,
    /// It was, and is taken off.
    Off,
    /// It was, and is there again to be learned anew.
    There,
}

/// Searches; the noise of the board is set to what is found.
#[must_use]
pub fn search(board: &mut Board) -> Option<Searched> {
    let mut searched = once(board, Learned::Never)?;
    absorb(board, &mut searched);
    for _ in 1..ROUNDS {
        let explained = searched.explained(board);
        let before: Vec<f64> = board.benches.iter().map(|b| b.noise.stamp_s).collect();
        if !board.refit_noise(&explained) {
            break;
        }
        // The pattern that was taken off stays off, unless it was learned in noise that was thought far less than it is.
        let quieter = before.iter().zip(&board.benches);
        let grown = quieter
            .into_iter()
            .any(|(before, bench)| bench.noise.stamp_s > GROWN * before);
        let mut pattern = searched.pattern.take();
        let mut learned = match pattern {
            Some(_) => Learned::Off,
            None => Learned::Never,
        };
        if let Some(pattern) = pattern.take_if(|_| grown) {
            board.take_off(&pattern.errors_rad.iter().map(|e| -e).collect::<Vec<_>>());
            learned = Learned::There;
        }
        searched = once(board, learned)?;
        searched.pattern = merged(pattern, searched.pattern.take());
        absorb(board, &mut searched);
    }
    Some(searched)
}

/// What a search comes to that finds nothing.
#[must_use]
pub fn nothing_of(board: &Board) -> Option<Searched> {
    let nuisances: Vec<Column> = board.nuisances().into_iter().map(Column::kept).collect();
    Some(Searched {
        found: Vec::new(),
        pattern: None,
        nuisances: nuisances.len(),
        model: board.fit(nuisances)?,
        left: 0.0,
        passing: 0.0,
    })
}

/// Looks once, with the noise as it is.
fn once(board: &mut Board, learned: Learned) -> Option<Searched> {
    let off = learned == Learned::Off;
    let nuisances: Vec<Column> = board.nuisances().into_iter().map(Column::kept).collect();
    let mut found: Vec<Found> = Vec::new();
    let mut pattern: Option<Pattern> = None;
    let mut shelf = Shelf::default();
    let mut refused: Vec<Hypothesis> = Vec::new();
    let mut model = board.fit(nuisances.clone())?;
    let mut left = 0.0;
    let mut patterns = 0;
    let mut choices = 0;
    let mut terms = 0;
    let mut chosen = false;
    let mut passing = 0.0;
    // What is as good as one rhythm's is that rhythm's; a coarse disc has few orders, of which one may be most of its pattern.
    let edges = board.benches.first().map_or(0, |bench| bench.seen.edges) as f64;
    let over = 1.0 + (edges / FINE).min(1.0);
    while found.len() < MOST {
        if choices < CHOICES
            && let Some(other) = other_choice(board, &nuisances, &found, &mut shelf)
        {
            choices += 1;
            found = other;
            model = board.fit(columns(&nuisances, &found))?;
        }
        if terms < CHOICES
            && let Some(other) = other_terms(board, &nuisances, &found, &mut shelf)
        {
            terms += 1;
            found = other;
            model = board.fit(columns(&nuisances, &found))?;
        }
        let (mut proposed, strongest) = propose(board, &model);
        left = strongest;
        if off || pattern.is_some() {
            proposed = beside_disc(board, &model, &mut shelf, proposed);
        }
        proposed.retain(|one| !refused.contains(one));
        proposed.extend(loads(board, &model));
        let known = learned != Learned::Never || pattern.is_some();
        // A place is part of a pattern that was learned edge by edge.
        if !known {
            proposed.extend(defects(board, &model));
        }
        let ((best, pair), whole) = rayon::join(
            || {
                let best = best(board, &model, &mut shelf, proposed);
                let score = best.as_ref().map_or(0.0, |best| best.score);
                // What the disc's pattern is fitted beside needs no partner.
                let alone = pattern.is_some();
                let pair = (!alone).then(|| pair(board, &model, &mut shelf, score));
                (best, pair.flatten())
            },
            || (patterns < PATTERNS).then(|| whole_score(board, &model, known)),
        );
        if let Some(pair) = pair {
            found.extend(pair);
            model = board.fit(columns(&nuisances, &found))?;
            continue;
        }
        let score = best.as_ref().map_or(0.0, |best| best.score);
        let whole = whole.flatten();
        let over = if known { MORE } else { over };
        let whole = whole.filter(|whole| *whole > BEYOND.max(over * score));
        // Several named errors of the disc look like an error of every edge, and may look like one place.
        let place = best
            .as_ref()
            .filter(|one| one.score > BEYOND && one.hypothesis.mechanism == Mechanism::LocalDefect);
        if !known && (whole.is_some() || place.is_some()) {
            // What all edges of a class have is none of the disc's, and what is left of it would be taken for some.
            let parts = if !std::mem::replace(&mut chosen, true)
                && let Some(other) = choice_beside_disc(board, &nuisances, &found, &mut shelf)
            {
                found = other;
                true
            } else if let Some(parts) = disc_parts(board, &model, whole, place) {
                found.extend(parts);
                true
            } else {
                false
            };
            if parts {
                model = board.fit(columns(&nuisances, &found))?;
                continue;
            }
        }
        let whole = whole.and_then(|_| disc::pattern(board, &model, known));
        if let Some(whole) = whole {
            // Its orders that stood out are part of it: what the torques do along the way hangs on all of it.
            let before = found.len();
            found.retain(|one| one.hypothesis.mechanism != Mechanism::LineError);
            if found.len() < before {
                model = board.fit(columns(&nuisances, &found))?;
            }
            let whole = match disc::pattern(board, &model, true) {
                Some(all) if found.len() < before => all,
                _ => whole,
            };
            patterns += 1;
            if passes(board, &model, &whole) {
                passing = whole.score;
                patterns = PATTERNS;
                continue;
            }
            let before = squares(&model);
            board.take_off(&whole.errors_rad);
            model = board.fit(columns(&nuisances, &found))?;
            if before - squares(&model) > 0.3 * whole.score {
                pattern = merged(pattern, Some(whole));
            } else {
                // The disc does not show evenly enough to be learned like this.
                let back: Vec<f64> = whole.errors_rad.iter().map(|error| -error).collect();
                board.take_off(&back);
                model = board.fit(columns(&nuisances, &found))?;
                patterns = PATTERNS;
            }
            continue;
        }
        let Some(best) = best.filter(|best| best.score > beyond(&best.hypothesis)) else {
            break;
        };
        if let Some(moved) = anew(board, &nuisances, &found, &best) {
            found = moved;
            model = board.fit(columns(&nuisances, &found))?;
            continue;
        }
        // What came and went may have been this, unless this is a part of it.
        if passing > 0.0 && best.hypothesis.mechanism != Mechanism::LineError {
            (passing, patterns) = (0.0, 0);
        }
        found.push(best);
        let Some(fitted) = board.fit(columns(&nuisances, &found)) else {
            found.pop();
            break;
        };
        model = fitted;
        if let Some(number) = no_disc(&found, &model, nuisances.len()) {
            refused.push(found.remove(number).hypothesis);
            model = board.fit(columns(&nuisances, &found))?;
        }
        // What can only be told by many rhythms side by side is none of them.
        if crowd(board, &found).len() >= 3 {
            break;
        }
    }
    Some(Searched {
        found,
        pattern,
        model,
        nuisances: nuisances.len(),
        left,
        passing,
    })
}

/// Score of a whole pattern of the disc. Once one was learned the rest of it is no longer white: what is left of a few orders counts too.
fn whole_score(board: &Board, model: &Model, known: bool) -> Option<f64> {
    if known {
        disc::score_of_orders(board, model)
    } else {
        disc::score(board, model, false)
    }
}

/// What a finding must explain beyond its cost.
fn beyond(hypothesis: &Hypothesis) -> f64 {
    match hypothesis.bases.as_slice() {
        [Basis::Direction] => AT_ONCE,
        _ => BEYOND,
    }
}

pub(super) fn columns(nuisances: &[Column], found: &[Found]) -> Vec<Column> {
    let own = found.iter().flat_map(|f| f.columns.iter());
    nuisances.iter().chain(own).cloned().collect()
}
