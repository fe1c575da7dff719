//! The rows of a free run, one by one.

use super::crossing::Crossing;
use super::recover::{FINER, FreeRun, Pushed};
use crate::recording::{ReadError, Row};
use crate::sensor::{Decoder, PlanError};

/// An iterator of a free run's rows over those of its recording.
pub struct FreeRows<I> {
    run: FreeRun,
    rows: I,
    decoder: Decoder,
    pushed: Pushed,
    last: u64,
}

impl<I> FreeRows<I> {
    pub(super) fn new(run: &FreeRun, rows: I) -> Result<Self, PlanError> {
        Ok(Self {
            run: run.clone(),
            rows,
            decoder: run.plan.decoder()?,
            pushed: run.push.start(run.clock_hz, run.step_rad, run.from),
            last: 0,
        })
    }

    /// The recording's own rows.
    pub fn recorded(&self) -> &I {
        &self.rows
    }

    #[allow(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss
    )]
    fn free(&mut self, row: Row) -> Row {
        let made = self.pushed.reach(row.ticks);
        let displacement = self.run.displacement(row.ticks, &made);
        if let Some(crossing) = Crossing::of(&self.decoder.push(row)) {
            self.pushed.edge(&crossing);
        }
        let clock = self.run.clock_hz;
        let later = (displacement / self.run.speed * clock as f64 * FINER as f64).round() as i64;
        // A second is more than any loop holds a shaft back; times never fall.
        let steady = row.ticks.saturating_add(clock).saturating_mul(FINER);
        self.last = steady.saturating_add_signed(later).max(self.last);
        Row {
            ticks: self.last,
            levels: row.levels,
        }
    }
}

impl<I> Iterator for FreeRows<I>
where
    I: Iterator<Item = Result<Row, ReadError>>,
{
    type Item = Result<Row, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        let row = self.rows.next()?;
        Some(row.map(|row| self.free(row)))
    }
}
