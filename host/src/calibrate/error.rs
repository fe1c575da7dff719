//! Why a recording can't be calibrated.

use quadcal::estimate::Totals;
use thiserror::Error;

use super::Likeness;
use crate::recording::ReadError;
use crate::sensor::PlanError;

/// Why a recording can't be calibrated. The file's name is the caller's to say.
#[derive(Debug, Error)]
pub enum CalibrateError {
    /// The recording can't be read.
    #[error(transparent)]
    Read(Box<ReadError>),
    /// No index where one is needed.
    #[error(
        "no index pulse in {rows} rows, so edges can't be tied to the disc; record Z too, or use --no-index for a table that \
         holds for this recording only"
    )]
    NoIndex {
        /// Rows read.
        rows: u64,
    },
    /// The number of lines is neither given nor to be found.
    #[error("the number of lines can't be found in this recording; give it with --lines or --twin")]
    LinesUnknown,
    /// The intervals repeat after another number of edges.
    #[error(
        "the intervals repeat every {repeat} edges, so the sensor has {likely} {name}, not {given}; use --lines {likely}",
        repeat = likely * classes
    )]
    WrongTurn {
        /// As declared.
        given: u32,
        /// As the intervals show.
        likely: u32,
        /// Edges a line.
        classes: u32,
        /// What is counted as lines.
        name: &'static str,
    },
    /// The recording shows another number of lines.
    #[error("{found} edges lie between index pulses: the encoder has {likely} lines, not {given}; use --lines {likely}", found = 4 * likely)]
    WrongLines {
        /// As declared.
        given: u32,
        /// As the index pulses show.
        likely: u32,
    },
    /// Too little to learn from.
    #[error(
        "{whole} whole turns can be used and three are needed (the first only sets the speed; {broken} broken, {irregular} \
         irregular, {speed_change} with a change of speed, {disagrees} unlike the others); record a longer or steadier run",
        whole = .0.turns,
        broken = .0.broken,
        irregular = .0.irregular,
        speed_change = .0.speed_change,
        disagrees = .0.disagrees
    )]
    TooFewTurns(Totals),
    /// Two recordings show different patterns.
    #[error(
        "the line patterns of the two agree to {found:.0} %, where those of one disc would agree to {expected:.0} %: they are not of one \
         disc, or its index moved between them; calibrate each by itself, or check with `quadcal locate`",
        found = 100.0 * likeness.found.max(0.0),
        expected = 100.0 * likeness.of_one_disc
    )]
    OtherDisc {
        /// Which of the recordings added before this one it does not go with, 0 the first.
        other: usize,
        /// How much of the patterns is alike.
        likeness: Likeness,
    },
    /// The core can't take such an encoder.
    #[error(transparent)]
    Plan(#[from] PlanError),
}

impl From<ReadError> for CalibrateError {
    fn from(error: ReadError) -> Self {
        Self::Read(Box::new(error))
    }
}
