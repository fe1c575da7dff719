//! The turns of a calibration: how many were used, and which were thrown out.

use crate::calibrate::{Calibration, RecordingUse};
use crate::report::{Body, Cell};

use super::{figures, words};

/// Rejected turns of a recording that a page lists.
const LISTED: usize = 12;

/// The section on turns.
pub(super) fn section(
    body: &mut Body,
    calibration: &Calibration,
    names: &[String],
    after_rad: f64,
) {
    let first = "The first whole turn of a recording only sets the speed. Turns with faults are left out, not mended.";
    let weight = "A turn counts by the square of its speed, as torque moves a fast shaft less.";
    if calibration.two_speeds() {
        body.section("Turns", &[first, weight]);
    } else {
        body.section("Turns", &[first]);
    }
    figures::turn_table(body, calibration);
    if let Some(plot) = figures::progress(calibration) {
        let more = words::progress(calibration, after_rad).unwrap_or_default();
        body.figure(
            plot,
            format!("How good the table was expected to be after each turn; at the end, {more}."),
        );
    }
    let recordings = || names.iter().zip(&calibration.recordings);
    if names.len() > 1 {
        let rows = recordings().map(|(name, used)| {
            let speeds = words::speeds_r_min(&used.totals, calibration.clock_hz);
            vec![
                name.as_str().into(),
                Cell::fixed(f64::from(used.totals.turns), 0),
                words::speed_range(speeds).into(),
                words::rejected(&used.totals).into(),
            ]
        });
        body.table(
            "Turns of each recording",
            &["Recording", "Turns used", "Speed", "Turns rejected"],
            rows.collect(),
        );
    }
    for (name, used) in recordings() {
        rejected(body, name, used);
    }
}

/// Which turns of a recording were rejected; nothing where none was.
#[allow(clippy::cast_precision_loss)]
fn rejected(body: &mut Body, name: &str, used: &RecordingUse) {
    let turns = used.rejected.listed();
    if turns.is_empty() {
        return;
    }
    let rows = turns.iter().take(LISTED).map(|turn| {
        let (start, duration) = used.seconds_of(turn);
        vec![
            Cell::fixed(turn.number as f64, 0),
            Cell::fixed(start, 3),
            duration.map_or_else(|| "-".into(), |seconds| words::took(seconds).into()),
            words::reason(turn.reason).into(),
        ]
    });
    let all = turns.len() as u64 + used.rejected.more();
    let which = if all > LISTED as u64 {
        format!("The first {LISTED} of {all} turns rejected of {name} (--json lists more)")
    } else {
        format!("Turns rejected of {name}")
    };
    body.table(
        format!("{which}, by number, the first whole turn being 1, and time from the recording's first row"),
        &["Turn", "Begins, s", "Took", "Why"],
        rows.collect(),
    );
}
