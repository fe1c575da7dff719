//! From recordings of one encoder to its error table: survey, decode, learn, solve.

mod agree;
mod error;
mod learner;
mod plan;
mod progress;
mod rejected;
mod turns;

use quadcal::estimate::{Anchor, DriveKnowledge, Goal, Solution, Totals};
use quadcal::slot::SlotHeader;
use quadcal::step::Faults;
use quadcal::units::RAD_PER_TURN32;

pub use agree::{Disagreement, agree};
pub use error::CalibrateError;
pub use learner::Learner;
pub use plan::plan;
pub use progress::{AfterTurn, LearningProgress, goal_of};
pub use rejected::{RejectedTurn, RejectedTurns};

use crate::buffers::HeapBuffers;
use crate::free_run::FreeRun;
use crate::recording::{ReadError, Recording, Row};
use crate::sensor::SensorPlan;
use crate::survey::Survey;

/// Share of orders at which fast and slow turns of one disc may differ, per cent: torque is at a few, and strong ripple at the sums
/// and differences of its orders too.
const TORQUE_MAX_PERCENT: u32 = 75;

/// Edges from which on there are so many orders; torque may well be at most of a Hall motor's.
const EDGES_MIN: u32 = 1000;

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
    /// Stop learning from a recording where this is met, or more turns don't help.
    pub goal: Option<Goal>,
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
    /// Which turns were rejected, and why.
    pub rejected: RejectedTurns,
    /// Faults seen by the decoder in the part that was used.
    pub faults: Faults,
    /// Last tick that was learned from.
    pub learned_until: u64,
}

impl RecordingUse {
    /// When a turn began, counted from the recording's first row, and how long it took, s; of the latter nothing where the recording
    /// ends within the turn.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn seconds_of(&self, turn: &RejectedTurn) -> (f64, Option<f64>) {
        let seconds = |ticks: u64| ticks as f64 / self.survey.header.clock_hz as f64;
        (
            seconds(turn.start.saturating_sub(self.survey.first)),
            turn.duration.map(seconds),
        )
    }

    /// Speed of the slowest turn learned from, turns a second.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn slowest_turns_per_s(&self) -> f64 {
        self.survey.header.clock_hz as f64 / self.totals.longest.max(1) as f64
    }
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
    /// Standard error, rad, that undoing a speed loop puts on every line besides: it repeats each turn, so that the scatter of turns,
    /// which the solution goes by, does not show it.
    pub loop_error_rad: f64,
    /// Turns taken and rejected, of all recordings.
    pub totals: Totals,
    /// Faults seen by the decoder in the parts that were used, of all recordings.
    pub faults: Faults,
    /// How good the table was after each turn.
    pub progress: LearningProgress,
    /// The goal that there was.
    pub goal: Option<Goal>,
    /// What each recording gave, in the order learned from.
    pub recordings: Vec<RecordingUse>,
}

impl Calibration {
    /// The head of the slot that keeps this table; `source` is the check sum of the first recording's start. A slot has room
    /// for one recording's mark, so it is the first of which a check knows which turns were learned from.
    #[must_use]
    pub fn slot_header(&self, source: u32) -> SlotHeader {
        let learned_until = self.recordings.first().map_or(0, |used| used.learned_until);
        SlotHeader {
            indexed: self.plan.anchor() == Anchor::Index,
            standard_error: rad_to_turn32(self.standard_error_rad()),
            source,
            ..SlotHeader::of(&self.solution, learned_until, self.clock_hz)
        }
    }

    /// Standard error of one edge's line position error, rad: that of the solution and that of undoing a speed loop together.
    #[must_use]
    pub fn standard_error_rad(&self) -> f64 {
        let solution = f64::from(self.solution.standard_error()) * RAD_PER_TURN32;
        solution.hypot(self.loop_error_rad)
    }

    /// Counts what was left of the loops that were undone in the recordings, in the order learned from.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn with_loops_undone(mut self, runs: &[Option<&FreeRun>]) -> Self {
        // Turns are averaged by the square of their speed; each recording's gains have an error of their own.
        let weight = |used: &RecordingUse| {
            let duration = 0.5 * (used.totals.shortest as f64 + used.totals.longest as f64);
            f64::from(used.totals.turns) / (duration * duration)
        };
        let all: f64 = self.recordings.iter().map(weight).sum();
        let parts = self.recordings.iter().zip(runs).filter_map(|(used, run)| {
            let error = (*run)?.repeating_error_rad();
            Some(error * weight(used) / all)
        });
        self.loop_error_rad = parts.fold(0.0, f64::hypot);
        self
    }

    /// The last of the orders, from 1, that the table leaves alone as a speed loop may hide them; 0 for none. Less than what was declared
    /// where that is among the orders which are weighed together.
    #[must_use]
    pub fn left_alone_for_loop(&self) -> u16 {
        let weight = |order: &u16| self.solution.order_weight(usize::from(*order));
        let declared = 1..=self.drive.hidden_up_to;
        declared
            .take_while(|order| weight(order) == 0)
            .last()
            .unwrap_or(0)
    }

    /// Whether the recordings, driven freely, can be of one disc. What is left of a speed loop may differ as much as two discs do.
    ///
    /// # Errors
    /// [`CalibrateError::OtherDisc`] where slow and fast turns differ at most orders, and by much.
    pub fn check_one_disc(&self) -> Result<(), CalibrateError> {
        let many_orders = self.solution.shape().edges() >= EDGES_MIN;
        let differ = self.solution.torque_share_percent();
        if self.recordings.len() > 1 && many_orders && differ > TORQUE_MAX_PERCENT {
            return Err(CalibrateError::OtherDisc(differ));
        }
        Ok(())
    }

    /// Whether the turns' speeds differ enough to tell torque from geometry: see [`Totals::two_speeds`].
    #[must_use]
    pub fn two_speeds(&self) -> bool {
        self.totals.two_speeds()
    }
}

/// An angle in 2^-32 turn, to the nearest, capped.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn rad_to_turn32(rad: f64) -> u32 {
    (rad / RAD_PER_TURN32).round() as u32
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
