//! Edges that a declared task held up: all are stamped when it ends. Where in its busy time they came is not in their stamps, but their
//! neighbours foretell it.

use super::record::Record;
use crate::twin::{CaptureLatency, Twin};

/// Deviations of a stamp within which it counts as one at the end of a busy time.
const NEAR: f64 = 5.0;

/// A task that holds captures up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Task {
    /// Its rate, Hz.
    pub rate_hz: f64,
    /// For how long it blocks them, s.
    pub busy_s: f64,
    /// When it first does, s.
    pub phase_s: f64,
}

/// An edge that was held up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held {
    /// Which one.
    pub at: usize,
    /// Its stamp, s.
    pub stamp_s: f64,
    /// Busy time that it came in, s.
    pub busy_s: [f64; 2],
}

impl Task {
    /// Of a twin that declares one.
    pub fn of(twin: &Twin) -> Option<Self> {
        let CaptureLatency {
            task_hz: Some(rate_hz),
            busy_s: Some(busy_s),
            phase_s,
            ..
        } = twin.capture_latency?
        else {
            return None;
        };
        Some(Self {
            rate_hz,
            busy_s,
            phase_s: phase_s.unwrap_or(0.0),
        })
    }

    /// What a twin says of it.
    pub fn declared(self) -> CaptureLatency {
        CaptureLatency {
            mean_s: None,
            task_hz: Some(self.rate_hz),
            busy_s: Some(self.busy_s),
            phase_s: Some(self.phase_s),
        }
    }

    /// Stamps at the ends of its busy times, for a clock with so much jitter; none where that is as long.
    pub fn held(&self, time_s: &[f64], near_s: f64) -> Vec<Held> {
        if self.busy_s <= NEAR * near_s {
            return Vec::new();
        }
        let first_s = self.phase_s + self.busy_s;
        let each = time_s.iter().enumerate().filter_map(|(at, time_s)| {
            let period = ((time_s - first_s) * self.rate_hz).round().max(0.0);
            let end_s = first_s + period / self.rate_hz;
            ((time_s - end_s).abs() <= NEAR * near_s).then_some(Held {
                at,
                stamp_s: *time_s,
                busy_s: [end_s - self.busy_s, end_s],
            })
        });
        each.collect()
    }

    /// How many stamps are within its busy times and not at their ends: none, if it holds captures up.
    pub fn denied(&self, time_s: &[f64], near_s: f64) -> usize {
        let first_s = self.phase_s + self.busy_s;
        let each = time_s.iter().filter(|time_s| {
            let left = ((first_s - *time_s) * self.rate_hz).rem_euclid(1.0) / self.rate_hz;
            **time_s > self.phase_s && left > NEAR * near_s && left < self.busy_s - NEAR * near_s
        });
        each.count()
    }
}

/// Puts edges that were held up where their neighbours say they came, for edges that are off the grid by known angles, rad.
pub fn release(record: &mut Record, off: &[f64]) {
    let held = record.held.clone();
    for run in held.chunk_by(|one, next| one.at + 1 == next.at) {
        let (first, last) = (run[0].at, run[run.len() - 1].at);
        for Held {
            at,
            busy_s: [begins_s, ends_s],
            ..
        } in run
        {
            let foretold_s = between(record, off, first, last, *at);
            let time_s = foretold_s.unwrap_or(0.5 * (begins_s + ends_s));
            record.time_s[*at] = time_s.clamp(*begins_s, *ends_s);
            record.doubt_s[*at] = (ends_s - begins_s) / 12_f64.sqrt();
        }
    }
}

/// Gives edges that were held up their stamps again.
pub fn restore(record: &mut Record) {
    for Held { at, stamp_s, .. } in std::mem::take(&mut record.held) {
        record.time_s[at] = stamp_s;
        record.doubt_s[at] = 0.0;
    }
}

/// Time at which a shaft of constant speed passes an edge of a run of them between two others that are known; none where it turns round.
fn between(record: &Record, off: &[f64], first: usize, last: usize, at: usize) -> Option<f64> {
    let before = first.checked_sub(1)?;
    let after = Some(last + 1).filter(|after| *after < record.len())?;
    let mut ways = record.way[before..=after].windows(2);
    let angle = |at: usize| record.grid_rad(at) - off[at];
    let share = (angle(at) - angle(before)) / (angle(after) - angle(before));
    let (from_s, until_s) = (record.time_s[before], record.time_s[after]);
    (ways.all(|pair| pair[0] == pair[1]) && share.is_finite())
        .then_some(from_s + share * (until_s - from_s))
}
