//! From what a search found to what is named: what is a mechanism, what only resembles one, and what is one or another.

use rayon::prelude::*;

use super::basis::Basis;
use super::board::Board;
use super::crowd::{Family, family, kin};
use super::disc::{Pattern, comes_again, put_back};
use super::hypothesis::Hypothesis;
use super::leftover::{Leftover, leftovers};
use super::named::no_rigs;
use super::rivals::{ALIKE, rivals, same_mark};
use super::search::{BEYOND, Found, Searched};
use super::steady::steadiness;
use crate::mechanism::Mechanism;

pub use super::crowd::{crowd, cycles_a_turn};

/// A finding with a name.
#[derive(Clone, Debug)]
pub struct Name {
    /// Its place in the search's list.
    pub number: usize,
    /// What it is.
    pub hypothesis: Hypothesis,
    /// What it explains beyond its cost.
    pub score: f64,
    /// The next best mechanism, and how much worse it is.
    pub runner_up: Option<(Mechanism, f64)>,
    /// Mechanisms as likely as not.
    pub alike: Vec<Mechanism>,
    /// How those that leave a mark of their own would do it.
    pub look_alikes: Vec<Hypothesis>,
    /// Probability among those weighed.
    pub confidence: f64,
}

/// Something that has no name.
#[derive(Clone, Debug)]
pub struct Nameless {
    /// Where it is, in words.
    pub text: String,
    /// Sum of squares that it makes.
    pub squares: f64,
    /// Probability that noise makes as much.
    pub p_value: f64,
    /// Orders that bound it.
    pub orders: Vec<f64>,
    /// Frequencies that bound it, Hz.
    pub frequencies_hz: Vec<f64>,
}

/// What is concluded.
#[derive(Clone, Debug, Default)]
pub struct Conclusion {
    /// Findings with a name, strongest first.
    pub named: Vec<Name>,
    /// What has none.
    pub nameless: Option<Nameless>,
    /// Whether the disc's pattern is a finding.
    pub pattern: bool,
    /// Probability that what is left is noise.
    pub whiteness_p: f64,
}

/// Concludes.
#[must_use]
pub fn conclude(board: &Board, searched: &Searched) -> Conclusion {
    let odd = odd(board, searched);
    let odd_score: f64 = odd.iter().map(|number| searched.found[*number].score).sum();
    let (left, whiteness_p) = leftovers(board, &searched.model);
    let left = worst(&left, searched);
    let mut conclusion = Conclusion {
        pattern: searched.pattern.is_some(),
        whiteness_p,
        ..Conclusion::default()
    };
    // Beside something that has no name, small findings of the same kind of edges are parts of it.
    let changing = searched
        .pattern
        .as_ref()
        .filter(|p| changes(board, searched, p));
    conclusion.pattern = searched.pattern.is_some() && changing.is_none();
    let changing = changing.map_or(0.0, |pattern| pattern.score) + searched.passing;
    let unknown_squares = odd_score + left.map_or(0.0, |left| left.squares) + changing;
    let part = |score: f64, of: Family| {
        let mut odd = odd.iter().map(|number| family(&searched.found[*number]));
        score < 0.3 * unknown_squares
            && (odd.any(|odd| odd == of) || left.is_some_and(|left| kin(left.among) == of))
    };
    let found = searched.found.iter().enumerate();
    let named: Vec<usize> = found
        .filter(|(number, found)| !odd.contains(number) && !part(found.score, family(found)))
        .map(|(number, _)| number)
        .collect();
    conclusion.named = named
        .into_par_iter()
        .map(|number| name(board, searched, number))
        .collect();
    if let Some(pattern) = &searched.pattern {
        conclusion.pattern &= !part(pattern.score, Family::Alike);
    }
    conclusion.named.sort_by(|a, b| b.score.total_cmp(&a.score));
    // What the others explain as well, now that all are known, is nothing.
    conclusion.named.pop_if(|last| last.score < 0.0);
    conclusion.nameless = nameless(board, searched, &odd, left).or_else(|| {
        (changing > 0.0).then(|| Nameless {
            text: "places of the disc, all edges alike; like line_error, but not the same in \
                   the first half as in the second"
                .to_owned(),
            squares: changing,
            p_value: (-0.5 * changing).exp(),
            orders: Vec::new(),
            frequencies_hz: Vec::new(),
        })
    });
    conclusion
}

/// Whether a pattern of the disc learned in one half is not that of the other.
fn changes(board: &Board, searched: &Searched, pattern: &Pattern) -> bool {
    const PART: f64 = 0.35;
    const SURE: f64 = 4.0;
    let there = put_back(board, &searched.model, pattern);
    let shares = comes_again(board, &there, pattern.white_rad);
    shares
        .iter()
        .any(|(share, error)| (share - 1.0).abs() > PART + SURE * error)
}

/// What is left and matters beside what was found.
fn worst<'a>(left: &'a [Leftover], searched: &Searched) -> Option<&'a Leftover> {
    left.iter().find(|one| {
        let family_score: f64 = searched
            .found
            .iter()
            .filter(|found| family(found) == kin(one.among))
            .map(|found| found.score)
            .sum();
        let pattern = searched.pattern.as_ref().map_or(0.0, |p| p.score);
        one.squares > BEYOND + 0.02 * (family_score + pattern)
    })
}

/// Findings that only resemble a mechanism: not the same from beginning to end, or one of a crowd.
fn odd(board: &Board, searched: &Searched) -> Vec<usize> {
    let mut odd: Vec<usize> = searched
        .found
        .iter()
        .enumerate()
        .filter(|(_, found)| {
            steadiness(board, &searched.model, &found.columns).changes(found.score)
        })
        .map(|(number, _)| number)
        .collect();
    odd.extend(crowd(board, &searched.found));
    odd.extend((0..searched.found.len()).filter(|number| no_rigs(searched, *number).is_some()));
    let drifts = |found: &Found| {
        matches!(
            found.hypothesis.bases.first(),
            Some(
                Basis::LevelDrift { .. }
                    | Basis::Drift
                    | Basis::Warming { .. }
                    | Basis::Load { .. }
            )
        )
    };
    for family_of in [Family::Level, Family::Alike] {
        let slow: Vec<usize> = (0..searched.found.len())
            .filter(|i| drifts(&searched.found[*i]) && family(&searched.found[*i]) == family_of)
            .collect();
        if slow.len() >= 3 {
            odd.extend(slow);
        }
    }
    odd.sort_unstable();
    odd.dedup();
    odd
}

fn name(board: &Board, searched: &Searched, number: usize) -> Name {
    let (own, rivals) = rivals(board, searched, number);
    let found = &searched.found[number];
    let mut hypothesis = found.hypothesis.clone();
    let mut score = own;
    let mut others: Vec<(Hypothesis, f64)> = rivals;
    // Another may fit better now that all the rest is known.
    if let Some(best) = others.first().cloned()
        && best.1 > own + ALIKE
        && best.0.bases.len() == hypothesis.bases.len()
        && !matches!(best.0.bases.first(), Some(Basis::Lagged { .. }) if best.0.whole())
    {
        others[0] = (hypothesis, own);
        (hypothesis, score) = best;
    }
    let other = |one: &&(Hypothesis, f64)| one.0.mechanism != hypothesis.mechanism;
    let runner_up = others
        .iter()
        .find(other)
        .map(|one| (one.0.mechanism, score - one.1));
    let mut alike: Vec<Mechanism> = others
        .iter()
        .filter(other)
        .filter(|one| score - one.1 < ALIKE)
        .map(|one| one.0.mechanism)
        .collect();
    let mut look_alikes: Vec<Hypothesis> = Vec::new();
    for (one, worse) in others.iter().filter(other) {
        if score - worse < ALIKE && !look_alikes.iter().any(|l| l.mechanism == one.mechanism) {
            look_alikes.push(one.clone());
        }
    }
    alike.sort_unstable();
    alike.dedup();
    let same = same_mark(&hypothesis);
    alike.extend(same);
    let weights: f64 = others
        .iter()
        .filter(other)
        .map(|one| (0.5 * (one.1 - score)).exp())
        .sum::<f64>()
        + same.len() as f64;
    Name {
        number,
        hypothesis,
        score,
        runner_up,
        alike,
        look_alikes,
        confidence: 1.0 / (1.0 + weights),
    }
}

fn nameless(
    board: &Board,
    searched: &Searched,
    odd: &[usize],
    left: Option<&Leftover>,
) -> Option<Nameless> {
    if let Some(strongest) = odd.iter().max_by(|a, b| {
        searched.found[**a]
            .score
            .total_cmp(&searched.found[**b].score)
    }) {
        let turning =
            board.benches.first().map_or(1.0, |b| b.seen.mean_speed()) / std::f64::consts::TAU;
        let mut orders: Vec<f64> = Vec::new();
        for number in odd {
            let hypothesis = &searched.found[*number].hypothesis;
            orders.extend(cycles_a_turn(board, hypothesis));
        }
        orders.sort_by(f64::total_cmp);
        let bounds: Vec<f64> = match (orders.first(), orders.last()) {
            (Some(low), Some(high)) if high > low => vec![*low, *high],
            (Some(low), _) => vec![*low],
            _ => Vec::new(),
        };
        let resembles = searched.found[*strongest].hypothesis.mechanism;
        let score: f64 = odd.iter().map(|number| searched.found[*number].score).sum();
        let edges = match family(&searched.found[*strongest]) {
            Family::Level => "rising against falling edges",
            Family::Channel => "channel against channel",
            _ => "all edges alike",
        };
        let text = match (no_rigs(searched, *strongest), bounds.as_slice()) {
            (Some((quantity, value)), _) => format!(
                "{edges}; like {resembles}, but no rig has its {} of {value:.3e} {}",
                quantity.name, quantity.unit
            ),
            (None, []) => format!("{edges}; like {resembles}, but not the same throughout"),
            (None, [one]) => format!(
                "{edges}, around order {one:.2}; like {resembles}, but not the same throughout"
            ),
            (None, [low, high, ..]) => format!(
                "{edges}, orders {low:.2} to {high:.2}: a rhythm that is none of turn or time"
            ),
        };
        return Some(Nameless {
            text,
            squares: score + left.map_or(0.0, |left| left.squares),
            p_value: 0.0,
            frequencies_hz: bounds.iter().map(|order| order * turning).collect(),
            orders: bounds,
        });
    }
    left.map(|left| Nameless {
        text: left.text.clone(),
        squares: left.squares,
        p_value: left.p_value,
        orders: left.orders.clone(),
        frequencies_hz: left.frequencies_hz.clone(),
    })
}
