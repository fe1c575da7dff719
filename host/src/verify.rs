//! How good a table is on a recording: scatter of the intervals and, against a reference encoder, equations (21) and (22).

mod reference;
mod scatter;

use quadcal::corrector::Corrector;
use quadcal::estimate::Anchor;
use quadcal::shape::Grid;
use quadcal::slot::Slot;
use quadcal::step::Flags;
use quadcal::table::TableError;
use thiserror::Error;

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
    /// Scatter of the intervals.
    pub scatter: Scatter,
    /// Mean relative speed at every edge, before and after, and one turn of speed as it was.
    pub profile: Profile,
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
}

impl Verification {
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
    let (scatter, profile) = meter.finish().ok_or(VerifyError::NothingLeft)?;
    Ok(Verification {
        same_recording,
        scatter,
        profile,
        reference: comparison.and_then(Comparison::finish),
    })
}
