//! Which errors all edges of a class have, decided all at once.
//!
//! Widths and the quadrature are angles, delays and the skew are times, and one speed turns the ones into the others: found one after
//! another, the first takes what belongs to two of the others, and those then mend what it made of it. Their kinds are few, so every
//! choice of them is weighed beside what else was found.

use super::basis::Basis;
use super::board::{Board, Column, Model};
use super::disc;
use super::hypothesis::Hypothesis;
use super::least_squares::squares;
use super::rivals::ALIKE;
use super::search::{BEYOND, Found, columns};
use super::weigh::{Shelf, weigh};
use crate::mechanism::Mechanism;

/// What all edges of a class have.
pub const KINDS: [Mechanism; 4] = [
    Mechanism::WidthError,
    Mechanism::QuadratureError,
    Mechanism::EdgeDelay,
    Mechanism::ChannelSkew,
];

/// Findings of them that may be a mixture of others.
const MIXED: usize = 2;
/// Times that a pattern of the disc is taken off beside a choice.
const PATTERNS: usize = 3;
/// Part of what was left that a further pattern has to leave at the most to be worth another.
const SETTLED: f64 = 0.9;

/// The findings with another choice of such errors in place of theirs, where that explains more; none where theirs is as good, or where
/// they have fewer than [`MIXED`].
#[must_use]
pub fn other_choice(
    board: &Board,
    nuisances: &[Column],
    found: &[Found],
    shelf: &mut Shelf,
) -> Option<Vec<Found>> {
    let choices = Choices::of(board, nuisances, found, shelf)?;
    if choices.present.len() < MIXED && !choices.rhythms && !choices.together {
        return None;
    }
    let best = choices.best(board, shelf);
    let best = best.or_else(|| choices.together.then(|| choices.present.clone()))?;
    choices.taken(board, shelf, &best)
}

/// The same before the disc's pattern is learned, which is to be none of them: of those that explain as much, the one with which a
/// pattern leaves least, as one that is learned beside the wrong choice takes up what that lacks.
#[must_use]
pub fn choice_beside_disc(
    board: &Board,
    nuisances: &[Column],
    found: &[Found],
    shelf: &mut Shelf,
) -> Option<Vec<Found>> {
    let choices = Choices::of(board, nuisances, found, shelf)?;
    let near = choices.near(board, shelf)?;
    let mut best: (f64, &[Hypothesis]) = (f64::INFINITY, near.first()?);
    if near.len() > 1 {
        for choice in &near {
            let columns = choices.columns(board, shelf, choice);
            let left = left_beside_disc(board, columns)? + BEYOND * choice.len() as f64;
            if left < best.0 {
                best = (left, choice);
            }
        }
    }
    if choices.is_present(best.1) && !choices.together {
        return None;
    }
    choices.taken(board, shelf, best.1)
}

/// What is left beside columns and a pattern of the disc.
fn left_beside_disc(board: &Board, columns: Vec<Column>) -> Option<f64> {
    let mut there = board.clone();
    let mut model = there.fit(columns.clone())?;
    let mut left = squares(&model);
    for _ in 0..PATTERNS {
        let Some(pattern) = disc::pattern(&there, &model, true) else {
            break;
        };
        there.take_off(&pattern.errors_rad);
        model = there.fit(columns.clone())?;
        let before = std::mem::replace(&mut left, squares(&model));
        if left > SETTLED * before {
            break;
        }
    }
    Some(left)
}

/// What may be chosen beside the findings that are none of it.
struct Choices {
    others: Vec<Found>,
    beside: Model,
    present: Vec<Hypothesis>,
    /// Whether rhythms that come once a line are among what may be chosen.
    rhythms: bool,
    /// Whether several that are present were found as one: what could be of the disc beside what is not.
    together: bool,
    all: Vec<Vec<Hypothesis>>,
    variance: f64,
}

impl Choices {
    fn of(board: &Board, nuisances: &[Column], found: &[Found], shelf: &mut Shelf) -> Option<Self> {
        let mut ways = KINDS
            .map(|kind| (kind.card().handling.proposed)(board))
            .to_vec();
        // A rhythm that comes once a line is all edges of a class too.
        let rhythms = found
            .iter()
            .filter(|one| once_a_line(board, &one.hypothesis));
        ways.extend(rhythms.map(|one| vec![one.hypothesis.clone()]));
        let own = |one: &Found| {
            let parts = parts(&one.hypothesis);
            parts
                .iter()
                .all(|part| ways.iter().flatten().any(|way| way == part))
        };
        let (here, others): (Vec<Found>, Vec<Found>) = found.iter().cloned().partition(own);
        let beside = board.fit(columns(nuisances, &others))?;
        let all = choices(&ways);
        let mut present: Vec<Hypothesis> = Vec::new();
        for part in here.iter().flat_map(|one| parts(&one.hypothesis)) {
            if !present.contains(&part) {
                present.push(part);
            }
        }
        Some(Self {
            variance: variance(board, &beside, &all, shelf)?,
            rhythms: ways.len() > KINDS.len(),
            together: here.iter().any(|one| parts(&one.hypothesis).len() > 1),
            present,
            others,
            beside,
            all,
        })
    }

    fn worth(&self, board: &Board, shelf: &mut Shelf, choice: &[Hypothesis]) -> Option<f64> {
        worth(board, &self.beside, choice, self.variance, shelf)
    }

    /// The best, where it is better than the present one.
    fn best(&self, board: &Board, shelf: &mut Shelf) -> Option<Vec<Hypothesis>> {
        let mut best = (self.worth(board, shelf, &self.present)? + ALIKE, None);
        for choice in &self.all {
            match self.worth(board, shelf, choice) {
                Some(worth) if worth > best.0 => best = (worth, Some(choice)),
                _ => {}
            }
        }
        best.1.cloned()
    }

    /// Those that explain as much as the best, the present one first.
    fn near(&self, board: &Board, shelf: &mut Shelf) -> Option<Vec<Vec<Hypothesis>>> {
        let mut each = vec![(self.worth(board, shelf, &self.present)?, &self.present)];
        let others = self.all.iter().filter(|choice| !self.is_present(choice));
        for choice in others {
            let worth = self.worth(board, shelf, choice);
            each.extend(worth.map(|worth| (worth, choice)));
        }
        let most = each
            .iter()
            .map(|one| one.0)
            .fold(f64::NEG_INFINITY, f64::max);
        let near = each.into_iter().filter(|one| one.0 > most - ALIKE);
        Some(near.map(|one| one.1.clone()).collect())
    }

    fn is_present(&self, choice: &[Hypothesis]) -> bool {
        choice.len() == self.present.len() && choice.iter().all(|one| self.present.contains(one))
    }

    fn columns(&self, board: &Board, shelf: &mut Shelf, choice: &[Hypothesis]) -> Vec<Column> {
        let own = choice.iter().flat_map(|one| shelf.columns(board, one));
        self.beside.columns.iter().cloned().chain(own).collect()
    }

    /// The findings with a choice.
    fn taken(&self, board: &Board, shelf: &mut Shelf, choice: &[Hypothesis]) -> Option<Vec<Found>> {
        let mut found = self.others.clone();
        for one in choice {
            let rest: Vec<Hypothesis> = choice
                .iter()
                .filter(|other| *other != one)
                .cloned()
                .collect();
            let without = board.fit(self.columns(board, shelf, &rest))?;
            let own = shelf.columns(board, one);
            found.push(weigh(board, &without, one.clone(), own)?.into());
        }
        Some(found)
    }
}

/// The mechanisms that a hypothesis is of, each by itself.
fn parts(hypothesis: &Hypothesis) -> Vec<Hypothesis> {
    let mut each: Vec<Hypothesis> = Vec::new();
    let first = hypothesis.bases.first().map(|basis| basis.mechanism());
    for basis in &hypothesis.bases {
        // What is told by the first of its patterns has the name that it was given.
        let mechanism = match basis.mechanism() {
            own if Some(own) == first => hypothesis.mechanism,
            other => other,
        };
        match each.iter_mut().find(|one| one.mechanism == mechanism) {
            Some(one) => one.bases.push(*basis),
            None => each.push(Hypothesis::of(mechanism, *basis)),
        }
    }
    each
}

/// Whether it comes once a line, or several times, in any of the recordings.
fn once_a_line(board: &Board, hypothesis: &Hypothesis) -> bool {
    let tone = match hypothesis.bases.first() {
        Some(Basis::TorqueTone { f_hz } | Basis::LevelTone { f_hz, .. }) => Some(*f_hz),
        _ => None,
    };
    board.benches.iter().any(|bench| {
        let seen = &bench.seen;
        let lines = (seen.edges / seen.classes.max(1)) as f64;
        // How far apart two orders are that a recording tells apart.
        let apart = 1.0 / seen.turns();
        match (tone, hypothesis.rhythm().filter(|_| hypothesis.whole())) {
            (Some(f_hz), _) => {
                let order = f_hz * seen.seconds() / seen.turns();
                let times = (order / lines).round();
                times >= 1.0 && (order - times * lines).abs() < apart
            }
            (None, Some(order)) => order > 0.0 && order % lines == 0.0,
            (None, None) => false,
        }
    })
}

/// Variance of what no choice explains: where that is a disc that is not known yet it comes again each turn, and says as much once only.
fn variance(
    board: &Board,
    beside: &Model,
    all: &[Vec<Hypothesis>],
    shelf: &mut Shelf,
) -> Option<f64> {
    let gains = all.iter().filter_map(|choice| {
        let columns: Vec<Column> = choice
            .iter()
            .flat_map(|one| shelf.columns(board, one))
            .collect();
        board.gain(beside, &columns)
    });
    let most = gains.map(|gain| gain.squares).fold(0.0, f64::max);
    let edges = board.edges() as f64;
    let turns = edges / board.benches.first()?.seen.edges as f64;
    let left = (squares(beside) - most) / edges;
    Some(((left - 1.0) * turns).max(1.0))
}

/// What a choice explains beyond what it takes to be found; none where some of it can't be told from the rest.
fn worth(
    board: &Board,
    beside: &Model,
    choice: &[Hypothesis],
    variance: f64,
    shelf: &mut Shelf,
) -> Option<f64> {
    let columns: Vec<Column> = choice
        .iter()
        .flat_map(|one| shelf.columns(board, one))
        .collect();
    let cost = columns.len() as f64 * (board.edges() as f64).ln();
    let gain = board.gain(beside, &columns)?;
    Some(gain.squares / variance - cost - BEYOND * choice.len() as f64)
}

/// Every choice of one or no way of each kind, but the empty one.
fn choices(ways: &[Vec<Hypothesis>]) -> Vec<Vec<Hypothesis>> {
    let mut all: Vec<Vec<Hypothesis>> = vec![Vec::new()];
    for of_kind in ways {
        let more: Vec<Vec<Hypothesis>> = all
            .iter()
            .flat_map(|choice| {
                let with =
                    |way: &Hypothesis| [choice.as_slice(), std::slice::from_ref(way)].concat();
                of_kind.iter().map(with)
            })
            .collect();
        all.extend(more);
    }
    all.remove(0);
    all
}
