//! When a task is busy.

use super::stamps::Stamps;
use crate::diagnose::ends::Ends;

/// RMS errors of a stamp within which it may have been held up, and the largest share of the time that this may be.
const WITHIN: f64 = 5.0;
const MOST_LEFT_OUT: f64 = 0.4;

/// A task's busy times.
#[derive(Clone, Debug, PartialEq)]
pub struct Busy {
    /// Its rate, Hz.
    pub f_hz: f64,
    /// How long it blocks, s.
    pub busy_s: f64,
    /// An end of its busy time, about the middle of each recording, s from the clock's zero.
    pub ends_s: Vec<f64>,
}

impl Busy {
    /// The same with ends in the middle of the recordings, where they hang least on the rate.
    #[must_use]
    pub fn centred(mut self, rows: &[Stamps<'_>]) -> Self {
        for (end, row) in self.ends_s.iter_mut().zip(rows) {
            *end += ((row.middle_s() - *end) * self.f_hz).round() / self.f_hz;
        }
        self
    }

    /// Where each recording's stamps are that may have been held up; none where that is most of them.
    #[must_use]
    pub fn ends(&self, rows: &[Stamps<'_>]) -> Vec<Option<Ends>> {
        let each = self.ends_s.iter().zip(rows).enumerate();
        let ends = each.map(|(number, (end_s, row))| {
            let ends = Ends {
                f_hz: self.f_hz,
                end_s: *end_s,
                within_s: WITHIN * row.scatter_s(self, number),
            };
            (ends.share() < MOST_LEFT_OUT).then_some(ends)
        });
        ends.collect()
    }
}
