//! A diagnosis from recordings and their twins.

use thiserror::Error;

use super::alone::alone;
use super::beside::{of_events, of_motion, of_noise, of_pushes};
use super::diagnosis::Diagnosis;
use super::held_up::{self, Held};
use super::inertia;
use super::motion::foretold::Foretold;
use super::motion::sticking::Sticking;
use super::motion::{closed_loop, stick_slip, sticking};
use super::next;
use super::plots;
use super::prepare;
use super::settle::settle;
use super::shown::Shown;
use super::start;
use super::tell::tell;
use super::torques::in_torques;
use super::track::Track;
use crate::sensor::SensorPlan;
use crate::twin::{Twin, TwinError};

/// A recording, read, with its twin.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// Its file, for messages.
    pub file: String,
    /// Its sensor.
    pub plan: SensorPlan,
    /// Its edges.
    pub track: Track,
    /// What should explain it.
    pub twin: Twin,
}

impl Recorded {
    /// Without an index the angle at which the twin's shaft starts, rad; none where that is not known.
    #[must_use]
    pub fn start_rad(&self) -> Option<f64> {
        let start = self.twin.shaft.initial_angle_rad;
        (!self.track.anchored && start != 0.0).then_some(start)
    }
}

/// Everything that comes of a diagnosis.
#[derive(Clone, Debug)]
pub struct Diagnosed {
    /// What it says.
    pub diagnosis: Diagnosis,
    /// What a report draws.
    pub shown: Shown,
    /// The twins with the findings in them, one for each recording.
    pub twins: Vec<Twin>,
    /// For each recording, if the disc was learned edge by edge, the whole of e, rad for each edge of the grid; it takes the place of
    /// all of the twin's `errors`.
    pub error_lists: Vec<Option<Vec<f64>>>,
}

/// Why there is no diagnosis.
#[derive(Debug, Error)]
pub enum DiagnoseError {
    /// A twin can't be run.
    #[error(transparent)]
    Twin(#[from] TwinError),
    /// A recording says too little.
    #[error(
        "{file}: too short: {edges} edges in {turns:.2} turns, with an index from its first pulse on; record 3 turns and 200 edges or more"
    )]
    TooShort {
        /// The recording.
        file: String,
        /// Edges in it.
        edges: usize,
        /// Turns they make.
        turns: f64,
    },
    /// Edges that no motion can be fitted to.
    #[error(
        "{file}: no motion can be fitted to its {edges} edges; check that they are of a shaft that turns, as its twin does"
    )]
    NoFit {
        /// The recording.
        file: String,
        /// Edges in it.
        edges: usize,
    },
    /// Too few slips of a shaft that should stick and slip as its twin does.
    #[error(
        "{file}: {slips} whole slips say nothing of a twin that sticks and slips ({twin}): record {needed} or more, some {seconds:.3} s"
    )]
    FewSlips {
        /// The recording.
        file: String,
        /// The twin.
        twin: String,
        /// Slips in it, from standstill to standstill.
        slips: usize,
        /// Slips needed.
        needed: usize,
        /// How long the twin takes for them, s.
        seconds: f64,
    },
    /// A twin whose motion is nothing like the recording's.
    #[error(
        "{file}: the twin {twin} never goes where the recording goes: {why}; check drive and duration"
    )]
    OtherMotion {
        /// The recording.
        file: String,
        /// The twin.
        twin: String,
        /// What differs.
        why: String,
    },
    /// A twin that can't have made a recording.
    #[error("{file}: the twin {twin} can't have made this: {why}")]
    OtherRig {
        /// The recording.
        file: String,
        /// The twin.
        twin: String,
        /// What can't be, and what to correct.
        why: String,
    },
}

/// Finds what the twins of one rig lack. `progress` is told the share done, 0 to 1, and what is going on.
///
/// # Errors
/// [`DiagnoseError`] where there is nothing to say.
pub fn diagnose(
    rig: &[Recorded],
    progress: &mut dyn FnMut(f64, &'static str),
) -> Result<Diagnosed, DiagnoseError> {
    progress(0.05, "Simulating");
    let mut rig: Vec<Recorded> = rig.to_vec();
    for one in &mut rig {
        one.twin = in_torques(&one.twin);
    }
    start::counted(&mut rig);
    let mut found = of_events(&rig);
    // What sticks and slips is no small change of the twin's motion: nothing else can be told beside it.
    match sticking::against(&rig)? {
        Some(Sticking::Alike(agreement)) => return Ok(alone(&rig, None, agreement, found)),
        Some(Sticking::Otherwise(motion, agreement)) => {
            found.push(of_motion(&motion));
            return Ok(alone(&rig, Some(motion), agreement, found));
        }
        Some(Sticking::Not(motion)) => {
            found.push(of_motion(&motion));
            for (one, twin) in rig.iter_mut().zip(motion.twins) {
                one.twin = twin;
            }
        }
        None => {
            if let Some((motion, agreement)) = stick_slip::recognised(&rig) {
                found.push(of_motion(&motion));
                return Ok(alone(&rig, Some(motion), agreement, found));
            }
        }
    }
    found.extend(of_pushes(&rig));
    let mut board = prepare::board(&rig)?;
    let mut foretold = None;
    if let Some(motion) = closed_loop::recognised(&rig, &board) {
        found.push(of_motion(&motion));
        foretold = Some(Foretold::of(&rig, board));
        for (one, twin) in rig.iter_mut().zip(motion.twins) {
            one.twin = twin;
        }
        board = prepare::board(&rig)?;
    } else {
        inertia::checked(&rig, &board)?;
    }
    for (one, bench) in rig.iter_mut().zip(&board.benches) {
        let ties = bench.seen.ties.iter().filter(|tie| tie.turned);
        one.track.turned = Some(ties.map(|tie| tie.at_s).collect::<Vec<f64>>())
            .filter(|_| !bench.seen.ties.is_empty());
    }
    let Held { explored, task } = held_up::explored(&mut rig, board, progress)?;
    let (task, without_task) = task.unzip();
    let foretold = foretold.or(without_task);
    let noise = explored
        .noise
        .iter()
        .chain(task.iter().map(|task| &task.finding));
    found.extend(noise.map(|one| of_noise(one, &rig[0])));
    progress(0.8, "Simulating what was found");
    let mut settled = settle(
        &rig,
        &explored.given,
        explored.board,
        explored.searched,
        explored.concluded,
    )?;
    let open = foretold.and_then(|foretold| foretold.put_in(&mut settled));
    progress(0.9, "Simulating what to record next");
    let next = next::recordings(&rig, &settled);
    progress(0.95, "Judging");
    let mut diagnosed = tell(&rig, &settled, &next, found);
    if let Some(open) = open {
        plots::without(&mut diagnosed, &open);
    }
    if let Some(task) = task {
        plots::with_task(&mut diagnosed, task.plot);
    }
    progress(1.0, "Done");
    Ok(diagnosed)
}

/// A recording in which nothing moves can't be fitted.
pub(super) fn nothing(rig: &[Recorded]) -> DiagnoseError {
    let first = rig.first();
    let edges = |one: &Recorded| one.track.stretches.iter().map(|s| s.marks.len()).sum();
    DiagnoseError::NoFit {
        file: first.map(|one| one.file.clone()).unwrap_or_default(),
        edges: first.map_or(0, edges),
    }
}
