//! What was concluded, put into the twins, simulated, and fitted once more: the numbers are those of the simulation.

use super::board::{Board, Column, Model};
use super::conclude::Conclusion;
use super::diagnosis::Fit;
use super::estimate::{Estimate, estimates};
use super::faded::{faded, squares_of};
use super::follow::together;
use super::instants::sharpened;
use super::joined::join;
use super::judge::{self, HeldRatios, Judged};
use super::marks::{Mark, marks};
use super::mended;
use super::prepare;
use super::refuted;
use super::repeats::{self, Repeats};
use super::rests::{far, rests};
use super::run::{DiagnoseError, Recorded};
use super::search::{Found, Searched};
use super::shortened::{common, cut, fit_again, longer};
use crate::twin::Twin;

/// Times that recordings are cut to where mended twins go as well.
const CUTS: usize = 3;

/// A conclusion with its numbers.
#[derive(Debug)]
pub struct Settled {
    /// The recordings against the twins as they were given, in the noise that was found.
    pub given: Board,
    /// What the twins as given leave.
    pub before: Model,
    /// What the mended twins leave.
    pub after: Model,
    /// What was concluded.
    pub concluded: Conclusion,
    /// Marks of the named findings, in their order.
    pub marks: Vec<Mark>,
    /// Numbers of the named findings, in their order.
    pub estimates: Vec<Estimate>,
    /// The disc's pattern.
    pub pattern: Option<super::disc::Pattern>,
    /// The twins with the findings in them.
    pub twins: Vec<Twin>,
    /// The whole of e where the disc was learned edge by edge.
    pub error_lists: Vec<Option<Vec<f64>>>,
    /// How well it fits.
    pub fit: Fit,
    /// How much of what has no name comes again each turn.
    pub repeats: Option<Repeats>,
    /// Each finding's part in it on the turns held out.
    pub held: HeldRatios,
    /// Named findings that the mended twin leaves nothing of, by their places among them: what others make beyond a linear model.
    pub faded: Vec<usize>,
    /// First edges that the mended twins have, where these are fewer.
    shorter: Option<Vec<usize>>,
    class_names: &'static [&'static str],
}

/// Settles; what fades is left out.
///
/// # Errors
/// [`DiagnoseError`] where a mended twin can't be run.
pub fn settle(
    rig: &[Recorded],
    given: &Board,
    board: Board,
    searched: Searched,
    concluded: Conclusion,
) -> Result<Settled, DiagnoseError> {
    let (mut given, mut board, mut searched) = (given.clone(), board, searched);
    let mut concluded = concluded;
    let mut cuts = 0;
    loop {
        let settled = once(
            rig,
            &given,
            board.clone(),
            searched.clone(),
            concluded.clone(),
        )?;
        if let Some(edges) = settled.shorter.as_ref().filter(|_| cuts < CUTS) {
            cuts += 1;
            cut(&mut given, edges);
            cut(&mut board, edges);
            if fit_again(&board, &mut searched).is_none() {
                return Ok(settled);
            }
            continue;
        }
        if settled.faded.is_empty() {
            let Some(others) = refuted::without(&settled) else {
                return Ok(settled);
            };
            concluded = others;
            continue;
        }
        let mut number = 0;
        concluded.named.retain(|_| {
            number += 1;
            !settled.faded.contains(&(number - 1))
        });
    }
}

/// Settles once.
///
/// # Errors
/// [`DiagnoseError`] where a mended twin can't be run.
fn once(
    rig: &[Recorded],
    given: &Board,
    mut board: Board,
    mut searched: Searched,
    concluded: Conclusion,
) -> Result<Settled, DiagnoseError> {
    if let Some(pattern) = searched.pattern.take_if(|_| !concluded.pattern) {
        let back: Vec<f64> = pattern.errors_rad.iter().map(|error| -error).collect();
        board.take_off(&back);
    }
    let mut given = given.clone();
    for (bench, found) in given.benches.iter_mut().zip(&board.benches) {
        bench.set_noise(found.noise);
    }
    let before = given
        .fit(given.nuisances())
        .unwrap_or_else(|| Model::none(&given));
    let mut joint = chosen(&board, &searched, &concluded);
    join(&mut board, &mut joint);
    together(&board, &mut joint);
    let (chosen, between) = sharpened(&board, joint);
    let mut numbers = estimates(&board, &chosen);
    for (number, between) in numbers.iter_mut().zip(between) {
        number.between = between;
    }
    let marks = marks(&board, &chosen);
    let before_mending: Vec<f64> = numbers.iter().map(squares_of).collect();
    let pattern = chosen.pattern.as_ref();
    let mended = |numbers: &[Estimate]| mended::twins(rig, &given, pattern, numbers);
    // Against the mended twins only small rests are left of the sizes.
    let mut again = board;
    let mut shorter = None;
    if !numbers.is_empty() {
        for _ in 0..2 {
            let rig = mended::with_twins(rig, &mended(&numbers).0);
            let Ok(mut next) = prepare::board(&rig) else {
                break;
            };
            // Edges are compared one by one, so the mended twin has to go wherever the given one goes.
            let Some(both) = common(&again, &next) else {
                break;
            };
            cut(&mut next, &both);
            if longer(&again, &both) {
                shorter = Some(both);
                break;
            }
            for (bench, found) in next.benches.iter_mut().zip(&again.benches) {
                bench.set_noise(found.noise);
            }
            let Some(rests) = rests(&next, &chosen, &numbers) else {
                break;
            };
            let moved = far(&numbers, &rests);
            for (number, rest) in numbers.iter_mut().zip(rests) {
                rest.add_to(&next, number);
            }
            again = next;
            if moved < 0.3 {
                break;
            }
        }
    }
    let faded = faded(&numbers, &before_mending, given.edges());
    let (twins, error_lists) = mended(&numbers);
    let after = again
        .fit(again.nuisances())
        .unwrap_or_else(|| Model::none(&again));
    let repeats = concluded.nameless.as_ref();
    let repeats = repeats.and_then(|_| repeats::repeats(&again, &after.left));
    let judged = Judged {
        given: &given,
        before: &before,
        again: &again,
        after: &after,
        chosen: &chosen,
        nameless: &nameless(&searched, &concluded),
    };
    let (fit, held) = judge::fit(&judged);
    let class_names = rig
        .first()
        .map_or(&[][..], |one| one.plan.kind.class_names());
    Ok(Settled {
        given,
        before,
        after,
        pattern: chosen.pattern.clone(),
        concluded,
        estimates: numbers,
        marks,
        twins,
        error_lists,
        fit,
        repeats,
        held,
        faded,
        shorter,
        class_names,
    })
}

/// Columns of what was found and has no name.
fn nameless(searched: &Searched, concluded: &Conclusion) -> Vec<Column> {
    if concluded.nameless.is_none() {
        return Vec::new();
    }
    let named = |number: &usize| concluded.named.iter().any(|name| name.number == *number);
    let found = searched.found.iter().enumerate();
    let odd = found.filter(|(number, _)| !named(number));
    odd.flat_map(|(_, found)| found.columns.clone()).collect()
}

impl Settled {
    /// Names of the edge classes.
    #[must_use]
    pub const fn class_names(&self) -> &'static [&'static str] {
        self.class_names
    }
}

/// The search with what was concluded in place of what was found.
fn chosen(board: &Board, searched: &Searched, concluded: &Conclusion) -> Searched {
    let nuisances: Vec<Column> = searched.model.columns[..searched.nuisances].to_vec();
    let found: Vec<Found> = concluded
        .named
        .iter()
        .map(|name| {
            let old = &searched.found[name.number];
            let columns = if old.hypothesis == name.hypothesis {
                old.columns.clone()
            } else {
                name.hypothesis.columns(board)
            };
            Found {
                hypothesis: name.hypothesis.clone(),
                columns,
                score: name.score,
                rivals: Vec::new(),
            }
        })
        .collect();
    let own = found.iter().flat_map(|f| f.columns.iter());
    let all: Vec<Column> = nuisances.iter().chain(own).cloned().collect();
    match board.fit(all) {
        Some(model) => Searched {
            found,
            model,
            ..searched.clone()
        },
        None => searched.clone(),
    }
}
