//! How good a table is on a recording: scatter of the intervals and, against a reference encoder, equations (21) and (22).

mod pattern;
mod reference;
mod scatter;

use std::f64::consts::TAU;

use quadcal::corrector::Corrector;
use quadcal::estimate::Anchor;
use quadcal::shape::{EncoderShape, Grid};
use quadcal::slot::Slot;
use quadcal::step::Flags;
use quadcal::table::TableError;
use thiserror::Error;

pub use pattern::PatternFound;
pub use reference::{Reference, ReferenceError};
pub use scatter::{Profile, Scatter};

use crate::recording::{ReadError, Row};
use crate::sensor::{PlanError, SensorPlan};
use reference::Comparison;
use scatter::ScatterMeter;

/// Why a table can't be checked against a recording.
#[derive(Debug, Error)]
pub enum VerifyError {
    /// The recording can't be read.
    #[error(transparent)]
    Read(Box<ReadError>),
    /// The sensor's numbers are out of range.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The table does not fit itself; a checked slot never gives this.
    #[error(
        "the table's entries do not fit its header ({0:?}); write it again with quadcal calibrate"
    )]
    Table(TableError),
    /// The table is for another encoder.
    #[error(
        "the table is for {table} edges a turn in {table_classes} classes, the recording shows {recording} in {recording_classes}; \
         use the table of this encoder"
    )]
    Shape {
        /// Edges of the table.
        table: u32,
        /// Classes of the table.
        table_classes: u32,
        /// Edges of the recording.
        recording: u32,
        /// Classes of the recording.
        recording_classes: u32,
    },
    /// A table without index, and not from this recording.
    #[error(
        "the table has no index as its origin, so it holds only for the recording it was learned from, and this is another; \
         calibrate on this one (--turns leaves turns to verify on)"
    )]
    NotAnchored,
    /// No whole turn that was not learned from.
    #[error(
        "no whole turn is left that the table was not learned from; calibrate with --turns or --fraction, or verify on another \
         recording"
    )]
    NothingLeft,
    /// Less than a turn to check on.
    #[error(
        "only {intervals} intervals are left that the table was not learned from, less than a turn of {needed}; calibrate with --turns or \
         --fraction, or verify on another recording"
    )]
    TooLittle {
        /// Intervals that could be held against the turn about them.
        intervals: u64,
        /// Intervals of a turn.
        needed: u64,
    },
    /// A reference of another run, ratio or clock.
    #[error(
        "the reference does not fit this recording: from turn to turn it wanders {wander_urad:.0} µrad off the encoder, whose own errors \
         are {repeating_urad:.0} µrad; check --ratio and its sign, that time counts from the recording's tick 0, and that both were \
         recorded together",
        wander_urad = 1e6 * wander_rad,
        repeating_urad = 1e6 * repeating_rad
    )]
    ReferenceMisfit {
        /// RMS of the error that differs from turn to turn, rad.
        wander_rad: f64,
        /// RMS of what repeats, rad.
        repeating_rad: f64,
    },
}

impl From<ReadError> for VerifyError {
    fn from(error: ReadError) -> Self {
        Self::Read(Box::new(error))
    }
}

/// What a check found.
#[derive(Clone, Debug)]
pub struct Verification {
    /// Whether the recording is the one that the table was learned from; then only later turns were looked at.
    pub same_recording: bool,
    /// Intervals of a turn.
    pub turn_intervals: u64,
    /// Scatter of the intervals.
    pub scatter: Scatter,
    /// Mean relative speed at every edge, before and after, and one turn of speed as it was.
    pub profile: Profile,
    /// How much of the table's line pattern shows; none where it can't be told.
    pub pattern: Option<PatternFound>,
    /// Errors against a reference, if there was one.
    pub reference: Option<ReferenceCheck>,
}

/// Equations (21) and (22), before and after correction.
#[derive(Clone, Debug)]
pub struct ReferenceCheck {
    /// Edges compared.
    pub edges: u64,
    /// RMSE before correction, rad.
    pub before_rad: f64,
    /// RMSE after correction, rad.
    pub after_rad: f64,
    /// RMS of the part of the error before correction that differs from turn to turn, rad.
    pub wander_rad: f64,
    /// Mean error of every edge before correction, rad.
    pub error_before_rad: Vec<f64>,
    /// Mean error of every edge after correction, rad.
    pub error_after_rad: Vec<f64>,
}

/// What a check says of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Angles are better with the table.
    Better,
    /// No difference beyond chance: there was nothing to correct, or nothing that could be learned.
    Same,
    /// Angles are worse with the table.
    Worse,
    /// They are not, but the table's line pattern is not that of this disc.
    OtherDisc,
}

impl Verification {
    /// That it rests on a whole turn of intervals at the least.
    ///
    /// # Errors
    /// [`VerifyError::TooLittle`].
    pub fn check_whole_turn(&self) -> Result<(), VerifyError> {
        let (intervals, needed) = (self.scatter.intervals, self.turn_intervals);
        if intervals < needed {
            return Err(VerifyError::TooLittle { intervals, needed });
        }
        Ok(())
    }

    /// Better or worse, by the reference if there is one, else by the scatter of the intervals. A difference below the standard
    /// error of an RMS value of that many samples counts as none.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn verdict(&self) -> Verdict {
        let (count, before, after) = match &self.reference {
            Some(check) => (check.edges, check.before_rad, check.after_rad),
            None => (
                self.scatter.intervals,
                self.scatter.before,
                self.scatter.after,
            ),
        };
        let chance = before / (2.0 * count.max(1) as f64).sqrt();
        if after > before + chance {
            Verdict::Worse
        } else if self.pattern.is_some_and(|pattern| pattern.other_disc()) {
            Verdict::OtherDisc
        } else if after < before - chance {
            Verdict::Better
        } else {
            Verdict::Same
        }
    }
}

/// Checks `slot` on a recording's rows. `source` is the check sum of the recording's start, `clock_hz` its tick rate.
///
/// # Errors
/// [`VerifyError`] when the table and the recording do not belong together, or nothing is left to check on.
pub fn verify(
    slot: &Slot<'_>,
    plan: SensorPlan,
    source: u32,
    clock_hz: u64,
    rows: impl Iterator<Item = Result<Row, ReadError>>,
    reference: Option<Reference>,
) -> Result<Verification, VerifyError> {
    let shape = plan.shape()?;
    if shape != slot.header.shape {
        return Err(VerifyError::Shape {
            table: slot.header.shape.edges(),
            table_classes: slot.header.shape.classes(),
            recording: shape.edges(),
            recording_classes: shape.classes(),
        });
    }
    let same_recording = slot.header.source == source && source != 0;
    let free = plan.anchor() == Anchor::FirstEdge || !slot.header.indexed;
    if free && !same_recording {
        return Err(VerifyError::NotAnchored);
    }
    let after_tick = if same_recording {
        slot.header.learned_until
    } else {
        0
    };

    let mut decoder = plan.decoder()?;
    let mut raw: Corrector<'_> = Corrector::uncorrected(Grid::new(shape));
    let mut corrected = Corrector::new(
        slot.table_at(clock_hz).map_err(VerifyError::Table)?,
        plan.anchor(),
    );
    let mut meter = ScatterMeter::new(shape, plan.gap_edges(), clock_hz);
    let mut comparison = reference.map(|reference| Comparison::new(reference, shape, clock_hz));
    for row in rows {
        let row = row?;
        let outcome = decoder.push(row);
        let (Some(before), Some(after)) = (raw.push(&outcome), corrected.push(&outcome)) else {
            continue;
        };
        let Some(step) = outcome.step() else { continue };
        let anchored = plan.anchor() == Anchor::FirstEdge || step.flags.contains(Flags::REFERENCED);
        let sound = anchored
            && [1, 1 + plan.gap_edges()].contains(&u32::from(step.advance))
            && step.resync == 0
            && !step
                .flags
                .intersects(Flags::TURN_SUSPECT.with(Flags::REVERSED).with(Flags::FIRST));
        if row.ticks <= after_tick || !sound {
            meter.interrupt();
            if let Some(comparison) = &mut comparison {
                comparison.interrupt();
            }
            continue;
        }
        meter.push(step.edge, &before, &after);
        if let Some(comparison) = &mut comparison {
            comparison.push(step.edge, &before, &after);
        }
    }
    let turn_intervals = u64::from(shape.edges() - plan.gap_edges().min(shape.edges()));
    let (scatter, profile) = meter.finish().ok_or(VerifyError::NothingLeft)?;
    let reference = comparison.and_then(Comparison::finish);
    if let Some(misfit) = reference.as_ref().and_then(|found| found.misfit(shape)) {
        return Err(misfit);
    }
    Ok(Verification {
        same_recording,
        turn_intervals,
        pattern: PatternFound::of(&profile, shape.classes() as usize),
        scatter,
        profile,
        reference,
    })
}

impl ReferenceCheck {
    /// The error of a reference that does not go with the recording: it differs from turn to turn by more than what repeats, and by more
    /// than a tenth of the grid's step.
    fn misfit(&self, shape: EncoderShape) -> Option<VerifyError> {
        let step = TAU / f64::from(shape.edges());
        let all = self.before_rad.powi(2);
        let repeating_rad = (all - self.wander_rad.powi(2)).max(0.0).sqrt();
        let wander_rad = self.wander_rad;
        (wander_rad > repeating_rad.max(0.1 * step)).then_some(VerifyError::ReferenceMisfit {
            wander_rad,
            repeating_rad,
        })
    }
}
