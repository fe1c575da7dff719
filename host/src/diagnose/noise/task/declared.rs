//! A task that a twin declares, taken off its recording: where its busy times are nobody knows, and a clock may be off, so both are
//! fitted; its rate and how long it blocks are the twin's, and have to be the recording's.

use super::super::super::board::Board;
use super::super::super::run::Recorded;
use super::super::NoiseFinding;
use super::DOUBT;
use super::busy::Busy;
use super::fit::{Fitted, fitted};
use super::folded::{near, rough, spectrum};
use super::period::{by_pulses, late, pulses};
use super::stamps::Stamps;
use crate::diagnose::ends::Ends;
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

/// Notes in each recording where a task of about the rate that its twin declares held captures up, if one did; whether any did.
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
        let Some((f_hz, _)) = declared(&one.twin) else {
            continue;
        };
        let row = Stamps::of(bench, left);
        let found = seen(&row, &spectrum(bench, left), f_hz)
            .filter(|(found, _)| found.gain > THERE && same_rate(found.task.f_hz, f_hz));
        one.track.ends =
            found.and_then(|(found, row)| found.task.ends(&[row]).into_iter().flatten().next());
        any |= one.track.ends.is_some();
    }
    any
}

/// Whether the tasks that were noted block as long as the twins' do; `open` has their delays in it, `board` has not. Where one does not, it
/// is taken back.
pub fn confirm(rig: &mut [Recorded], open: &Board, board: &Board) -> bool {
    let held: Vec<Option<Ends>> = rig.iter().map(|one| one.track.ends).collect();
    let longest = rig.iter().filter_map(|one| declared(&one.twin));
    let longest_s = longest.fold(0.0, |longest: f64, (_, busy_s)| longest.max(busy_s));
    let other = open.in_doubt(&held, DOUBT * longest_s, board);
    let left = other.fit(other.nuisances()).map(|model| model.left);
    let mut all = true;
    for (number, one) in rig.iter_mut().enumerate() {
        let (Some(ends), Some((f_hz, busy_s))) = (one.track.ends, declared(&one.twin)) else {
            continue;
        };
        let task = Busy {
            f_hz: ends.f_hz,
            busy_s,
            ends_s: vec![ends.end_s],
        };
        let same = left.as_ref().is_some_and(|left| {
            let mut rows = [Stamps::of(&other.benches[number], &left[number])];
            fitted(&mut rows, task).is_some_and(|found| {
                let own = [found.task.f_hz, found.task.busy_s];
                let passed = rows[0].passed(&found.task, 0);
                same(own, found.errors[1], [f_hz, busy_s])
                    && passed < PASS * found.held + PASS_AT_ALL
            })
        });
        if !same {
            one.track.ends = None;
            all = false;
        }
    }
    all
}

/// Whether a task that was found is the one that a twin declares.
#[must_use]
pub fn agrees(finding: &NoiseFinding, twin: &Twin) -> bool {
    let named = |name: &str| finding.parameters.iter().find(|one| one.name == name);
    let (Some(rate), Some(busy)) = (named("task_hz"), named("busy_s")) else {
        return false;
    };
    declared(twin).is_some_and(|(f_hz, busy_s)| {
        same(
            [rate.value, busy.value],
            busy.standard_error,
            [f_hz, busy_s],
        )
    })
}

/// Rate and busy time of a twin's task.
#[must_use]
pub fn declared(twin: &Twin) -> Option<(f64, f64)> {
    let latency = twin.capture_latency?;
    latency.task_hz.zip(latency.busy_s)
}

fn same(found: [f64; 2], error_s: f64, twin: [f64; 2]) -> bool {
    same_rate(found[0], twin[0])
        && (found[1] - twin[1]).abs() < (DEVIATIONS * error_s).max(PART * twin[1])
}

fn same_rate(found_hz: f64, twin_hz: f64) -> bool {
    (found_hz / twin_hz - 1.0).abs() < CLOCKS
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
