//! From a recording to an error table: survey, decode, learn, solve.

use quadcal::estimate::{Anchor, Estimator, Progress, Solution, Totals};
use quadcal::slot::{Delays, SlotHeader};
use quadcal::step::Faults;
use thiserror::Error;

use crate::buffers::HeapBuffers;
use crate::recording::{Channels, ReadError, Recording};
use crate::sensor::{PlanError, SensorKind, SensorPlan};
use crate::survey::Survey;

/// What the user says of a calibration; the rest is found in the recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CalibrateOptions {
    /// Lines, pole pairs or teeth a turn.
    pub lines: Option<u32>,
    /// Use this many turns at most.
    pub turns: Option<u32>,
    /// Use the recording up to this tick only.
    pub until: Option<u64>,
    /// Missing teeth of a wheel.
    pub missing: u16,
    /// Calibrate a quadrature recording without an index, relative to its first edge.
    pub without_index: bool,
}

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
         irregular, {speed_change} with a change of speed); record a longer or steadier run"
    )]
    TooFewTurns {
        /// Turns that could be used.
        whole: u32,
        /// Turns with lost or extra edges or a reversal.
        broken: u32,
        /// Turns with a stop or an edge far out of place.
        irregular: u32,
        /// Turns that took an eighth longer or shorter than the one before.
        speed_change: u32,
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

/// A solved calibration and how it came about.
pub struct Calibration {
    /// What the recording is.
    pub survey: Survey,
    /// The sensor, as declared or found.
    pub plan: SensorPlan,
    /// The table.
    pub solution: Solution<HeapBuffers>,
    /// Turns taken and rejected.
    pub totals: Totals,
    /// Faults seen by the decoder in the part that was used.
    pub faults: Faults,
    /// Last tick that was learned from.
    pub learned_until: u64,
}

impl Calibration {
    /// The head of the slot that keeps this table; `source` is the check sum of the recording's start.
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
            learned_until: self.learned_until,
            class_offsets: *self.solution.class_offsets(),
            delays: Delays::NONE,
        }
    }
}

/// The sensor that a survey shows, checked against what was declared.
///
/// # Errors
/// [`CalibrateError`] when the index or the number of lines is missing or contradicts the declaration.
pub fn plan(survey: &Survey, options: &CalibrateOptions) -> Result<SensorPlan, CalibrateError> {
    match survey.header.channels {
        Channels::Quadrature { .. } => {
            let indexed = survey.index_pulses > 0;
            if !indexed && !options.without_index {
                return Err(CalibrateError::NoIndex { rows: survey.rows });
            }
            let lines = match (options.lines, survey.lines()) {
                (Some(given), Some(likely)) if given != likely => {
                    return Err(CalibrateError::WrongLines { given, likely });
                }
                (Some(lines), _) | (None, Some(lines)) => lines,
                (None, None) => return Err(CalibrateError::LinesUnknown),
            };
            let index_state = indexed.then(|| survey.index_state());
            Ok(SensorPlan {
                kind: SensorKind::Quadrature { index_state },
                lines,
            })
        }
        channels => plan_by_pattern(
            survey,
            SensorKind::of(channels, None, options.missing),
            options.lines,
        ),
    }
}

/// A sensor without an index: its turn is the one after which the intervals repeat.
fn plan_by_pattern(
    survey: &Survey,
    kind: SensorKind,
    given: Option<u32>,
) -> Result<SensorPlan, CalibrateError> {
    let classes = kind.classes();
    // A gap is no interval like the others; the decoder finds the turn by it.
    let gap = matches!(kind, SensorKind::Wheel { missing: 1.., .. });
    let found = if gap { None } else { survey.repeat(classes) };
    let likely = found
        .and_then(|repeat| u32::try_from(repeat.edges).ok())
        .map(|edges| edges / classes);
    let lines = match (given, likely) {
        (Some(given), Some(likely)) if given % likely != 0 => {
            let fits = survey
                .repeat_at(given.saturating_mul(classes))
                .is_some_and(|repeat| found.is_none_or(|found| repeat.left < 1.5 * found.left));
            if !fits {
                return Err(CalibrateError::WrongTurn {
                    given,
                    likely,
                    classes,
                    name: kind.line_name(),
                });
            }
            given
        }
        (Some(lines), _) | (None, Some(lines)) => lines,
        (None, None) => return Err(CalibrateError::LinesUnknown),
    };
    Ok(SensorPlan { kind, lines })
}

/// Learns from a recording that was surveyed before.
///
/// # Errors
/// [`CalibrateError`] when the recording can't be read or holds too little.
pub fn learn(
    survey: Survey,
    plan: SensorPlan,
    recording: impl Iterator<Item = Result<crate::recording::Row, ReadError>>,
    options: &CalibrateOptions,
) -> Result<Calibration, CalibrateError> {
    let shape = plan.shape()?;
    let mut decoder = plan.decoder()?;
    let buffers = HeapBuffers::new(shape.edges() as usize);
    let mut estimator =
        Estimator::new(shape, plan.anchor(), buffers).map_err(|_| PlanError::Lines(plan.lines))?;
    let most = options.turns.unwrap_or(u32::MAX);
    let mut learned_until = 0;
    for row in recording {
        let row = row?;
        if options.until.is_some_and(|until| row.ticks > until) {
            break;
        }
        let outcome = decoder.push(row);
        if let Progress::TurnTaken(turns) = estimator.push(&outcome) {
            learned_until = row.ticks;
            if turns >= most {
                break;
            }
        }
    }
    let totals = *estimator.totals();
    let faults = decoder.faults();
    let solution = estimator.solve().map_err(|_| CalibrateError::TooFewTurns {
        whole: totals.turns,
        broken: totals.broken,
        irregular: totals.irregular,
        speed_change: totals.speed_change,
    })?;
    Ok(Calibration {
        survey,
        plan,
        solution,
        totals,
        faults,
        learned_until,
    })
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
