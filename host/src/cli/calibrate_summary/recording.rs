//! What one recording gave to a calibration, as in the JSON.

use quadcal::estimate::Totals;
use serde::Serialize;

use crate::calibrate::{self, RecordingUse};
use crate::reports::words;
use crate::showcase::Showcase;

/// What one recording gave.
#[derive(Debug, Serialize)]
pub(super) struct Recording {
    file: String,
    seconds: f64,
    turns: Turns,
    /// The first thousand turns rejected, in their order.
    turns_rejected: Vec<RejectedTurn>,
    /// How many more were.
    turns_rejected_not_listed: u64,
    learned_until_tick: u64,
    later_turns: Option<LaterTurns>,
}

/// The table on turns after those learned from.
#[derive(Debug, Serialize)]
struct LaterTurns {
    scatter_before: f64,
    scatter_after: f64,
    worse: bool,
}

#[derive(Debug, Serialize)]
pub(super) struct Turns {
    used: u32,
    broken: u32,
    irregular: u32,
    speed_change: u32,
    disagrees: u32,
    slowest_rev_per_min: f64,
    fastest_rev_per_min: f64,
}

/// A turn that was not learned from.
#[derive(Debug, Serialize)]
struct RejectedTurn {
    /// Its number in the recording: 1 is the first whole turn.
    turn: u64,
    /// When it began, from the recording's first row on.
    start_s: f64,
    /// How long it took; null where the recording ends within it.
    seconds: Option<f64>,
    /// The key of its count in `turns`.
    reason: &'static str,
    /// The same in words.
    why: &'static str,
}

impl Turns {
    pub(super) fn of(totals: &Totals, clock_hz: u64) -> Self {
        let [slowest, fastest] = words::speeds_r_min(totals, clock_hz);
        Self {
            used: totals.turns,
            broken: totals.broken,
            irregular: totals.irregular,
            speed_change: totals.speed_change,
            disagrees: totals.disagrees,
            slowest_rev_per_min: slowest,
            fastest_rev_per_min: fastest,
        }
    }
}

impl Recording {
    pub(super) fn of(name: &str, used: &RecordingUse, shown: &Showcase) -> Self {
        let rejected = |turn: &calibrate::RejectedTurn| {
            let (start_s, seconds) = used.seconds_of(turn);
            RejectedTurn {
                turn: turn.number,
                start_s,
                seconds,
                reason: words::reason_id(turn.reason),
                why: words::reason(turn.reason),
            }
        };
        Self {
            file: name.to_owned(),
            seconds: used.survey.seconds(),
            turns: Turns::of(&used.totals, used.survey.header.clock_hz),
            turns_rejected: used.rejected.listed().iter().map(rejected).collect(),
            turns_rejected_not_listed: used.rejected.more(),
            learned_until_tick: used.learned_until,
            later_turns: shown.later.then(|| LaterTurns {
                scatter_before: shown.check.scatter.before,
                scatter_after: shown.check.scatter.after,
                worse: shown.worse_later(),
            }),
        }
    }
}
