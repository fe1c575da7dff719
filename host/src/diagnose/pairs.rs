//! Two mechanisms that only show together.
//!
//! A disc learned while its edges came late has the delays of that speed in its widths. Against such a twin neither the delay nor
//! the widths alone explain much, as each needs the other to cancel at that speed; both side by side explain all of it.

use super::basis::{Basis, channels};
use super::board::{Board, Model};
use super::hypothesis::Hypothesis;
use super::search::{BEYOND, Found};
use super::weigh::{Shelf, weigh};

/// Share of what a pair explains that goes with either of the two; where one does nearly all of it, they are no pair.
const NEEDED: f64 = 0.3;

/// The pair that explains most on top of a model, if it beats a score and each of the two is needed beside the other.
#[must_use]
pub fn pair(board: &Board, model: &Model, shelf: &mut Shelf, beats: f64) -> Option<[Found; 2]> {
    let classes = board.benches.first()?.seen.classes;
    let mut best: Option<(f64, [Found; 2])> = None;
    for [delay, disc] in pairs(classes) {
        let both = Hypothesis {
            mechanism: delay.mechanism,
            bases: delay.bases.iter().chain(&disc.bases).copied().collect(),
        };
        let columns = shelf.columns(board, &both);
        let count = columns.len();
        let least = best.as_ref().map_or(beats.max(2.0 * BEYOND), |best| best.0);
        let Some(score) = weigh(board, model, both, columns)
            .filter(|both| both.columns.len() == count && both.score > least)
            .map(|both| both.score)
        else {
            continue;
        };
        let beside = |one: &Hypothesis, other: &Hypothesis, shelf: &mut Shelf| {
            let rest = model.columns.iter().cloned();
            let rest = rest.chain(shelf.columns(board, other)).collect();
            let columns = shelf.columns(board, one);
            let weighed = weigh(board, &board.fit(rest)?, one.clone(), columns)?;
            (weighed.score > BEYOND.max(NEEDED * score)).then(|| Found::from(weighed))
        };
        let first = beside(&delay, &disc, shelf);
        let second = beside(&disc, &delay, shelf);
        if let (Some(first), Some(second)) = (first, second) {
            best = Some((score, [first, second]));
        }
    }
    best.map(|(_, pair)| pair)
}

/// A delay and the errors of the disc that it makes at one speed.
fn pairs(classes: i64) -> Vec<[Hypothesis; 2]> {
    if classes < 2 {
        return Vec::new();
    }
    let channels = channels(classes);
    let of = |delays: Vec<Basis>, discs: Vec<Basis>| {
        Some([Hypothesis::by_all(delays)?, Hypothesis::by_all(discs)?])
    };
    let each = |basis: &dyn Fn(usize) -> Basis, from: usize| (from..channels).map(basis).collect();
    let mut all = vec![of(
        vec![Basis::RiseLate { channel: None }],
        vec![Basis::Width { channel: None }],
    )];
    if channels > 1 {
        all.push(of(
            each(&|c| Basis::RiseLate { channel: Some(c) }, 0),
            each(&|c| Basis::Width { channel: Some(c) }, 0),
        ));
        all.push(of(
            each(&|channel| Basis::Late { channel }, 1),
            each(&|channel| Basis::Shift { channel }, 1),
        ));
    }
    all.into_iter().flatten().collect()
}
