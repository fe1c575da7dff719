//! A diagnosis from recordings and their twins.

use thiserror::Error;

use super::conclude::conclude;
use super::diagnosis::Diagnosis;
use super::prepare;
use super::search::search;
use super::settle::settle;
use super::shown::Shown;
use super::tell::tell;
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
        "{file}: {edges} edges in {turns:.1} turns say nothing: record 3 turns and 200 edges or more"
    )]
    TooShort {
        /// The recording.
        file: String,
        /// Edges in it.
        edges: usize,
        /// Turns they make.
        turns: f64,
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
    let mut board = prepare::board(rig)?;
    let given = board.clone();
    progress(0.2, "Searching");
    let searched = search(&mut board).ok_or_else(|| nothing(rig))?;
    progress(0.6, "Weighing");
    let concluded = conclude(&board, &searched);
    progress(0.8, "Simulating what was found");
    let settled = settle(rig, &given, board, searched, concluded)?;
    progress(0.95, "Judging");
    let diagnosed = tell(rig, &settled);
    progress(1.0, "Done");
    Ok(diagnosed)
}

/// A recording in which nothing moves can't be fitted.
fn nothing(rig: &[Recorded]) -> DiagnoseError {
    let first = rig.first();
    DiagnoseError::TooShort {
        file: first.map(|one| one.file.clone()).unwrap_or_default(),
        edges: 0,
        turns: first.map_or(0.0, |one| one.track.turns()),
    }
}
