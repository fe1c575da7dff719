//! How well recordings agree with a speed loop that their twins lack, or a task that holds captures up: against the twins as they were
//! given, and on the last turns of each, with loop or task as the turns before show it.

use super::closed_loop;
use crate::diagnose::board::{Board, FITTED, Model, PARTS};
use crate::diagnose::diagnosis::Band;
use crate::diagnose::judge::squares;
use crate::diagnose::leftover::leftovers;
use crate::diagnose::mended::with_twins;
use crate::diagnose::noise::{NoiseFinding, refit};
use crate::diagnose::prepare;
use crate::diagnose::run::Recorded;
use crate::diagnose::settle::Settled;
use crate::diagnose::spread::{floor, spread};
use crate::mechanism::Mechanism;

/// Sum of squares that the loop must explain on the last turns to be judged there.
const SHOWS: f64 = 30.0;

/// Recordings without the loop or the task, and with the one that their earlier turns show.
#[derive(Debug)]
pub struct Foretold {
    mechanism: Mechanism,
    open: Board,
    early: Option<Board>,
}

/// The twins as given, compared with what the recordings show, in the noise that was found.
#[derive(Debug)]
pub struct Open {
    /// What the twins lack.
    pub mechanism: Mechanism,
    /// The recordings against the twins without it.
    pub board: Board,
    /// What they leave.
    pub model: Model,
    /// RMS on held-out turns with it over that without it.
    pub held_out_ratio: Option<f64>,
}

impl Foretold {
    /// From recordings with the twins as they were given, and these compared.
    #[must_use]
    pub fn of(rig: &[Recorded], open: Board) -> Self {
        Self {
            mechanism: Mechanism::ClosedLoop,
            early: early(rig),
            open,
        }
    }

    /// From recordings with a task's delays in them, these compared with their twins, and the task.
    #[must_use]
    pub fn of_task(rig: &[Recorded], open: Board, task: &NoiseFinding) -> Self {
        Self {
            mechanism: Mechanism::CaptureLatency,
            early: early_task(rig, task),
            open,
        }
    }

    /// Puts its part into the fit of what was settled with loop or task accounted for.
    #[must_use]
    pub fn put_in(self, settled: &mut Settled) -> Option<Open> {
        let Self {
            mechanism,
            mut open,
            early,
        } = self;
        let count = settled.given.benches.len();
        for (bench, found) in open.benches.iter_mut().zip(&settled.given.benches) {
            bench.set_noise(found.noise);
        }
        let late = FITTED..PARTS;
        let model = open.fit(open.nuisances())?;
        let (was, was_late) = (
            spread(&open, &model.left, 0..PARTS),
            spread(&open, &model.left, late.clone()),
        );
        let fit = &mut settled.fit;
        fit.rms_before_rad = Some(was.fast_rad());
        fit.slow = Band {
            rms_before_rad: Some(was.slow_rad()),
            ..fit.slow
        };
        fit.edge_to_edge = Band {
            rms_before_rad: Some(was.steps_rad()),
            ..fit.edge_to_edge
        };
        fit.whiteness_p_before = Some(leftovers(&open, &model).1);
        fit.held_out.rms_before_rad = Some(was_late.fast_rad());
        let early = early.filter(|early| early.benches.len() == count);
        // What else was found was judged beside the loop as all turns show it.
        let alone = settled.estimates.is_empty() && settled.pattern.is_none();
        let mut held_out_ratio = None;
        if let Some(mut early) = early {
            for (bench, found) in early.benches.iter_mut().zip(&settled.given.benches) {
                bench.set_noise(found.noise);
            }
            if let Some(foretold) = foretold(&early) {
                let is = spread(&early, &foretold.left, late.clone());
                let noise = floor(&settled.given, late.clone()).all_rad();
                let (is_all, was_all) = (is.all_rad(), was_late.all_rad());
                let clear = |part: &usize| was_all[*part] / noise[*part];
                let part = (0..is_all.len()).max_by(|a, b| clear(a).total_cmp(&clear(b)));
                held_out_ratio = part
                    .map(|part| is_all[part] / was_all[part])
                    .filter(|ratio| ratio.is_finite());
                if alone {
                    fit.held_out.rms_after_rad = Some(is.fast_rad());
                    fit.held_out.reducible_removed =
                        removed(&open, &settled.given, &early, &foretold);
                }
            }
        }
        Some(Open {
            mechanism,
            board: open,
            model,
            held_out_ratio,
        })
    }
}

/// All turns with the loop that the earlier ones show; none where they do not show it.
fn early(rig: &[Recorded]) -> Option<Board> {
    let cut: Vec<Recorded> = rig.iter().map(first_turns).collect();
    let board = prepare::board(&cut).ok()?;
    let motion = closed_loop::recognised(&cut, &board)?;
    prepare::board(&with_twins(rig, &motion.twins)).ok()
}

/// All turns less what the task held up as the earlier ones show it; none where they do not.
fn early_task(rig: &[Recorded], task: &NoiseFinding) -> Option<Board> {
    let cut: Vec<Recorded> = rig.iter().map(first_turns).collect();
    let board = prepare::board(&cut).ok()?;
    let left = board.fit(board.nuisances())?.left;
    let seen = refit(&board, &left, task)?;
    let mut rig = rig.to_vec();
    for (one, ends) in rig.iter_mut().zip(seen.ends) {
        one.track.ends = ends;
    }
    prepare::board(&rig).ok()
}

/// A recording up to the turns that judge.
fn first_turns(one: &Recorded) -> Recorded {
    let mut one = one.clone();
    let edges: usize = one.track.stretches.iter().map(|s| s.marks.len()).sum();
    let mut left = edges * FITTED / PARTS;
    for stretch in &mut one.track.stretches {
        stretch.marks.truncate(left);
        left -= stretch.marks.len();
    }
    one.track
        .stretches
        .retain(|stretch| !stretch.marks.is_empty());
    one
}

/// What is left with the mean speed as the earlier turns show it.
fn foretold(board: &Board) -> Option<Model> {
    let nuisances = board.nuisances();
    let fitted = board.fit(board.cut(&nuisances, 0..FITTED))?;
    Some(board.with_sizes(&nuisances, &fitted.sizes))
}

/// Share of the squares that the loop removes on the last turns at best that it removed as foretold.
fn removed(open: &Board, looped: &Board, early: &Board, foretold: &Model) -> Option<f64> {
    let late = FITTED..PARTS;
    let best_of = |board: &Board| {
        let nuisances = board.nuisances();
        let best = board.fit(board.cut(&nuisances, late.clone()))?;
        let left = board.with_sizes(&nuisances, &best.sizes).left;
        Some(squares(board, &left, late.clone()))
    };
    let (without, at_best) = (best_of(open)?, best_of(looped)?);
    let lost = squares(early, &foretold.left, late.clone()) - at_best;
    let reducible = without - at_best;
    (reducible > SHOWS).then(|| (1.0 - lost / reducible).clamp(0.0, 1.0))
}
