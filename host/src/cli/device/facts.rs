//! The results of device commands as text.

use std::time::{Duration, UNIX_EPOCH};

use humantime::format_rfc3339_seconds;
use quadcal::recalibrate::{Figures, Stage};
use quadcal::wire::{Identity, Learned, Status, TableInfo};

use crate::device::stage_text;
use crate::report::si;

use super::super::output::Facts;
use super::summary::{level_name, rad};

pub(super) fn identity(facts: &mut Facts, identity: &Identity) {
    let [major, minor, patch] = identity.firmware;
    facts
        .push("Firmware", format!("{major}.{minor}.{patch}"))
        .push("Protocol version", quadcal::wire::VERSION)
        .push("Table format version", identity.slot_version)
        .push(
            "Encoder",
            format!(
                "{} edges a turn in {} classes",
                identity.edges, identity.classes
            ),
        )
        .push("Serial number", number(identity.serial))
        .push("Clock", format!("{} Hz", identity.clock_hz));
}

/// Seconds since 1970 as a date; those after the year 9999 as they are.
fn date(seconds: u64) -> String {
    const YEAR_10000: u64 = 253_402_300_800;
    match UNIX_EPOCH.checked_add(Duration::from_secs(seconds)) {
        Some(time) if seconds < YEAR_10000 => format_rfc3339_seconds(time).to_string(),
        _ => format!("{seconds} s after 1970"),
    }
}

fn number(serial: u64) -> String {
    match serial {
        0 => "not given".to_owned(),
        serial => serial.to_string(),
    }
}

pub(super) fn status(facts: &mut Facts, status: &Status) {
    facts.push("Calibration", stage_text(status.stage));
    let progress = match status.stage {
        Stage::Solving => Some(format!("{} % solved", status.solved_percent)),
        Stage::Learning | Stage::Proving => {
            Some(format!("{} of {} turns", status.turns, status.turns_wanted))
        }
        _ => None,
    };
    if let Some(progress) = progress {
        facts.push("Progress", progress);
    }
    if status.rejected > 0 {
        facts.push("Turns not usable", status.rejected);
    }
    table(facts, status.table.as_ref());
    let [a, b] = status.wear;
    facts
        .push(
            "Flash erased",
            format!("{a} times at place A, {b} at place B"),
        )
        .push("Session", if status.session { "open" } else { "none" })
        .push("Log level", level_name(status.log_level))
        .push("Unreadable frames", status.bad_frames)
        .push("Up for", format!("{} s", status.uptime_ms / 1000));
}

pub(super) fn table(facts: &mut Facts, table: Option<&TableInfo>) {
    let Some(table) = table else {
        facts.push("Table in use", "none: the encoder runs UNCORRECTED");
        return;
    };
    let place = if table.place == 0 { "A" } else { "B" };
    facts
        .push(
            "Table in use",
            format!(
                "number {} at place {place}, learned from {} turns",
                table.sequence, table.turns
            ),
        )
        .push_si("  Error in it, RMS", rad(table.table_rms), "rad")
        .push_si(
            "  Expected to be left, RMS",
            rad(table.standard_error),
            "rad",
        );
    if table.serial != 0 {
        facts.push("  Of encoder", table.serial);
    }
    if table.learned_at != 0 {
        facts.push("  Learned at", date(table.learned_at));
    }
    if let Some(q4) = table.temperature_q4 {
        facts.push(
            "  Temperature then",
            format!("{:.1} °C", f64::from(q4) / 16.0),
        );
    }
}

/// From this ratio on, it is said how many times as much it is: thousands of percent say little.
const MANIFOLD: f64 = 10.0;

pub(super) fn proof(facts: &mut Facts, figures: &Figures) {
    let [old, new] = [figures.old, figures.new];
    let line = |name: &str, old: u32, new: u32| {
        let ratio = f64::from(new) / f64::from(old.max(1));
        let change = if ratio < MANIFOLD {
            format!("{:+.1} %", 100.0 * (ratio - 1.0))
        } else {
            format!("{ratio:.0} times as much")
        };
        let [old, new] = [old, new].map(|turn32| si(rad(turn32), "rad"));
        (
            name.to_owned(),
            format!("{old} with the old table, {new} with the new ({change})"),
        )
    };
    let more = match figures.rejected {
        0 => String::new(),
        rejected => format!(", {rejected} more not usable"),
    };
    facts.push("Proven on", format!("{} fresh turns{more}", figures.turns));
    for (name, value) in [
        line("  Edge to edge, RMS", old.interval, new.interval),
        line("  Angle over the turn, RMS", old.angle, new.angle),
    ] {
        facts.push(name, value);
    }
    let verdict = if figures.better {
        "certainly better"
    } else if figures.is_worse() {
        "WORSE"
    } else {
        "not certainly better"
    };
    facts.push("  The new table is", verdict);
}

pub(super) fn learned(facts: &mut Facts, learned: &Learned) {
    facts
        .push(
            "Learned from",
            format!("{} turns, {} not usable", learned.turns, learned.rejected),
        )
        .push_si("  Error found, RMS", rad(learned.table_rms), "rad")
        .push_si(
            "  Expected to be left, RMS",
            rad(learned.standard_error),
            "rad",
        );
}
