//! From recordings of one encoder to its error table: survey, decode, learn, solve.

mod agree;
mod error;
mod learner;
mod plan;

use quadcal::estimate::{Anchor, DriveKnowledge, Solution, Totals};
use quadcal::slot::{Delays, SlotHeader, Stamp};
use quadcal::step::Faults;

pub use agree::{Disagreement, agree};
pub use error::CalibrateError;
pub use learner::Learner;
pub use plan::plan;

use crate::buffers::HeapBuffers;
use crate::recording::{ReadError, Recording, Row};
use crate::sensor::SensorPlan;
use crate::survey::Survey;

/// What the user says of a calibration; the rest is found in the recordings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CalibrateOptions {
    /// Lines, pole pairs or teeth a turn.
    pub lines: Option<u32>,
    /// Use this many turns of a recording at most.
    pub turns: Option<u32>,
    /// Use the recording up to this tick only.
    pub until: Option<u64>,
    /// Missing teeth of a wheel.
    pub missing: u16,
    /// Calibrate a quadrature recording without an index, relative to its first edge.
    pub without_index: bool,
    /// What is known of the drive.
    pub drive: DriveKnowledge,
}

/// What one recording gave to a calibration.
#[derive(Clone, Debug)]
pub struct RecordingUse {
    /// What the recording is.
    pub survey: Survey,
    /// Turns taken and rejected.
    pub totals: Totals,
    /// Faults seen by the decoder in the part that was used.
    pub faults: Faults,
    /// Last tick that was learned from.
    pub learned_until: u64,
}

/// A solved calibration and how it came about.
pub struct Calibration {
    /// The sensor, as declared or found.
    pub plan: SensorPlan,
    /// Ticks a second, the same in all recordings.
    pub clock_hz: u64,
    /// What was said of the drive.
    pub drive: DriveKnowledge,
    /// The table.
    pub solution: Solution<HeapBuffers>,
    /// Turns taken and rejected, of all recordings.
    pub totals: Totals,
    /// Faults seen by the decoder in the parts that were used, of all recordings.
    pub faults: Faults,
    /// What each recording gave, in the order learned from.
    pub recordings: Vec<RecordingUse>,
}

impl Calibration {
    /// The head of the slot that keeps this table; `source` is the check sum of the first recording's start. A slot has room
    /// for one recording's mark, so it is the first of which a check knows which turns were learned from.
    #[must_use]
    pub fn slot_header(&self, source: u32) -> SlotHeader {
        SlotHeader {
            shape: self.solution.shape(),
            shift: self.solution.shift(),
            turns: self.solution.turns(),
            indexed: self.plan.anchor() == Anchor::Index,
            standard_error: self.solution.standard_error(),
            class_standard_error: self.solution.class_standard_error(),
            source,
            learned_until: self.recordings.first().map_or(0, |used| used.learned_until),
            class_offsets: *self.solution.class_offsets(),
            delays: Delays::found(self.solution.class_delays(), self.clock_hz),
            stamp: Stamp {
                table_rms: self.solution.table_rms(),
                ..Stamp::default()
            },
        }
    }

    /// Whether the turns' speeds differ enough to tell torque from geometry: one took half as long again as another.
    #[must_use]
    pub fn two_speeds(&self) -> bool {
        let Totals {
            shortest, longest, ..
        } = self.totals;
        longest >= shortest + shortest / 2
    }
}

/// Learns from one recording that was surveyed before.
///
/// # Errors
/// [`CalibrateError`] when the recording can't be read or holds too little.
pub fn learn(
    survey: Survey,
    plan: SensorPlan,
    rows: impl Iterator<Item = Result<Row, ReadError>>,
    options: &CalibrateOptions,
) -> Result<Calibration, CalibrateError> {
    let mut learner = Learner::new(plan, survey.header.clock_hz, options.drive)?;
    learner.add(survey, rows, options)?;
    learner.solve()
}

/// Surveys a recording and learns from it: `open` is called twice.
///
/// # Errors
/// [`CalibrateError`] when the recording can't be read or does not hold what is needed.
pub fn calibrate(
    mut open: impl FnMut() -> Result<Recording, ReadError>,
    options: &CalibrateOptions,
) -> Result<Calibration, CalibrateError> {
    let recording = open()?;
    let survey = Survey::of(recording.header.clone(), recording)?;
    let plan = plan(&survey, options)?;
    learn(survey, plan, open()?, options)
}
