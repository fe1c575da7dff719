//! A diagnosis from recordings and their twins.

use thiserror::Error;

use super::alone::alone;
use super::beside::{of_events, of_motion, of_noise, of_pushes};
use super::board::{Board, Model};
use super::conclude::{Conclusion, conclude};
use super::diagnosis::{Diagnosis, Finding};
use super::motion::foretold::Foretold;
use super::motion::sticking::Sticking;
use super::motion::{closed_loop, stick_slip, sticking};
use super::next;
use super::noise::{
    NoiseFinding, find_task, is_own, noise_findings, own_columns, rhythmic_findings,
};
use super::plots;
use super::prepare;
use super::search::{Found, Searched, search};
use super::settle::settle;
use super::shown::Shown;
use super::start;
use super::tell::tell;
use super::torques::in_torques;
use super::track::Track;
use crate::mechanism::Mechanism;
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

/// Part of the rhythms' score that a mode needs in their place, and a task.
const MODE: f64 = 0.3;
const TASK: f64 = 0.8;

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
    }
    let given = board.clone();
    progress(0.2, "Searching");
    let searched = search(&mut board).ok_or_else(|| nothing(&rig))?;
    progress(0.6, "Weighing");
    let (mut concluded, heard) = rayon::join(
        || conclude(&board, &searched),
        || Heard::of(&rig, &given, &board, &searched),
    );
    found.extend(noise(
        &rig,
        &given,
        &board,
        &searched,
        heard,
        &mut concluded,
    ));
    progress(0.8, "Simulating what was found");
    let mut settled = settle(&rig, &given, board, searched, concluded)?;
    let open = foretold.and_then(|foretold| foretold.put_in(&mut settled));
    progress(0.9, "Simulating what to record next");
    let next = next::recordings(&rig, &settled);
    progress(0.95, "Judging");
    let mut diagnosed = tell(&rig, &settled, &next, found);
    if let Some(open) = open {
        plots::without_loop(&mut diagnosed, &open);
    }
    progress(1.0, "Done");
    Ok(diagnosed)
}

/// What the noise lacks, as far as it does not hang on the conclusion.
struct Heard {
    /// Noise in the place of rhythms, where rhythms were found.
    instead: Option<Vec<NoiseFinding>>,
    /// What else there is, where it is not that.
    beside: Vec<NoiseFinding>,
}

impl Heard {
    fn of(rig: &[Recorded], given: &Board, board: &Board, searched: &Searched) -> Self {
        let mut found = searched.found.iter();
        let rhythms = found.any(|f| f.hypothesis.rhythm().is_some());
        let instead = rhythms.then(|| in_place(rig, given, board, searched));
        let beside = if instead.as_ref().is_none_or(Vec::is_empty) {
            noise_findings(board, &searched.model)
        } else {
            Vec::new()
        };
        Self { instead, beside }
    }
}

/// What the noise lacks; where that explains what the search only resembled, it takes its place.
fn noise(
    rig: &[Recorded],
    given: &Board,
    board: &Board,
    searched: &Searched,
    heard: Heard,
    concluded: &mut Conclusion,
) -> Vec<Finding> {
    let mut noise: Vec<NoiseFinding> = Vec::new();
    if heard.instead.is_some() || concluded.nameless.is_some() {
        let known = heard.instead;
        noise = known.unwrap_or_else(|| in_place(rig, given, board, searched));
        if !noise.is_empty() {
            concluded
                .named
                .retain(|name| name.hypothesis.rhythm().is_none());
            concluded.nameless = None;
        }
    }
    if noise.is_empty() && concluded.nameless.is_none() {
        noise = heard.beside;
    }
    noise
        .iter()
        .map(|one| of_noise(one, &rig[0].twin))
        .collect()
}

/// Noise that is one thing where the rhythms that were found are many, or a task beside what else was found.
fn in_place(
    rig: &[Recorded],
    given: &Board,
    board: &Board,
    searched: &Searched,
) -> Vec<NoiseFinding> {
    let mut noise = instead(rig, given, searched);
    if noise.is_empty() {
        noise.extend(task_beside(board, searched));
    }
    noise
}

/// A task that explains the rhythms that were found, beside whatever else was.
fn task_beside(board: &Board, searched: &Searched) -> Option<NoiseFinding> {
    let rhythm = |found: &&Found| found.hypothesis.rhythm().is_some();
    let score: f64 = searched.found.iter().filter(rhythm).map(|f| f.score).sum();
    let others = searched.found.iter().filter(|found| !rhythm(found));
    let columns = board
        .nuisances()
        .into_iter()
        .chain(others.flat_map(|found| found.columns.clone()));
    let model = board.fit(columns.collect())?;
    let task = find_task(board, &model.left)?.finding;
    (task.plausible() && task.delta_bic > TASK * score).then_some(task)
}

/// Noise that is one thing where the rhythms that were found are many: a mode or a task.
fn instead(rig: &[Recorded], given: &Board, searched: &Searched) -> Vec<NoiseFinding> {
    let rhythms = || {
        let all = searched.found.iter();
        all.filter(|found| found.hypothesis.rhythm().is_some())
    };
    let score: f64 = rhythms().map(|found| found.score).sum();
    let before = given
        .fit(given.nuisances())
        .unwrap_or_else(|| Model::none(given));
    let mut noise = rhythmic_findings(given, &before);
    noise.retain(|one| match one.mechanism {
        Mechanism::TorsionalResonance => one.delta_bic > MODE * score,
        Mechanism::CaptureLatency => one.delta_bic > TASK * score && !one.frequencies_hz.is_empty(),
        _ => false,
    });
    let own = own_columns(given, rig);
    if !noise.is_empty() || own.is_empty() {
        return noise;
    }
    // A mode answers the twin's own ripples otherwise than a stiff shaft does: what is left of them speaks neither for nor against it.
    let others = rhythms().filter(|found| !is_own(given, rig, &found.hypothesis));
    let score: f64 = others.map(|found| found.score).sum();
    let columns = given.nuisances().into_iter().chain(own).collect();
    let Some(before) = given.fit(columns) else {
        return Vec::new();
    };
    let mut noise = rhythmic_findings(given, &before);
    noise.retain(|one| {
        one.mechanism == Mechanism::TorsionalResonance && one.delta_bic > MODE * score
    });
    noise
}

/// A recording in which nothing moves can't be fitted.
fn nothing(rig: &[Recorded]) -> DiagnoseError {
    let first = rig.first();
    let edges = |one: &Recorded| one.track.stretches.iter().map(|s| s.marks.len()).sum();
    DiagnoseError::NoFit {
        file: first.map(|one| one.file.clone()).unwrap_or_default(),
        edges: first.map_or(0, edges),
    }
}
