//! What a diagnosis starts from: recordings, read, each with its twin; and why there may be none.

use thiserror::Error;

use super::edges::{Edges, Undecided};
use crate::twin::{Twin, TwinError};

/// A recording, its edges placed, with its twin.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// Its file, for messages.
    pub file: String,
    /// Its edges.
    pub edges: Edges,
    /// What should explain it.
    pub twin: Twin,
}

impl Recorded {
    /// Without an index the angle at which the twin's shaft starts, rad; none where that is not known.
    #[must_use]
    pub fn start_rad(&self) -> Option<f64> {
        let start = self.twin.shaft.initial_angle_rad;
        (!self.edges.anchored && start != 0.0).then_some(start)
    }
}

/// Why there is no diagnosis.
#[derive(Debug, Error)]
pub enum DiagnoseError {
    /// A twin can't be run.
    #[error(transparent)]
    Twin(#[from] TwinError),
    /// A recording says too little.
    #[error(
        "{file}: too short: {edges} edges in {turns:.2} turns; record 3 turns and {least} edges or more"
    )]
    TooShort {
        /// The recording.
        file: String,
        /// Edges in it.
        edges: usize,
        /// Turns they make.
        turns: f64,
        /// Edges needed.
        least: usize,
    },
    /// A recording of one channel, which does not show where the shaft turned round.
    #[error("{file}: {why}; record both channels, or no reversal")]
    Reversal {
        /// The recording.
        file: String,
        /// Why.
        why: Undecided,
    },
}
