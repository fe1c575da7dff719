//! Captures that a task holds up: their stamps say nothing of the shaft. A task that the twin declares is off before anything is looked
//! for; one that was found is taken off, and everything is looked for anew, in the noise that is left without its delays.

use super::board::Board;
use super::ends::Ends;
use super::explore::Explored;
use super::motion::foretold::Foretold;
use super::noise::{
    DOUBT, NoiseFinding, Refit, absent, account, agrees, confirm, find_task, refit,
};
use super::prepare;
use super::run::{DiagnoseError, Recorded};
use crate::report::si;

/// What recordings come to without what a task does to them.
#[derive(Debug)]
pub struct Held {
    /// Everything else.
    pub explored: Explored,
    /// The task that the twins lack, and the recordings with its delays.
    pub task: Option<(Refit, Foretold)>,
}

/// Explores recordings; each is told where a task held captures up.
///
/// # Errors
/// [`DiagnoseError`] where there is nothing to say.
pub fn explored(
    rig: &mut [Recorded],
    open: Board,
    progress: &mut dyn FnMut(f64, &'static str),
) -> Result<Held, DiagnoseError> {
    let alone = |explored| Held {
        explored,
        task: None,
    };
    let mut board = open.clone();
    if account(rig, &open) {
        board = prepare::board(rig)?;
        if !confirm(rig, &open, &board) {
            board = prepare::board(rig)?;
        }
    }
    let declared = rig.iter().any(|one| one.track.ends.is_some());
    let again = |explored: &Explored, found: &NoiseFinding, held: &[Option<Ends>]| {
        let busy_s = found.busy.as_ref()?.busy_s;
        let (board, left) = explored.rest(&open, held, DOUBT * busy_s)?;
        refit(&board, &left, found)
    };
    let held_up = |first: &Refit| first.ends.iter().any(Option::is_some);
    let sole = if declared { None } else { sole(&open) };
    let sole = sole.and_then(|(found, left)| Some((refit(&open, &left, &found)?, found)));
    let (first, found) = match sole.filter(|(first, _)| held_up(first)) {
        Some(sole) => sole,
        None => {
            let mut explored = Explored::of(rig, board, progress)?;
            if declared && task(&explored).is_some() {
                // The twin's task is not the whole of it.
                rig.iter_mut().for_each(|one| one.track.ends = None);
                explored = Explored::of(rig, open.clone(), progress)?;
            }
            let Some(found) = task(&explored) else {
                explored.noise.extend(not_there(rig, &open, &explored));
                return Ok(alone(explored));
            };
            let first = again(&explored, &found, &[]);
            let Some(first) = first.filter(held_up) else {
                return Ok(alone(explored));
            };
            (first, found)
        }
    };
    let foretold = Foretold::of_task(rig, open.clone(), &found);
    for (one, ends) in rig.iter_mut().zip(&first.ends) {
        one.track.ends = *ends;
    }
    let mut explored = Explored::of(rig, prepare::board(rig)?, progress)?;
    explored.noise.retain(|one| one.busy.is_none());
    let mut refit = again(&explored, &first.finding, &first.ends).unwrap_or(first);
    // The twin has it, only that something hid it at first.
    let known = rig.iter().all(|one| agrees(&refit.finding, &one.twin));
    let other = rig.first().and_then(|one| one.twin.capture_latency);
    if let Some((f_hz, busy_s)) = other.and_then(|other| other.task_hz.zip(other.busy_s)) {
        let text = &mut refit.finding.text;
        *text += &format!(
            "; the twin's does {f_hz:.3} times a second for {}",
            si(busy_s, "s")
        );
    }
    Ok(Held {
        explored,
        task: (!known).then_some((refit, foretold)),
    })
}

/// The twins' task, where none of the recordings has it.
fn not_there(rig: &[Recorded], open: &Board, explored: &Explored) -> Option<NoiseFinding> {
    let found = rig.iter().any(|one| one.track.ends.is_some());
    let declared = |one: &Recorded| one.twin.capture_latency?.task_hz;
    if found || !rig.iter().all(|one| declared(one).is_some()) {
        return None;
    }
    let (board, left) = explored.rest(open, &[], 0.0)?;
    absent(rig, &board, &left)
}

/// A task that makes most of what the twins leave, with that: while it is there a search would find little else.
fn sole(board: &Board) -> Option<(NoiseFinding, Vec<Vec<f64>>)> {
    /// Part of what is left beyond noise that it has to make.
    const PART: f64 = 0.8;
    /// Edges so far out, in standard deviations, that there are at the least.
    const FAR: f64 = 6.0;
    const FEW: usize = 10;
    // Noise that was guessed holds a part of it.
    if board.benches.iter().any(|bench| bench.declared.is_none()) {
        return None;
    }
    let left = board.fit(board.nuisances())?.left;
    let far = left.iter().flatten().filter(|w| w.abs() > FAR);
    if far.count() < FEW {
        return None;
    }
    let squares: f64 = left.iter().flatten().map(|w| w * w).sum();
    let task = find_task(board, &left)?.finding;
    let most = task.delta_bic > PART * (squares - board.edges() as f64);
    (most && task.plausible()).then_some((task, left))
}

/// The task among what the noise lacks.
fn task(explored: &Explored) -> Option<NoiseFinding> {
    explored
        .noise
        .iter()
        .find(|one| one.busy.is_some())
        .cloned()
}
