//! The rows of a free run, one by one.

use super::crossing::Crossing;
use super::push::Pushed;
use super::recover::{FINER, FreeRun, steady};
use crate::recording::{ReadError, Row};
use crate::sensor::Decoder;

/// An iterator of a free run's rows over those of its recording.
pub struct FreeRows<I> {
    run: FreeRun,
    rows: I,
    decoder: Decoder,
    pushed: Pushed,
    last: u64,
}

impl<I> FreeRows<I> {
    pub(super) fn new(run: &FreeRun, rows: I) -> Self {
        Self {
            run: run.clone(),
            rows,
            decoder: run.decoder.clone(),
            pushed: run.push.start(run.clock_hz, run.step_rad, run.from),
            last: 0,
        }
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
        let later = self.run.later(row.ticks, &made);
        if let Some(crossing) = Crossing::of(&self.decoder.push(row), self.run.anchor) {
            self.pushed.edge(&crossing);
        }
        let clock = self.run.clock_hz;
        let later = (later * clock as f64 * FINER as f64).round() as i64;
        let free = steady(row.ticks, clock).saturating_add_signed(later);
        // Times of a recording never fall, whatever the torque.
        self.last = free.max(self.last);
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

/// `rows` as they are, or those of the free run behind them.
pub fn rows<'a, I>(
    run: Option<&FreeRun>,
    rows: I,
) -> Box<dyn Iterator<Item = Result<Row, ReadError>> + 'a>
where
    I: Iterator<Item = Result<Row, ReadError>> + 'a,
{
    match run {
        Some(run) => Box::new(run.rows(rows)),
        None => Box::new(rows),
    }
}
