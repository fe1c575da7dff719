//! A task that a twin declares, taken off its recording: where its busy times are nobody knows, and a clock may be off, so both are
//! fitted; its rate and how long it blocks are the twin's, and have to be the recording's.

use super::super::super::board::Board;
use super::super::super::run::Recorded;
use super::super::NoiseFinding;
use super::fit::{Fitted, fitted};
use super::folded::{near, rough, spectrum};
use super::period::{by_pulses, late, pulses};
use super::busy::Busy;
use super::stamps::Stamps;
use super::stands;
use crate::diagnose::spectrum::Spectrum;
use crate::twin::Twin;

/// Part by which clocks of rig and twin may differ.
const CLOCKS: f64 = 3e-4;
/// Standard errors, and part of it, by which a busy time may be another than the twin's.
const DEVIATIONS: f64 = 5.0;
const PART: f64 = 0.02;
/// Gain in the logarithm of the likelihood from which on a task is there: its rate is known, its phase is not.
const THERE: f64 = 10.0;
/// Edges that pass through busy times, as a share of those that are held up and at all, from which on it is no such task.
const PASS: f64 = 0.1;
const PASS_AT_ALL: f64 = 3.0;

/// Notes in each recording where the task that its twin declares held captures up, if it did; whether any did.
pub fn account(rig: &mut [Recorded], board: &Board) -> bool {
    if !rig.iter().any(|one| declared(&one.twin).is_some()) {
        return false;
    }
    let model = board.fit(board.nuisances());
    let Some(left) = model.map(|model| model.left) else {
        return false;
    };
    let mut any = false;
    for ((one, bench), left) in rig.iter_mut().zip(&board.benches).zip(&left) {
        let Some((f_hz, busy_s)) = declared(&one.twin).filter(|_| !stands(bench)) else {
            continue;
        };
        let row = Stamps::of(bench, left);
        let found = seen(&row, &spectrum(bench, left), f_hz).filter(|(found, row)| {
            let own = [found.task.f_hz, found.task.busy_s];
            found.gain > THERE
                && same(own, found.errors[1], [f_hz, busy_s])
                && row.passed(&found.task, 0) < PASS * found.held + PASS_AT_ALL
        });
        one.track.ends =
            found.and_then(|(found, row)| found.task.ends(&[row]).into_iter().flatten().next());
        any |= one.track.ends.is_some();
    }
    any
}

/// Whether a task that was found is the one that a twin declares.
#[must_use]
pub fn agrees(finding: &NoiseFinding, twin: &Twin) -> bool {
    let named = |name: &str| finding.parameters.iter().find(|one| one.name == name);
    let (Some(rate), Some(busy)) = (named("task_hz"), named("busy_s")) else {
        return false;
    };
    declared(twin).is_some_and(|(f_hz, busy_s)| {
        same([rate.value, busy.value], busy.standard_error, [f_hz, busy_s])
    })
}

/// Rate and busy time of a twin's task.
fn declared(twin: &Twin) -> Option<(f64, f64)> {
    let latency = twin.capture_latency?;
    latency.task_hz.zip(latency.busy_s)
}

fn same(found: [f64; 2], error_s: f64, twin: [f64; 2]) -> bool {
    (found[0] / twin[0] - 1.0).abs() < CLOCKS
        && (found[1] - twin[1]).abs() < (DEVIATIONS * error_s).max(PART * twin[1])
}

/// The likeliest task of about a rate in a recording, and the recording without it.
fn seen<'a>(row: &Stamps<'a>, left: &Spectrum, f_hz: f64) -> Option<(Fitted, Stamps<'a>)> {
    let rows = std::slice::from_ref(row);
    let late = late(row);
    let rates = [
        f_hz,
        strongest(&pulses(row, &late), f_hz),
        strongest(left, f_hz),
    ];
    let by_pulses = rates.iter().filter_map(|rate| by_pulses(row, &late, *rate));
    let by_rhythm = rates.iter().filter_map(|rate| rough(rows, *rate));
    let tried = by_pulses.chain(by_rhythm).filter_map(|task: Busy| {
        let mut rows = [row.clone()];
        let fitted = fitted(&mut rows, task)?;
        let [row] = rows;
        Some((fitted, row))
    });
    tried.max_by(|a, b| a.0.gain.total_cmp(&b.0.gain))
}

/// The rate within what clocks differ that stands out most.
fn strongest(spectrum: &Spectrum, f_hz: f64) -> f64 {
    let steps = (CLOCKS * f_hz / spectrum.step).ceil() as i32;
    let rates = (-steps..=steps).map(|step| f_hz + f64::from(step) * spectrum.step);
    let best = rates.max_by(|a, b| near(spectrum, *a).total_cmp(&near(spectrum, *b)));
    best.unwrap_or(f_hz)
}
